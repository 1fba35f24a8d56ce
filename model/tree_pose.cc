#include "model/tree_pose.h"

#include <algorithm>

namespace sinew {

void pose_tree(const KinematicTree& tree, const Eigen::Ref<const Eigen::RowVectorXd>& coordinates,
               KinematicWorkspace& workspace) {
  std::copy(tree.default_q.begin(), tree.default_q.end(), workspace.q.begin());
  for (std::size_t c = 0; c < tree.q_of_coordinate.size(); ++c) {
    const int at = tree.q_of_coordinate[c];
    if (at < 0) continue;
    workspace.q[static_cast<std::size_t>(at)] = coordinates[static_cast<Eigen::Index>(c)];
  }
  update_poses(tree, workspace);
}

}  // namespace sinew
