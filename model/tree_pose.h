#pragma once

#include <Eigen/Core>

#include "model/kinematic_tree.h"

namespace sinew {

/// Puts the workspace into the pose of the description's coordinates, in its order [rad, m]: the
/// other q at their defaults, then update_poses(). O(size of the model), allocates nothing.
void pose_tree(const KinematicTree& tree, const Eigen::Ref<const Eigen::RowVectorXd>& coordinates,
               KinematicWorkspace& workspace);

}  // namespace sinew
