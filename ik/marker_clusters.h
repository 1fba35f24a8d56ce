#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "ik/marker_attachment.h"

namespace sinew {

struct ClusterOptions {
  // By which distances between markers of one segment may vary [m]: skin moves them so, less on a
  // plate.
  double most_distance_sd = 0.006;
  // RMS by which the centre of a joint may differ between the cluster of one of its segments and
  // the other segment [m]: soft tissue moves a thigh's cluster by as much (Leardini et al. 2005).
  double most_joint_error = 0.03;
  double margin = 2.0;        // of the next segment's error over the best one's
  double least_width = 0.02;  // of three markers from one line [m]: less tells no turn
  double farthest = 0.25;     // from the body, as AttachmentOptions' [m]

  void validate() const;
};

/// Three or more of the markers that keep their distances among each other over all frames, each in
/// one group: pairs with the least varying distances join first. O(markers³ + markers² · frames).
std::vector<std::vector<int>> rigid_groups(const MarkerTrajectories& markers,
                                           const std::vector<int>& candidates,
                                           const ClusterOptions& options = {});

/// A group of markers on a body that no other marker determines.
struct ClusterAttachment {
  std::vector<int> group;  // columns of the walk
  int body = -1;
  double joint_error = kNaN, next_error = kNaN;  // [m], of the body and of the next best one
  double distance_sd = kNaN;                     // the largest between two of its markers [m]
  std::vector<Eigen::Vector3d> p_BM;             // places, as `group` [m]
};

/// Finds the bodies of groups by their joints. In the static trial's pose every body's place is
/// known, so that each body in question stands somewhere in the group; carried along by the group
/// through the walk, its joints must stay with the neighbouring bodies that markers determine
/// there. The body whose joints do is taken, if they stay within most_joint_error, the next
/// body's by `margin` worse, among the bodies near which
/// the group is in the static trial; its place in the group, and with it the markers' on the body,
/// are the static trial's. Neighbours that only become known by one group's attachment need another
/// call. `standing` is a static trial of one frame with the names of the walk, `X_WB` its poses,
/// `known` which of them are; `poses` are the walk's.
std::vector<ClusterAttachment> attach_clusters(
    const MusculoskeletalModel& model, const std::vector<std::vector<int>>& groups,
    const MarkerTrajectories& standing, const std::vector<RigidTransform>& X_WB,
    const std::vector<bool>& known, const MarkerTrajectories& walk, const BodyPoses& poses,
    const ClusterOptions& options = {});

}  // namespace sinew
