#include "ik/root_alignment.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <vector>

#include "data/rigid_fit.h"
#include "ik/minimizer.h"

namespace sinew {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// Points closer to one line than this part of their extent along it do not tell the turn about it.
constexpr double kOnOneLine = 1e-3;

struct Pairs {
  Eigen::Matrix3Xd points, measured;
  Eigen::VectorXd weights;
};

// What markers of the links in `within` say: where they are at the poses of `ws`, and where they
// were measured.
Pairs pairs_of(const IkProblem& problem, const IkTargets& targets, const KinematicWorkspace& ws,
               const std::vector<char>& within) {
  Pairs pairs;
  std::vector<std::size_t> used;
  for (std::size_t i = 0; i < problem.positions.size(); ++i) {
    if (targets.positions[i].hasNaN() || position_scale(targets, i) <= 0.0) continue;
    if (within[static_cast<std::size_t>(problem.positions[i].link)]) used.push_back(i);
  }
  const auto n = static_cast<Eigen::Index>(used.size());
  pairs.points.resize(3, n);
  pairs.measured.resize(3, n);
  pairs.weights.resize(n);
  for (Eigen::Index k = 0; k < n; ++k) {
    const std::size_t i = used[static_cast<std::size_t>(k)];
    const PositionResidual& r = problem.positions[i];
    pairs.points.col(k) = ws.X_WB[static_cast<std::size_t>(r.link)] * r.p_BP;
    pairs.measured.col(k) = targets.positions[i];
    pairs.weights[k] = position_weight(problem, targets, i).trace() / 3.0;
  }
  return pairs;
}

bool is_identity(const KinematicTree& tree, const KinematicTree::Step& step) {
  return step.q >= 0 && step.function < 0 &&
         tree.unknown_of_v[static_cast<std::size_t>(step.v)] >= 0;
}

// The axes of three steps as columns; nothing unless they are perpendicular to each other, as turns
// have to be to reach every orientation, or `any`, merely independent.
std::optional<Matrix3d> axes_of(const KinematicTree& tree, int first, bool any) {
  Matrix3d axes;
  for (int i = 0; i < 3; ++i) {
    const KinematicTree::Step& step = tree.steps[static_cast<std::size_t>(first + i)];
    if (!is_identity(tree, step)) return {};
    axes.col(i) = step.axis;
  }
  constexpr double kRounding = 1e-9;  // of axes that a file prints
  if (any) return std::abs(axes.determinant()) > kRounding ? std::optional(axes) : std::nullopt;
  if ((axes.transpose() * axes - Matrix3d::Identity()).cwiseAbs().maxCoeff() > kRounding) return {};
  return axes;
}

double& q_of(const KinematicTree& tree, int step, std::span<double> q) {
  return q[static_cast<std::size_t>(tree.steps[static_cast<std::size_t>(step)].q)];
}

// Sets the joint of `link` to X_FM exactly; false for a joint of another kind.
bool set_joint(const KinematicTree& tree, const KinematicTree::Link& link,
               const RigidTransform& X_FM, std::span<double> q) {
  if (link.kind == KinematicTree::Kind::kFree) {
    const Eigen::Quaterniond turn(X_FM.R);
    const double values[] = {turn.w(),   turn.x(),   turn.y(),  turn.z(),
                             X_FM.p.x(), X_FM.p.y(), X_FM.p.z()};
    std::copy(std::begin(values), std::end(values), q.begin() + link.first_q);
    return true;
  }
  if (link.kind != KinematicTree::Kind::kSteps || link.rotation_count != 3 ||
      link.translation_count != 3) {
    return false;
  }
  const std::optional<Matrix3d> turns = axes_of(tree, link.first_step, false);
  const std::optional<Matrix3d> shifts = axes_of(tree, link.first_step + 3, true);
  if (!turns || !shifts) return false;
  // In the axes' own frame the turns are about x, y and z; backwards if the axes are left-handed.
  const double handed = turns->determinant() < 0.0 ? -1.0 : 1.0;
  const Vector3d angles = handed * body_xyz_from_rotation(turns->transpose() * X_FM.R * *turns);
  const Vector3d lengths = shifts->inverse() * X_FM.p;
  for (int i = 0; i < 3; ++i) {
    q_of(tree, link.first_step + i, q) = angles[i];
    q_of(tree, link.first_step + 3 + i, q) = lengths[i];
  }
  return true;
}

// Brings the link as near to the pose as its joint can: four of its points, by their squared
// distances. From four turns of the joint's first angle, since from half a turn away nothing pulls.
void approach(const KinematicTree& tree, int link, const RigidTransform& X_WB,
              std::span<double> q) {
  IkProblem corners;
  constexpr double kArm = 0.2;  // [m], of the order of a pelvis
  corners.positions.push_back({link, Vector3d::Zero()});
  for (int i = 0; i < 3; ++i) corners.positions.push_back({link, kArm * Vector3d::Unit(i)});
  IkTargets targets(corners);
  for (std::size_t i = 0; i < 4; ++i) targets.positions[i] = X_WB * corners.positions[i].p_BP;
  Minimizer minimizer(tree, corners, {});
  const std::vector<double> start(q.begin(), q.end());
  const KinematicTree::Link& root = tree.links[static_cast<std::size_t>(link)];
  double lowest = std::numeric_limits<double>::infinity();
  for (int quarter = 0; quarter < 4; ++quarter) {
    std::vector<double> pose = start;
    for (int v = root.first_v; v < root.first_v + root.v_count; ++v) {
      const int entry = tree.q_of_v[static_cast<std::size_t>(v)];
      if (entry < 0 || tree.unknown_of_v[static_cast<std::size_t>(v)] < 0) continue;
      pose[static_cast<std::size_t>(entry)] += quarter * 0.5 * M_PI;
      break;
    }
    const double cost = minimizer.minimize(targets, pose).final_cost;
    if (!(cost < lowest)) continue;
    lowest = cost;
    std::copy(pose.begin(), pose.end(), q.begin());
  }
}

}  // namespace

std::optional<RigidTransform> rigid_fit(const Eigen::Matrix3Xd& points,
                                        const Eigen::Matrix3Xd& measured,
                                        const Eigen::VectorXd& weights) {
  if (points.cols() < 3 || !(weights.sum() > 0.0)) return {};
  const RigidFit fit = fit_rigidly(points, measured, weights);
  if (!(fit.width > kOnOneLine * fit.length)) return {};
  RigidTransform X;
  X.R = fit.R;
  X.p = fit.t;
  return X;
}

void align_roots(const KinematicTree& tree, const IkProblem& problem, const IkTargets& targets,
                 std::span<const char> links, std::span<double> q) {
  KinematicWorkspace ws(tree);
  std::copy(q.begin(), q.end(), ws.q.begin());
  update_poses(tree, ws);
  const auto count = static_cast<std::size_t>(tree.link_count());
  for (std::size_t root = 1; root < count; ++root) {
    const KinematicTree::Link& link = tree.links[root];
    if (link.parent != 0 || link.v_count == 0) continue;
    std::vector<char> below(count, 0), counted(count, 0);
    below[root] = 1;
    for (std::size_t b = root; b < count; ++b) {
      if (b > root) below[b] = below[static_cast<std::size_t>(tree.links[b].parent)];
      counted[b] = below[b] && (links.empty() || links[b]);
    }
    const Pairs pairs = pairs_of(problem, targets, ws, counted);
    const auto X = rigid_fit(pairs.points, pairs.measured, pairs.weights);
    if (!X) continue;
    const RigidTransform X_WB = *X * ws.X_WB[root];
    const RigidTransform X_FM = link.X_PF.inverse() * X_WB * link.X_MB.inverse();
    if (!set_joint(tree, link, X_FM, q)) approach(tree, static_cast<int>(root), X_WB, q);
  }
}

}  // namespace sinew
