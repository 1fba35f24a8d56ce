#pragma once

#include <Eigen/Core>
#include <vector>

#include "data/marker_trajectories.h"
#include "data/verdict_reason.h"
#include "ik/tracking.h"
#include "model/musculoskeletal_model.h"

namespace sinew {

/// Step of an angle from one frame to the next beyond which it jumps [rad]: 30°, or 1000°/s where
/// frames are more than 0.03 s apart, but never more than half a turn. Nothing in walking or
/// running turns faster than that (the knee swings at 400 to 700°/s).
double jump_limit(double seconds_between_frames);

/// Angles that jump: a reason "jump" for every turning coordinate that steps by more than
/// jump_limit(), with the largest step and its time, how many there are, and the coordinates whose
/// torques it spoils: between the root and the end of the chain that the joint is in. The result
/// cannot be used where the root itself jumps. time: frames [s]; coordinates: frames × coordinates
/// of the model [rad or m].
std::vector<VerdictReason> angle_jumps(const MusculoskeletalModel& model,
                                       const Eigen::VectorXd& time, const RowMatrix& coordinates);

/// Of solved inverse kinematics.
std::vector<VerdictReason> angle_jumps(const MusculoskeletalModel& model,
                                       const TrackingResult& result);

}  // namespace sinew
