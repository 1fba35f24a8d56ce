#pragma once

#include <Eigen/Core>
#include <span>

#include "dynamics/floor_forces.h"
#include "model/kinematic_tree.h"
#include "model/musculoskeletal_model.h"
#include "model/simbody.h"
#include "model/simbody_model.h"
#include "model/skeleton.h"

namespace sinew {

/// Inverse dynamics at given positions, velocities and accelerations, without any splines between.
class ReferenceDynamics {
 public:
  /// Leaves virtual links out. Throws InputError if the root has not six coordinates, or if a
  /// joint's speeds are not the rates of its coordinates.
  explicit ReferenceDynamics(const MusculoskeletalModel& model);

  /// q, q̇, q̈ by coordinate of the model. The functions below are about this state.
  void set_motion(std::span<const double> q, std::span<const double> q_dot,
                  std::span<const double> q_ddot);

  Eigen::Vector3d mass_center() const;
  /// What must act on the body besides gravity: [moment about the world's origin; force].
  Vector6d required_wrench();
  /// By coordinate of the model, zero for virtual links; `bodies` of the model are those that
  /// `loads` act on.
  Eigen::VectorXd generalized_forces(std::span<const int> bodies, std::span<const FloorLoad> loads);

 private:
  Eigen::VectorXd solve(const SimTK::Vector_<SimTK::SpatialVec>& applied);

  Skeleton skeleton_;
  std::size_t coordinate_count_;  // of the model
  SimbodyModel compiled_;
  KinematicTree tree_;
  KinematicWorkspace kinematics_;
  SimTK::State state_;
  SimTK::Vector u_dot_, residual_;
  SimTK::Vector_<SimTK::SpatialVec> gravity_, applied_;
};

}  // namespace sinew
