#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "data/coordinate_spline.h"
#include "data/input_error.h"
#include "data/time_table.h"
#include "dynamics/coordinate_table.h"
#include "dynamics/external_loads.h"
#include "model/musculoskeletal_model.h"
#include "model/simbody_model.h"

namespace sinew {

struct InverseDynamicsOptions {
  /// Zero-lag low-pass of the coordinates before they are differentiated [Hz], below half their
  /// sampling rate; negative: none, OpenSim's default.
  double cutoff = -1.0;
  /// Frames to solve [s]; the record's ends where empty. A frame within a thousandth of a step of
  /// an end belongs to the range, because files print times rounded.
  std::optional<double> from = {}, to = {};
  /// false: OpenSim's convention. Couplers are ignored: a dependent coordinate (a patella's, say)
  /// moves as the file says, or stays at its default, and has a column of its own.
  /// true: a dependent coordinate moves as its coupler says and its force is folded onto the
  /// independent one, tau_i += f'(q_i)·tau_d. That is the torque which an actuator of coordinate i
  /// would have to give. Dependent columns are left out.
  bool project_couplers = false;
  /// false: accelerations of custom joints as Simbody, and so OpenSim, computes them, which
  /// published torques contain; inverse_dynamics warns where they are wrong. true: exact
  /// accelerations, see CustomJointCorrection. In walking Rajagopal bodies
  /// (tests/dynamics/published_inverse_dynamics_test) the hips' torques change by 0.5 % to 0.8 % of
  /// their range, the pelvis' residual by up to 1 N m.
  bool exact_custom_joints = false;
  /// Threads to use; 0: as many as the machine has. The result's bytes do not depend on it.
  int threads = 0;
  /// Called from time to time, from any thread but one at a time, with the number of frames done;
  /// return false to stop early.
  std::function<bool(int done, int total)> progress = {};

  /// Throws std::invalid_argument naming field, value and bound.
  void validate() const;
};

struct InverseDynamicsResult {
  TimeTable forces;  // see generalized_forces
  std::vector<Warning> warnings;
  bool stopped = false;  // `progress` asked to stop; rows that were not solved are NaN
};

/// Generalized forces at given times: what actuators of the coordinates would have to give for the
/// model to move as `motion` says under gravity and `loads`,
///   tau = M(q)·u̇ + c(q, u) − J(q)ᵀ·F,                                                          (1)
///   u = N(q)⁻¹·q̇,   u̇ = N(q)⁻¹·(q̈ − Ṅ·u),                                                    (2)
/// by the recursive Newton-Euler algorithm (Featherstone 2008, ch. 5; Simbody's
/// calcResidualForceIgnoringConstraints). Muscles and all other forces of the model are left out;
/// locks and prescribed functions are ignored, as in OpenSim: the motion is what `motion` says.
///
/// motion: the model's coordinates in its order [rad, m]. times [s], within motion.
/// Returns times.size() rows; columns in the model's order, without those of virtual links,
/// `<coordinate>_moment` [N m] for rotational coordinates, `<coordinate>_force` [N] for all others.
/// Each is the force that works on its coordinate's rate, so that tau·q̇ is the power; for ball and
/// free joints, whose speeds are angular velocities, that is N⁻ᵀ times the force on the speeds.
/// (OpenSim's tool takes q̇ for u there, which is wrong as soon as the joint turns about more than
/// one axis.) Frames are solved in parallel; O(bodies) a frame. Where options.progress stops the
/// work, the rows that were not solved are NaN. Throws InputError if `loads` do not cover `times`,
/// std::invalid_argument if sizes differ.
TimeTable generalized_forces(const MusculoskeletalModel& model, const SimbodyModel& compiled,
                             const CoordinateSpline& motion, const ExternalLoads& loads,
                             const Eigen::VectorXd& times, const InverseDynamicsOptions& options);

/// Inverse dynamics of a recorded motion: filters (options.cutoff), differentiates (quintic
/// splines) and solves every recorded frame in range. Unlike OpenSim, which reports at the times of
/// its resampled record, rows stand at the recorded times themselves. Throws InputError naming the
/// motion's file if it is too short to be differentiated or filtered, if the cutoff is not below
/// half its sampling rate, or if no frame is in range.
InverseDynamicsResult inverse_dynamics(const MusculoskeletalModel& model,
                                       const SimbodyModel& compiled, const CoordinateTable& motion,
                                       const ExternalLoads& loads,
                                       const InverseDynamicsOptions& options = {});

/// The spline that inverse_dynamics differentiates: through the samples, or through the filtered
/// ones and their padding. Throws as inverse_dynamics does.
CoordinateSpline motion_spline(const MusculoskeletalModel& model, const CoordinateTable& motion,
                               double cutoff);

}  // namespace sinew
