#include "model/furcation_ends.h"

#include <algorithm>
#include <limits>

namespace sinew::furcation {

using Eigen::Vector3d;

DefaultPose::DefaultPose(const MusculoskeletalModel& model)
    : model_(model), tree_(compile_tree(model)), workspace_(tree_) {
  update_poses(tree_, workspace_);
}

double DefaultPose::value(int coordinate) const {
  if (coordinate < 0) return 0.0;
  return workspace_
      .q[static_cast<std::size_t>(tree_.q_of_coordinate[static_cast<std::size_t>(coordinate)])];
}

Vector3d DefaultPose::in_world(const PathPoint& point) const {
  Vector3d p_BP = point.p_BP;
  if (point.kind == PathPoint::Kind::kMoving) {
    for (std::size_t i = 0; i < 3; ++i) {
      const TransformAxis& location = point.location[i];
      p_BP[static_cast<Eigen::Index>(i)] =
          CompiledFunction(location.function).value(value(location.coordinate));
    }
  }
  return X_WB(point.body) * p_BP;
}

bool DefaultPose::is_on_path(const PathPoint& point) const {
  if (point.kind != PathPoint::Kind::kConditional) return true;
  const double q = value(point.condition_coordinate);
  return q >= point.condition_min && q <= point.condition_max;
}

std::optional<MuscleEnd> DefaultPose::end(int path, bool insertion) const {
  const PathElement& muscle = model_.paths[static_cast<std::size_t>(path)];
  if (muscle.kind != PathElement::Kind::kMuscle || !(muscle.tendon_slack_length > 0.0)) return {};
  std::vector<PathPoint> points = muscle.points;  // from the end on
  if (insertion) std::reverse(points.begin(), points.end());
  MuscleEnd end;
  end.path = path;
  end.insertion = insertion;
  end.bone = points[0].body;
  end.force = muscle.max_isometric_force > 0.0 ? muscle.max_isometric_force : 0.0;
  end.tendon_slack_length = muscle.tendon_slack_length;
  end.p_W = end.p_WLeave = in_world(points[0]);
  std::size_t i = 1;
  for (; i < points.size() && points[i].body == end.bone; ++i) {
    if (points[i].kind != PathPoint::Kind::kFixed) return {};  // not a course of one length
    const Vector3d p_W = in_world(points[i]);
    end.length_on_bone += (p_W - end.p_WLeave).norm();
    end.p_WLeave = p_W;
  }
  end.points_on_bone = i;
  end.length_off_bone = std::numeric_limits<double>::infinity();
  for (; i < points.size(); ++i) {
    const Vector3d off = in_world(points[i]) - end.p_WLeave;
    end.length_off_bone = std::min(end.length_off_bone, off.norm());
    if (!is_on_path(points[i])) continue;
    end.next_body = points[i].body;
    end.direction_W = off.normalized();
    return off.norm() > 0.0 ? std::optional(end) : std::nullopt;
  }
  return {};
}

std::vector<MuscleEnd> DefaultPose::ends(bool insertion) const {
  std::vector<MuscleEnd> ends;
  for (std::size_t p = 0; p < model_.paths.size(); ++p) {
    if (const auto found = end(static_cast<int>(p), insertion)) ends.push_back(*found);
  }
  return ends;
}

}  // namespace sinew::furcation
