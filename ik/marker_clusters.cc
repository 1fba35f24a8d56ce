#include "ik/marker_clusters.h"

#include <fmt/format.h>

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>

#include "ik/root_alignment.h"

namespace sinew {
namespace {

using Eigen::Vector3d;

constexpr int kLeastFrames = 20;  // of markers together

// Standard deviation of a distance; infinite where too few frames tell.
double distance_sd(const MarkerTrajectories& markers, int a, int b) {
  double sum = 0.0, squares = 0.0;
  int count = 0;
  for (int f = 0; f < markers.frame_count(); ++f) {
    const double d = (markers.position(f, a) - markers.position(f, b)).norm();
    if (std::isnan(d)) continue;
    sum += d;
    squares += d * d;
    ++count;
  }
  if (count < kLeastFrames) return std::numeric_limits<double>::infinity();
  const double mean = sum / count;
  return std::sqrt(std::max(0.0, squares / count - mean * mean));
}

// From the line that fits points best, the RMS.
double width(const Eigen::Matrix3Xd& p) {
  const Eigen::Matrix3Xd centred = p.colwise() - p.rowwise().mean();
  const Eigen::JacobiSVD<Eigen::Matrix3Xd> svd(centred);
  return svd.singularValues().size() < 2
             ? 0.0
             : svd.singularValues()[1] / std::sqrt(static_cast<double>(p.cols()));
}

Eigen::Matrix3Xd positions(const MarkerTrajectories& markers, int frame,
                           const std::vector<int>& group) {
  Eigen::Matrix3Xd p(3, static_cast<Eigen::Index>(group.size()));
  for (std::size_t i = 0; i < group.size(); ++i) {
    p.col(static_cast<Eigen::Index>(i)) = markers.position(frame, group[i]);
  }
  return p;
}

// How a group moved from the static trial to a frame; nothing where fewer than three of its markers
// are measured.
std::optional<RigidTransform> motion(const Eigen::Matrix3Xd& from, const Eigen::Matrix3Xd& to) {
  std::vector<int> both;
  for (int i = 0; i < static_cast<int>(from.cols()); ++i) {
    if (from.col(i).allFinite() && to.col(i).allFinite()) both.push_back(i);
  }
  if (both.size() < 3) return std::nullopt;
  return rigid_fit(from(Eigen::all, both), to(Eigen::all, both),
                   Eigen::VectorXd::Ones(static_cast<Eigen::Index>(both.size())));
}

class ClusterSearch {
 public:
  ClusterSearch(const MusculoskeletalModel& model, const MarkerTrajectories& standing,
                const std::vector<RigidTransform>& X_WB, const std::vector<bool>& known,
                const MarkerTrajectories& walk, const BodyPoses& poses)
      : model_(model),
        standing_(standing),
        X_WB_(X_WB),
        known_(known),
        walk_(walk),
        poses_(poses) {}

  // RMS by which the joints between a body, carried by a group, and its determined neighbours
  // part; NaN where there is none.
  double joint_error(const std::vector<int>& columns, const Eigen::Matrix3Xd& from,
                     int body) const {
    double sum = 0.0;
    int count = 0;
    for (const Joint& joint : model_.joints) {
      const int other = joint.child == body ? joint.parent : joint.child;
      if ((joint.child != body && joint.parent != body) || other == 0) continue;
      if (!poses_.determined[static_cast<std::size_t>(other)]) continue;
      // Where the joint is in the static pose, seen from the neighbour.
      const Vector3d p_W = X_WB_[static_cast<std::size_t>(joint.child)] * joint.X_BM.p;
      const Vector3d p_O = X_WB_[static_cast<std::size_t>(other)].inverse() * p_W;
      for (std::size_t f = 0; f < poses_.X_WB.size(); ++f) {
        const auto X = motion(from, positions(walk_, static_cast<int>(f), columns));
        if (!X) continue;
        sum += (*X * p_W - poses_.X_WB[f][static_cast<std::size_t>(other)] * p_O).squaredNorm();
        ++count;
      }
    }
    return count < kLeastFrames ? kNaN : std::sqrt(sum / count);
  }

  std::optional<ClusterAttachment> attach(const std::vector<int>& group,
                                          const ClusterOptions& options) const {
    Eigen::Matrix3Xd from(3, static_cast<Eigen::Index>(group.size()));
    std::vector<int> there;
    for (std::size_t i = 0; i < group.size(); ++i) {
      const int column = standing_.find_marker(walk_.names[static_cast<std::size_t>(group[i])]);
      from.col(static_cast<Eigen::Index>(i)) =
          column < 0 ? Vector3d::Constant(kNaN) : standing_.position(0, column);
      if (from.col(static_cast<Eigen::Index>(i)).allFinite()) there.push_back(static_cast<int>(i));
    }
    if (there.size() < 3) return {};
    Eigen::Matrix3Xd seen(3, static_cast<Eigen::Index>(there.size()));
    for (std::size_t i = 0; i < there.size(); ++i) {
      seen.col(static_cast<Eigen::Index>(i)) = from.col(there[i]);
    }
    if (width(seen) < options.least_width) return {};
    const Vector3d middle = seen.rowwise().mean();
    ClusterAttachment best;
    for (std::size_t b = 1; b < model_.bodies.size(); ++b) {
      if (!in_question(b)) continue;
      // The other thigh's hip turns about much the same axis, but is not where the cluster is.
      const double near =
          distance_from_bone(model_, static_cast<int>(b), X_WB_[b].inverse() * middle);
      if (near > options.farthest || near > options.margin * nearest(middle)) continue;
      const double error = joint_error(group, from, static_cast<int>(b));
      if (std::isnan(error)) continue;
      if (std::isnan(best.joint_error) || error < best.joint_error) {
        best.next_error = best.joint_error;
        best.joint_error = error;
        best.body = static_cast<int>(b);
      } else if (std::isnan(best.next_error) || error < best.next_error) {
        best.next_error = error;
      }
    }
    if (best.body < 0 || best.joint_error > options.most_joint_error) return {};
    if (!std::isnan(best.next_error) && best.next_error < options.margin * best.joint_error) {
      return {};
    }
    const RigidTransform X_BW = X_WB_[static_cast<std::size_t>(best.body)].inverse();
    for (const int i : there) {
      best.group.push_back(group[static_cast<std::size_t>(i)]);
      best.p_BM.push_back(X_BW * from.col(i));
    }
    best.distance_sd = 0.0;
    for (const int a : best.group) {
      for (const int b : best.group) {
        if (a < b) best.distance_sd = std::max(best.distance_sd, distance_sd(walk_, a, b));
      }
    }
    return best;
  }

 private:
  bool in_question(std::size_t body) const {
    return !poses_.determined[body] && known_[body] && !model_.bodies[body].virtual_link;
  }

  // From a place in the static trial to the nearest body in question.
  double nearest(const Vector3d& p_W) const {
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t b = 1; b < model_.bodies.size(); ++b) {
      if (!in_question(b)) continue;
      least = std::min(least,
                       distance_from_bone(model_, static_cast<int>(b), X_WB_[b].inverse() * p_W));
    }
    return least;
  }

  const MusculoskeletalModel& model_;
  const MarkerTrajectories& standing_;
  const std::vector<RigidTransform>& X_WB_;
  const std::vector<bool>& known_;
  const MarkerTrajectories& walk_;
  const BodyPoses& poses_;
};

}  // namespace

void ClusterOptions::validate() const {
  const auto require = [](const char* name, double value) {
    if (std::isfinite(value) && value > 0.0) return;
    throw std::invalid_argument(fmt::format("{} is {}; expected a number above 0", name, value));
  };
  require("most_distance_sd", most_distance_sd);
  require("most_joint_error", most_joint_error);
  require("margin", margin);
  require("least_width", least_width);
}

std::vector<std::vector<int>> rigid_groups(const MarkerTrajectories& markers,
                                           const std::vector<int>& candidates,
                                           const ClusterOptions& options) {
  options.validate();
  struct Pair {
    double sd;
    std::size_t a, b;
  };
  const std::size_t n = candidates.size();
  Eigen::MatrixXd sd =
      Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(n), static_cast<Eigen::Index>(n));
  std::vector<Pair> pairs;
  for (std::size_t a = 0; a < n; ++a) {
    for (std::size_t b = a + 1; b < n; ++b) {
      const double s = distance_sd(markers, candidates[a], candidates[b]);
      sd(static_cast<Eigen::Index>(a), static_cast<Eigen::Index>(b)) = s;
      sd(static_cast<Eigen::Index>(b), static_cast<Eigen::Index>(a)) = s;
      if (s <= options.most_distance_sd) pairs.push_back({s, a, b});
    }
  }
  std::stable_sort(pairs.begin(), pairs.end(),
                   [](const Pair& x, const Pair& y) { return x.sd < y.sd; });
  std::vector<std::size_t> group_of(n);
  std::vector<std::vector<std::size_t>> groups(n);
  for (std::size_t i = 0; i < n; ++i) groups[group_of[i] = i] = {i};
  // Two groups join where all their distances are constant.
  for (const Pair& pair : pairs) {
    const std::size_t x = group_of[pair.a], y = group_of[pair.b];
    if (x == y) continue;
    bool all = true;
    for (const std::size_t i : groups[x]) {
      for (const std::size_t k : groups[y]) {
        all = all && sd(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k)) <=
                         options.most_distance_sd;
      }
    }
    if (!all) continue;
    for (const std::size_t k : groups[y]) group_of[k] = x;
    groups[x].insert(groups[x].end(), groups[y].begin(), groups[y].end());
    groups[y].clear();
  }
  std::vector<std::vector<int>> result;
  for (std::vector<std::size_t>& group : groups) {
    if (group.size() < 3) continue;
    std::sort(group.begin(), group.end());
    result.emplace_back();
    for (const std::size_t i : group) result.back().push_back(candidates[i]);
  }
  return result;
}

std::vector<ClusterAttachment> attach_clusters(
    const MusculoskeletalModel& model, const std::vector<std::vector<int>>& groups,
    const MarkerTrajectories& standing, const std::vector<RigidTransform>& X_WB,
    const std::vector<bool>& known, const MarkerTrajectories& walk, const BodyPoses& poses,
    const ClusterOptions& options) {
  options.validate();
  const ClusterSearch search(model, standing, X_WB, known, walk, poses);
  std::vector<ClusterAttachment> attachments;
  for (const std::vector<int>& group : groups) {
    if (auto attachment = search.attach(group, options)) {
      attachments.push_back(std::move(*attachment));
    }
  }
  return attachments;
}

}  // namespace sinew
