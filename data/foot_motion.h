#pragma once

#include <Eigen/Core>
#include <vector>

#include "data/foot_assignment.h"

namespace sinew {

/// What a foot does in every frame of a recording.
struct FootMotion {
  std::vector<std::vector<Eigen::Vector3d>> markers;  // measured ones, by frame [m]
  // Its slowest marker moves by less than 0.7 m/s; false where it is not measured.
  std::vector<bool> stands;
};
FootMotion foot_motion(const MarkerTrajectories& markers, const Foot& foot);

/// How far a point lies outside of a platform's edges, seen from above; negative inside [m].
double distance_outside(const ForcePlatform& platform, const Eigen::Vector3d& p_W);

/// The least distance from a point to a line between two markers, seen from above, y up [m].
double distance_to_foot(const std::vector<Eigen::Vector3d>& markers, const Eigen::Vector3d& p_W);

}  // namespace sinew
