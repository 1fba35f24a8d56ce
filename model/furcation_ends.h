#pragma once

#include <optional>
#include <vector>

#include "model/kinematic_tree.h"
#include "model/musculoskeletal_model.h"

/// How muscles end on bones: a part of model/furcation.h, which callers use.
namespace sinew::furcation {

/// One end of a muscle in the pose of all defaults.
struct MuscleEnd {
  int path = -1;
  bool insertion = true;  // false: its origin
  int bone = 0;
  int next_body = 0;               // where the path leads off the bone
  std::size_t points_on_bone = 0;  // consecutive, from the end on
  Eigen::Vector3d p_W;             // the end itself [m]
  Eigen::Vector3d p_WLeave;        // where the path leaves the bone [m]
  Eigen::Vector3d direction_W;     // from there, a unit vector
  double length_on_bone = 0.0;     // of the path [m]
  double length_off_bone = 0.0;  // to the next point, one that is on the path at times counting [m]
  double force = 0.0;            // maximum isometric [N]
  double tendon_slack_length = 0.0;  // [m]

  /// The path's point at `distance` ≥ length_on_bone before the end, in the world.
  Eigen::Vector3d point_before_end(double distance) const {
    return p_WLeave + (distance - length_on_bone) * direction_W;
  }
};

class DefaultPose {
 public:
  explicit DefaultPose(const MusculoskeletalModel& model);

  const RigidTransform& X_WB(int body) const {
    return workspace_.X_WB[static_cast<std::size_t>(body)];
  }

  /// The end of a path; nothing if it is no muscle with a tendon, or never leaves the bone.
  std::optional<MuscleEnd> end(int path, bool insertion) const;
  /// Those of all paths, in the model's order.
  std::vector<MuscleEnd> ends(bool insertion) const;

 private:
  Eigen::Vector3d in_world(const PathPoint& point) const;
  bool is_on_path(const PathPoint& point) const;
  double value(int coordinate) const;

  const MusculoskeletalModel& model_;
  KinematicTree tree_;
  KinematicWorkspace workspace_;
};

}  // namespace sinew::furcation
