#pragma once

#include <Eigen/Core>
#include <span>

#include "model/kinematic_tree.h"
#include "model/musculoskeletal_model.h"

namespace sinew {

/// Length of the polyline through the points of `path` [m], at the poses and coordinates in
/// `workspace` (update_poses() is enough):
///
///     l = Σ_i |p_W(i+1) − p_Wi|
///
/// A conditional point is on the path while its coordinate is within its range, ends included. A
/// moving point stands where its functions put it; one without a coordinate uses its function of
/// zero, as OpenSim does. Surfaces to wrap over are not treated. Throws std::invalid_argument where
/// a point depends on a coordinate that has no q (joints that step as quaternions).
/// O(points).
double path_length(const PathElement& path, const KinematicTree& tree,
                   const KinematicWorkspace& workspace);

/// Moment arms of `path` about every unknown x: −∂l/∂x, positive where a pull shortens the path by
/// increasing x (An KN, Takahashi K, Harrigan TP, Chao EY (1984) J Biomech Eng 106:280-282) [m, or
/// m/m for shifts]. A unit of tension pulls on the points, and one inward sweep turns that into
/// joint torques; couplings and moving points are included. A point where two neighbours coincide
/// gives no pull along that piece.
///
/// Needs update_kinematics(); overwrites workspace.F, f and g. arms: unknowns. Throws as
/// path_length does, and std::invalid_argument if `arms` has another size. O(links + points).
void moment_arms(const PathElement& path, const KinematicTree& tree, KinematicWorkspace& workspace,
                 std::span<double> arms);

}  // namespace sinew
