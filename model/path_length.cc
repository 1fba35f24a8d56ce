#include "model/path_length.h"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

namespace sinew {
namespace {

using Eigen::Vector3d;

double coordinate_value(const PathPoint& point, int coordinate, const KinematicTree& tree,
                        const KinematicWorkspace& ws) {
  const int q = tree.q_of_coordinate[static_cast<std::size_t>(coordinate)];
  if (q < 0) {
    throw std::invalid_argument(fmt::format(
        "path point '{}' depends on coordinate {}, which steps as a quaternion; expected one with "
        "a value of its own",
        point.name, coordinate));
  }
  return ws.q[static_cast<std::size_t>(q)];
}

bool on_path(const PathPoint& point, const KinematicTree& tree, const KinematicWorkspace& ws) {
  if (point.kind != PathPoint::Kind::kConditional) return true;
  const double value = coordinate_value(point, point.condition_coordinate, tree, ws);
  return value >= point.condition_min && value <= point.condition_max;
}

double argument(const PathPoint& point, const TransformAxis& location, const KinematicTree& tree,
                const KinematicWorkspace& ws) {
  return location.coordinate < 0 ? 0.0 : coordinate_value(point, location.coordinate, tree, ws);
}

Vector3d place(const PathPoint& point, const KinematicTree& tree, const KinematicWorkspace& ws) {
  Vector3d p_BP = point.p_BP;
  if (point.kind == PathPoint::Kind::kMoving) {
    for (std::size_t i = 0; i < 3; ++i) {
      const TransformAxis& location = point.location[i];
      p_BP[static_cast<int>(i)] =
          CompiledFunction(location.function).value(argument(point, location, tree, ws));
    }
  }
  return ws.X_WB[static_cast<std::size_t>(point.body)] * p_BP;
}

// Calls use(from, to, p_WFrom, p_WTo) for every straight piece between points on the path.
template <typename Use>
void for_each_piece(const PathElement& path, const KinematicTree& tree,
                    const KinematicWorkspace& ws, const Use& use) {
  const PathPoint* previous = nullptr;
  Vector3d p_WPrevious = Vector3d::Zero();
  for (const PathPoint& point : path.points) {
    if (!on_path(point, tree, ws)) continue;
    const Vector3d p_WP = place(point, tree, ws);
    if (previous != nullptr) use(*previous, point, p_WPrevious, p_WP);
    previous = &point;
    p_WPrevious = p_WP;
  }
}

// A force at a point: a wrench on its link and, where the point moves in the link, a torque about
// the coordinate that moves it.
void pull(const PathPoint& point, const Vector3d& p_WP, const Vector3d& force,
          const KinematicTree& tree, KinematicWorkspace& ws, std::span<double> arms) {
  const auto b = static_cast<std::size_t>(point.body);
  ws.F[b].head<3>() += (p_WP - ws.X_WB[b].p).cross(force);
  ws.F[b].tail<3>() += force;
  if (point.kind != PathPoint::Kind::kMoving) return;
  for (std::size_t i = 0; i < 3; ++i) {
    const TransformAxis& location = point.location[i];
    if (location.coordinate < 0) continue;
    const double slope =
        CompiledFunction(location.function).evaluate(argument(point, location, tree, ws)).df;
    double torque = slope * force.dot(ws.X_WB[b].R.col(static_cast<int>(i)));
    // Down the couplings to the unknown, if there is one.
    int v = tree.v_of_coordinate[static_cast<std::size_t>(location.coordinate)];
    for (int c = tree.coupling_of_v[static_cast<std::size_t>(v)]; c >= 0;
         c = tree.coupling_of_v[static_cast<std::size_t>(v)]) {
      torque *= ws.coupling_slope[static_cast<std::size_t>(c)];
      v = tree.couplings[static_cast<std::size_t>(c)].independent_v;
    }
    const int x = tree.unknown_of_v[static_cast<std::size_t>(v)];
    if (x >= 0) arms[static_cast<std::size_t>(x)] += torque;
  }
}

}  // namespace

double path_length(const PathElement& path, const KinematicTree& tree,
                   const KinematicWorkspace& workspace) {
  double length = 0.0;
  for_each_piece(path, tree, workspace,
                 [&](const PathPoint&, const PathPoint&, const Vector3d& p_WA,
                     const Vector3d& p_WB) { length += (p_WB - p_WA).norm(); });
  return length;
}

void moment_arms(const PathElement& path, const KinematicTree& tree, KinematicWorkspace& workspace,
                 std::span<double> arms) {
  if (arms.size() != tree.unknown_v.size()) {
    throw std::invalid_argument(fmt::format("moment_arms: room for {} unknowns; expected {}",
                                            arms.size(), tree.unknown_v.size()));
  }
  std::fill(arms.begin(), arms.end(), 0.0);
  std::fill(workspace.F.begin(), workspace.F.end(), Vector6d::Zero());
  for_each_piece(
      path, tree, workspace,
      [&](const PathPoint& a, const PathPoint& b, const Vector3d& p_WA, const Vector3d& p_WB) {
        const Vector3d piece = p_WB - p_WA;
        const double length = piece.norm();
        if (length == 0.0) return;
        pull(a, p_WA, piece / length, tree, workspace, arms);
        pull(b, p_WB, -piece / length, tree, workspace, arms);
      });
  joint_torques(tree, workspace);
  fold_couplings(tree, workspace);
  for (std::size_t x = 0; x < arms.size(); ++x) {
    arms[x] += workspace.g[static_cast<std::size_t>(tree.unknown_v[x])];
  }
}

}  // namespace sinew
