#pragma once

#include <Eigen/Core>
#include <memory>
#include <span>
#include <vector>

#include "model/musculoskeletal_model.h"
#include "model/simbody.h"

namespace sinew {

/// The model compiled into Simbody: the reference for dynamics, for the Assembler and for every
/// check of KinematicTree. Each joint becomes Simbody's own mobilizer of that kind (kCustom:
/// FunctionBased), with Euler angles for kBall and kFree so that q is what the file calls it.
/// Immutable after construction; every caller keeps States of its own. Couplers, locks and clamps
/// are not part of the system by default: the IK eliminates them and inverse dynamics ignores them.
///
/// Massless bodies, such as virtual links, are in the system as they are, with mass 0 and inertia
/// 0. Positions, velocities, Jacobians and inverse dynamics are exact: such a body asks for no
/// force of its own and changes nobody else's. Forward dynamics is not: on a free joint no
/// acceleration follows from a force on nothing, the articulated inertia cannot be inverted and
/// Simbody throws. Realize no further than Stage::Dynamics.
class SimbodyModel {
 public:
  struct Options {
    bool couplers_as_constraints = false;  // Constraint::CoordinateCoupler each
    bool loops_as_constraints = false;     // welds and point constraints
  };

  /// Throws InputError for what Simbody cannot hold. `model` must have passed validate().
  explicit SimbodyModel(const MusculoskeletalModel& model);
  SimbodyModel(const MusculoskeletalModel& model, const Options& options);

  const SimTK::MultibodySystem& system() const { return *system_; }
  const SimTK::SimbodyMatterSubsystem& matter() const { return *matter_; }

  /// A State with Euler angles, realized to Model, all coordinates at their defaults.
  SimTK::State default_state() const { return default_state_; }

  int body_count() const { return static_cast<int>(bodies_.size()); }  // with ground
  int coordinate_count() const { return static_cast<int>(q_index_.size()); }
  SimTK::MobilizedBodyIndex body(int body_index) const { return bodies_[body_index]; }
  /// Where a coordinate of the description stands in the State's q, and its speed in u.
  int q_index(int coordinate) const { return q_index_[coordinate]; }
  int u_index(int coordinate) const { return u_index_[coordinate]; }
  /// The mobilizer that carries a coordinate, and which of that mobilizer's q it is.
  SimTK::MobilizedBodyIndex mobilizer(int coordinate) const { return mobilizer_[coordinate]; }
  SimTK::MobilizerQIndex mobilizer_q(int coordinate) const { return mobilizer_q_[coordinate]; }

  /// q in the description's order → the State's. q: coordinates [rad or m].
  void set_q(SimTK::State& state, std::span<const double> q) const;
  void get_q(const SimTK::State& state, std::span<double> q) const;

 private:
  void add_constraints(const MusculoskeletalModel& model, const Options& options);
  void index_coordinates(const MusculoskeletalModel& model);

  std::unique_ptr<SimTK::MultibodySystem> system_;
  std::unique_ptr<SimTK::SimbodyMatterSubsystem> matter_;
  std::unique_ptr<SimTK::GeneralForceSubsystem> forces_;
  std::vector<SimTK::MobilizedBodyIndex> bodies_;
  std::vector<SimTK::MobilizedBodyIndex> mobilizer_;  // per coordinate
  std::vector<SimTK::MobilizerQIndex> mobilizer_q_;   // per coordinate
  std::vector<int> q_index_, u_index_;                // per coordinate
  SimTK::State default_state_;
};

inline Eigen::Vector3d to_eigen(const SimTK::Vec3& v) { return {v[0], v[1], v[2]}; }
inline SimTK::Vec3 to_simtk(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }
RigidTransform to_eigen(const SimTK::Transform& X);
SimTK::Transform to_simtk(const RigidTransform& X);

}  // namespace sinew
