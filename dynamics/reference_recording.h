#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "data/marker_trajectories.h"
#include "data/reference_walk.h"
#include "data/time_table.h"
#include "data/tool_setup.h"
#include "model/kinematic_tree.h"
#include "model/musculoskeletal_model.h"
#include "model/scalar_function.h"
#include "model/simbody.h"
#include "model/simbody_model.h"
#include "model/spatial.h"

namespace sinew {

struct ReferenceRecordingOptions {
  double strides = 2.0;        // > 0
  double marker_rate = 100.0;  // [Hz]
  double force_rate = 1000.0;  // [Hz]
  /// Standard deviation of normal noise on each coordinate of each marker [m]. Some 0.5 mm is what
  /// optical systems have. The forces stay exact.
  double marker_noise = 0.0;
  /// Part of each marker's samples that is lost, in gaps of 0.1 s; below 1.
  double occlusion = 0.0;
  std::uint64_t seed = 1;  // of noise and gaps

  /// Throws std::invalid_argument naming field, value and bound.
  void validate() const;
};

/// What a laboratory would record of a walk, and what it would give much to know.
struct ReferenceRecording {
  MusculoskeletalModel model;
  MarkerTrajectories markers;
  TimeTable forces;  // ground_force_r_vx … [N], …_px … [m], ground_torque_r_x … [N m];
                     // all of a foot's columns are 0 while it is in the air
  ExternalLoadsSetup loads;    // bound to the columns of `forces`
  TimeTable true_coordinates;  // at the markers' times; every coordinate of the model [rad or m]
  TimeTable true_forces;       // at the markers' times; labels and convention as
                               // generalized_forces, couplers ignored
};

/// Makes the recording of a walk. The motion is given, with exact derivatives; what the floor must
/// do follows:
///  1. inverse dynamics without loads gives the wrench that moves the root, which nothing but the
///     floor can supply: its resultant is F, its moment about the world's origin M;
///  2. F acts at the centre of pressure c on the floor, c_x = M_z / F_y, c_z = −M_x / F_y, besides
///     the free moment about the vertical;
///  3. feet share the resultant, see share_wrench;
///  4. inverse dynamics with these loads gives the true torques; the root's are zero to rounding.
/// Throws InputError if the model or a curve cannot be used, std::invalid_argument for bad options
/// and if the floor would have to pull.
ReferenceRecording make_reference_recording(const ReferenceWalk& walk,
                                            const ReferenceRecordingOptions& options = {});
/// Of the embedded walk.
ReferenceRecording make_reference_recording(const ReferenceRecordingOptions& options = {});

/// The walk's motion in the coordinates of a model: a curve's coordinate follows it, a coupled one
/// its coupler, all others stay at their defaults. Periodic but for the advance.
class ReferenceMotion {
 public:
  /// Throws InputError if a curve names no coordinate of the model or one that is coupled.
  ReferenceMotion(const MusculoskeletalModel& model, const ReferenceWalk& walk);

  /// By coordinate, at any time.
  void evaluate(double time, std::span<double> q, std::span<double> q_dot,
                std::span<double> q_ddot) const;

 private:
  struct Coupler {
    std::size_t dependent, independent;
    CompiledFunction function;
  };
  std::vector<WalkCurve> curves_;
  std::vector<std::size_t> coordinates_;  // of each curve
  std::vector<Coupler> couplers_;
  std::vector<double> defaults_;
  double stride_time_;
};

/// Force on a foot, at a point of the floor, and torque, about the vertical; all in the world.
struct FootLoad {
  Eigen::Vector3d force = Eigen::Vector3d::Zero();   // [N]
  Eigen::Vector3d point = Eigen::Vector3d::Zero();   // [m]
  Eigen::Vector3d torque = Eigen::Vector3d::Zero();  // [N m]
};

/// Shares the floor's wrench on the body, [moment about the world's origin; force], among the feet
/// such that their loads together are exactly that wrench and each foot's load is a twice
/// continuously differentiable function of time:
///   f_y,i = s_i F_y                         s_i: smooth steps over double support, Σ s_i = 1
///   c_i = p_i + (c − Σ s_j p_j)             p_i: where the foot's centre of pressure should be
///   f_h,i = s_i F_y (C − c_i)_h / C_y + s_i e_h
/// with mass centre C and e_h what the forces towards it leave of F_h: in double support the feet
/// push against each other as walking feet do. The free moment is shared as s_i.
/// Throws std::invalid_argument if F_y is not positive.
std::vector<FootLoad> share_wrench(const ReferenceWalk& walk, double time,
                                   const Eigen::Vector3d& p_WC, const Vector6d& wrench);

/// Inverse dynamics at given positions, velocities and accelerations, without any splines between.
class ReferenceDynamics {
 public:
  /// Throws InputError if the root has not six coordinates, or if a joint's speeds are not the
  /// rates of its coordinates.
  explicit ReferenceDynamics(const MusculoskeletalModel& model);

  /// q, q̇, q̈ by coordinate. The functions below are about this state.
  void set_motion(std::span<const double> q, std::span<const double> q_dot,
                  std::span<const double> q_ddot);

  Eigen::Vector3d mass_center() const;
  /// What must act on the body besides gravity: [moment about the world's origin; force].
  Vector6d required_wrench();
  /// By coordinate; `bodies` are those that `loads` act on.
  Eigen::VectorXd generalized_forces(std::span<const int> bodies, std::span<const FootLoad> loads);

 private:
  Eigen::VectorXd solve(const SimTK::Vector_<SimTK::SpatialVec>& applied);

  MusculoskeletalModel model_;
  SimbodyModel compiled_;
  KinematicTree tree_;
  KinematicWorkspace kinematics_;
  SimTK::State state_;
  SimTK::Vector u_dot_, residual_;
  SimTK::Vector_<SimTK::SpatialVec> gravity_, applied_;
};

}  // namespace sinew
