#include "data/preflight_sides.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "data/foot_markers.h"
#include "data/preflight_swaps.h"

namespace sinew {
namespace {

using Eigen::Vector3d;

// Half a metre is less than a stride and more than anyone sways.
constexpr double kLeastWay = 0.5;  // [m]
// Wider pairs say no more than the shoulders do.
constexpr double kWidest = 0.4;  // [m]
// cos 60°: a direction that is farther off tells nothing about left and right.
constexpr double kLeastCosine = 0.5;

// Parts of the frames in which each pair lies against the sum of the others.
struct PairVote {
  int frames = 0, against = 0;
  double width = 0.0;  // sum over frames [m]

  double share() const { return frames > 0 ? static_cast<double>(against) / frames : 0.0; }
};

std::vector<PairVote> count_votes(const MarkerTrajectories& markers,
                                  const std::vector<MarkerPair>& pairs,
                                  const std::vector<bool>& turned, const Vector3d& up) {
  std::vector<PairVote> votes(pairs.size());
  std::vector<Vector3d> d(pairs.size());
  for (int frame = 0; frame < markers.frame_count(); ++frame) {
    Vector3d sum = Vector3d::Zero();
    for (std::size_t k = 0; k < pairs.size(); ++k) {
      d[k] = rightward(markers, frame, pairs[k], up);
      if (turned[k]) d[k] = -d[k];
      sum += d[k];
    }
    for (std::size_t k = 0; k < pairs.size(); ++k) {
      const Vector3d others = sum - d[k];
      if (d[k].isZero() || others.isZero()) continue;
      ++votes[k].frames;
      votes[k].width += std::abs(d[k].dot(others.normalized()));
      if (d[k].dot(others) < 0.0) ++votes[k].against;
    }
  }
  return votes;
}

// Pairs that lie against the others, the clearest first, each judged with those before it turned.
std::vector<std::size_t> find_turned_pairs(const MarkerTrajectories& markers,
                                           const std::vector<MarkerPair>& pairs, const Vector3d& up,
                                           const SideCheckOptions& options,
                                           std::vector<double>& shares) {
  std::vector<bool> turned(pairs.size(), false);
  std::vector<std::size_t> found;
  // Three pairs at least, so that two agree; fewer than half may be wrong.
  while (pairs.size() >= 3 && 2 * (found.size() + 1) < pairs.size()) {
    const std::vector<PairVote> votes = count_votes(markers, pairs, turned, up);
    std::size_t best = pairs.size();
    for (std::size_t k = 0; k < pairs.size(); ++k) {
      const PairVote& vote = votes[k];
      if (turned[k] || vote.share() < options.least_share) continue;
      if (vote.width < options.least_width * vote.frames) continue;
      if (best == pairs.size() ||
          vote.share() * vote.width > votes[best].share() * votes[best].width) {
        best = k;
      }
    }
    if (best == pairs.size()) break;
    turned[best] = true;
    found.push_back(best);
    shares.push_back(votes[best].share());
  }
  return found;
}

// The mean cosine between what is called right and the right of where the subject faces, by the
// feet of the same frame or else by the way; zero where neither tells.
double cosine_of_right(const MarkerTrajectories& markers, const std::vector<MarkerPair>& pairs,
                       const std::vector<std::size_t>& turned, const Vector3d& up,
                       const FeetMarkers& feet, const Vector3d& way) {
  double sum = 0.0;
  int count = 0;
  for (int frame = 0; frame < markers.frame_count(); ++frame) {
    Vector3d right = Vector3d::Zero();
    for (std::size_t k = 0; k < pairs.size(); ++k) {
      if (std::find(turned.begin(), turned.end(), k) != turned.end()) continue;
      right += rightward(markers, frame, pairs[k], up);
    }
    const Vector3d forward = way.isZero() ? facing_in(markers, frame, feet, up) : way;
    if (right.isZero() || forward.isZero()) continue;
    sum += right.normalized().dot(forward.cross(up));
    ++count;
  }
  return sum / std::max(count, 1);
}

// The mean place along `forward` of each marker, of those that are measured with all of the foot.
std::vector<double> places_along(const MarkerTrajectories& markers, const std::vector<int>& which,
                                 const std::vector<Vector3d>& forward, int& frames) {
  std::vector<double> sums(which.size(), 0.0);
  frames = 0;
  for (int frame = 0; frame < markers.frame_count(); ++frame) {
    const Vector3d& direction = forward[static_cast<std::size_t>(frame)];
    const Vector3d middle = mean_position(markers, frame, which);
    const bool all = std::all_of(which.begin(), which.end(),
                                 [&](int m) { return markers.position(frame, m).allFinite(); });
    if (direction.isZero() || !all) continue;
    ++frames;
    for (std::size_t i = 0; i < which.size(); ++i) {
      sums[i] += direction.dot(markers.position(frame, which[i]) - middle);
    }
  }
  for (double& sum : sums) sum /= std::max(frames, 1);
  return sums;
}

// One foot that points backwards while the other does not: its heel and a toe bear each other's
// names.
void judge_feet(const MarkerTrajectories& markers, const std::vector<MarkerPair>& pairs,
                const std::vector<std::size_t>& turned, const Vector3d& up,
                std::vector<Finding>& findings) {
  constexpr double kLeastLength = 0.05;  // [m] of a foot, seen from above
  const FeetMarkers feet = find_foot_markers(markers);
  if (!feet.left.has_ends() || !feet.right.has_ends()) return;
  const auto of_foot = [&](int m) {
    const auto has = [&](const FootMarkers& foot) {
      return std::find(foot.all.begin(), foot.all.end(), m) != foot.all.end();
    };
    return has(feet.left) || has(feet.right);
  };
  std::vector<Vector3d> forward;
  for (int frame = 0; frame < markers.frame_count(); ++frame) {
    Vector3d right = Vector3d::Zero();
    for (std::size_t k = 0; k < pairs.size(); ++k) {
      if (of_foot(pairs[k].left) || std::find(turned.begin(), turned.end(), k) != turned.end()) {
        continue;
      }
      right += rightward(markers, frame, pairs[k], up);
    }
    forward.push_back(right.isZero() ? right : Vector3d(up.cross(right).normalized()));
  }
  struct Foot {
    std::size_t heel = 0, toe = 0;  // into `which`: the foremost heel, the hindmost toe
    std::vector<int> which;
    double length = 0.0;  // from the heels to the toes along forward [m]
  };
  const auto look = [&](const FootMarkers& markers_of) {
    Foot foot;
    foot.which = markers_of.heel;
    foot.which.insert(foot.which.end(), markers_of.toe.begin(), markers_of.toe.end());
    const std::size_t heels = markers_of.heel.size();
    int frames = 0;
    const std::vector<double> places = places_along(markers, foot.which, forward, frames);
    if (frames == 0) return foot;
    const auto begin = places.begin(), middle = begin + static_cast<std::ptrdiff_t>(heels);
    foot.heel = static_cast<std::size_t>(std::max_element(begin, middle) - begin);
    foot.toe = static_cast<std::size_t>(std::min_element(middle, places.end()) - begin);
    // Of the two that may be exchanged: other toes lie between them.
    foot.length = places[foot.toe] - places[foot.heel];
    return foot;
  };
  const Foot left = look(feet.left), right = look(feet.right);
  for (const auto& [foot, other] : {std::pair{&left, &right}, std::pair{&right, &left}}) {
    if (foot->length > -kLeastLength || other->length < kLeastLength) continue;
    const std::string& heel = markers.names[static_cast<std::size_t>(foot->which[foot->heel])];
    const std::string& toe = markers.names[static_cast<std::size_t>(foot->which[foot->toe])];
    findings.push_back(whole_exchange(
        heel, toe,
        fmt::format("the toe lies {:.0f} mm behind the heel, and not so on the other foot",
                    -1e3 * foot->length)));
  }
}

void judge_all(const MarkerTrajectories& markers, const std::vector<MarkerPair>& pairs,
               const std::vector<std::size_t>& turned, const Vector3d& up,
               std::vector<Finding>& findings) {
  const FeetMarkers feet = find_foot_markers(markers);
  const Vector3d facing = mean_facing(markers, feet, up);
  const bool by_feet = !facing.isZero();
  Vector3d way = way_travelled(markers, up);
  way = way.norm() > kLeastWay ? Vector3d(way.normalized()) : Vector3d::Zero();
  Finding finding;
  finding.kind = "side";
  if (facing.dot(way) < -kLeastCosine) {
    finding.severity = Finding::Severity::kNote;
    finding.confidence = 0.9;
    finding.text =
        "the subject goes where the heels point: backwards, or heels and toes bear each other's "
        "names";
    findings.push_back(finding);
  }
  const double cosine =
      cosine_of_right(markers, pairs, turned, up, feet, by_feet ? Vector3d::Zero() : way);
  if (cosine > -kLeastCosine) return;
  finding.severity = by_feet ? Finding::Severity::kError : Finding::Severity::kWarning;
  finding.confidence = (by_feet ? 0.98 : 0.65) * std::min(1.0, 0.1 - cosine);
  finding.text = fmt::format("what is called right lies to the left of where {}",
                             by_feet ? "the feet point" : "the subject goes");
  if (!by_feet) finding.advice = "leave it if the subject walks backwards";
  finding.flags = {"--swap-sides"};
  findings.push_back(std::move(finding));
}

}  // namespace

Vector3d rightward(const MarkerTrajectories& markers, int frame, const MarkerPair& pair,
                   const Vector3d& up) {
  Vector3d d = markers.position(frame, pair.right) - markers.position(frame, pair.left);
  if (!d.allFinite()) return Vector3d::Zero();
  d -= up * up.dot(d);
  const double length = d.norm();
  return length > kWidest ? Vector3d(d * (kWidest / length)) : d;
}

void SideCheckOptions::validate() const {
  if (!(least_share > 0.5 && least_share <= 1.0)) {
    throw std::invalid_argument(fmt::format(
        "SideCheckOptions::least_share is {}; it must be above 0.5 and at most 1", least_share));
  }
  if (!(least_width >= 0.0)) {
    throw std::invalid_argument(
        fmt::format("SideCheckOptions::least_width is {}; it must be at least 0 m", least_width));
  }
}

std::vector<Finding> find_side_faults(const MarkerTrajectories& markers, const LaboratoryAxes& axes,
                                      const SideCheckOptions& options) {
  options.validate();
  std::vector<Finding> findings;
  const std::vector<MarkerPair> pairs = find_marker_pairs(markers.names);
  if (!axes.up.known() || pairs.empty()) return findings;
  std::vector<double> shares;
  const std::vector<std::size_t> turned =
      find_turned_pairs(markers, pairs, axes.up.axis, options, shares);
  for (std::size_t i = 0; i < turned.size(); ++i) {
    const std::string& left = markers.names[static_cast<std::size_t>(pairs[turned[i]].left)];
    const std::string& right = markers.names[static_cast<std::size_t>(pairs[turned[i]].right)];
    Finding finding;
    finding.severity = Finding::Severity::kError;
    finding.kind = "side";
    finding.where = left + ", " + right;
    finding.confidence = std::min(0.98, shares[i]);
    finding.text = fmt::format(
        "left and right lie the other way round than the other pairs in {:.0f} % of the frames",
        100.0 * shares[i]);
    finding.flags = {"--swap", left + "," + right};
    findings.push_back(std::move(finding));
  }
  judge_feet(markers, pairs, turned, axes.up.axis, findings);
  judge_all(markers, pairs, turned, axes.up.axis, findings);
  return findings;
}

}  // namespace sinew
