#include "ik/undetermined_stretches.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <set>

#include "ik/marker_coverage.h"

namespace sinew {
namespace {

// Three markers that are not in one line hold a body.
constexpr int kEnough = 3;

bool counts(const TrackingProblem& tracking, const MarkerTrajectories& markers, int frame,
            std::size_t i) {
  if (std::isnan(markers.p_WM(frame, 3 * tracking.markers[i].recorded))) return false;
  return tracking.marker_scales.size() == 0 ||
         tracking.marker_scales(frame, static_cast<Eigen::Index>(i)) > 0.0;
}

// Markers of each body up to kEnough; what is the same in two frames is determined in both.
std::vector<int> case_of(const TrackingProblem& tracking, const MarkerTrajectories& markers,
                         int frame, int bodies) {
  std::vector<int> by_body(static_cast<std::size_t>(bodies), 0);
  for (std::size_t i = 0; i < tracking.markers.size(); ++i) {
    int& count = by_body[static_cast<std::size_t>(tracking.problem.positions[i].link)];
    if (counts(tracking, markers, frame, i)) count = std::min(count + 1, kEnough);
  }
  return by_body;
}

int measured_count(const TrackingProblem& tracking, const MarkerTrajectories& markers, int frame) {
  int count = 0;
  for (std::size_t i = 0; i < tracking.markers.size(); ++i) {
    count += counts(tracking, markers, frame, i);
  }
  return count;
}

std::vector<double> pose(const KinematicTree& tree, const RowMatrix& solved, Eigen::Index row) {
  std::vector<double> q = tree.default_q;
  for (std::size_t c = 0; c < tree.q_of_coordinate.size(); ++c) {
    q[static_cast<std::size_t>(tree.q_of_coordinate[c])] =
        solved(row, static_cast<Eigen::Index>(c));
  }
  return q;
}

// What no frame could determine: as if every tracked marker were seen, all where the model has
// them.
std::set<int> never_determined(const MusculoskeletalModel& model, const KinematicTree& tree,
                               const TrackingProblem& tracking, const std::vector<double>& q) {
  IkTargets targets(tracking.problem);
  for (auto& p : targets.positions) p.setZero();
  for (double& value : targets.coordinates) value = 0.0;
  const std::vector<int> found = undetermined_coordinates(model, tree, tracking, targets, q);
  return {found.begin(), found.end()};
}

// Of segments that have a marker in other frames, those without one in a case.
std::vector<Segment> bare_segments(const TrackingProblem& tracking,
                                   const std::vector<Segment>& segments,
                                   const std::vector<int>& markers_of) {
  const auto segment_of = [&](std::size_t i) -> const Segment& {
    return segments[static_cast<std::size_t>(tracking.problem.positions[i].link)];
  };
  std::vector<Segment> bare;
  for (std::size_t i = 0; i < tracking.markers.size(); ++i) {
    if (!(tracking.markers[i].weight > 0.0)) continue;
    const Segment& segment = segment_of(i);
    bool seen = std::find(bare.begin(), bare.end(), segment) != bare.end();
    for (std::size_t b = 1; b < segments.size() && !seen; ++b) {
      seen = segments[b] == segment && markers_of[b] > 0;
    }
    if (!seen) bare.push_back(segment);
  }
  return bare;
}

// The limited cubic over a stretch; value at s, 0 … 1, of frames before … behind.
struct Bridge {
  double a, b, slope_a, slope_b;  // values, and slopes per stretch

  double at(double s) const {
    const double r = 1.0 - s;
    return r * r * (1.0 + 2.0 * s) * a + s * s * (1.0 + 2.0 * r) * b +
           s * r * (r * slope_a - s * slope_b);
  }
};

Bridge limited(double a, double b, double slope_a, double slope_b) {
  const double rise = b - a;
  const auto limit = [&](double slope) {
    return slope * rise <= 0.0
               ? 0.0
               : std::copysign(std::min(std::abs(slope), 3.0 * std::abs(rise)), rise);
  };
  return {a, b, limit(slope_a), limit(slope_b)};
}

}  // namespace

std::vector<UndeterminedStretch> find_undetermined_stretches(
    const MusculoskeletalModel& model, const KinematicTree& tree, const TrackingProblem& tracking,
    const MarkerTrajectories& markers, int first_frame, const RowMatrix& solved) {
  std::map<std::vector<int>, std::vector<int>> known;
  std::vector<UndeterminedStretch> stretches;
  IkTargets targets(tracking.problem);
  std::set<int> never;
  const int bodies = static_cast<int>(model.bodies.size());
  const std::vector<Segment> segments = segments_of(model, tree);
  for (Eigen::Index row = 0; row < solved.rows(); ++row) {
    const int frame = first_frame + static_cast<int>(row);
    const std::vector<double> q = pose(tree, solved, row);
    if (row == 0) never = never_determined(model, tree, tracking, q);
    const auto [at, is_new] = known.try_emplace(case_of(tracking, markers, frame, bodies));
    if (is_new) {
      set_targets(tracking, markers, frame, targets);
      const std::vector<int> found = undetermined_coordinates(model, tree, tracking, targets, q);
      std::set<int> open(found.begin(), found.end());
      const std::vector<int> beside =
          coordinates_beside(model, tree, segments, bare_segments(tracking, segments, at->first));
      open.insert(beside.begin(), beside.end());
      std::copy_if(open.begin(), open.end(), std::back_inserter(at->second),
                   [&](int c) { return !never.contains(c); });
    }
    if (at->second.empty()) continue;
    const int measured = measured_count(tracking, markers, frame);
    if (!stretches.empty() && stretches.back().coordinates == at->second &&
        stretches.back().first + stretches.back().count == frame) {
      ++stretches.back().count;
      stretches.back().measured_markers = std::min(stretches.back().measured_markers, measured);
    } else {
      stretches.push_back({frame, 1, at->second, measured});
    }
  }
  return stretches;
}

TrackingProblem bridge_stretches(const MusculoskeletalModel& model, const KinematicTree& tree,
                                 const TrackingProblem& tracking,
                                 const std::vector<UndeterminedStretch>& stretches,
                                 int recorded_frames, int first_frame, const RowMatrix& solved) {
  // Frames of each coordinate that are not determined; stretches of it may join.
  std::map<int, std::vector<bool>> open;
  const int rows = static_cast<int>(solved.rows());
  for (const UndeterminedStretch& stretch : stretches) {
    for (const int c : stretch.coordinates) {
      auto& frames = open.try_emplace(c, static_cast<std::size_t>(rows), false).first->second;
      std::fill_n(frames.begin() + (stretch.first - first_frame), stretch.count, true);
    }
  }
  TrackingProblem bridged = tracking;
  for (const auto& [c, frames] : open) {
    const int q = tree.q_of_coordinate[static_cast<std::size_t>(c)];
    const int v = tree.v_of_coordinate[static_cast<std::size_t>(c)];
    // Coupled coordinates follow those that drive them.
    if (v < 0 || std::find(tree.unknown_v.begin(), tree.unknown_v.end(), v) == tree.unknown_v.end())
      continue;
    TrackedCoordinate task{c, kBridgeWeight, 0.0,
                           std::vector<double>(static_cast<std::size_t>(recorded_frames), kNaN)};
    for (int first = 0; first < rows; ++first) {
      if (!frames[static_cast<std::size_t>(first)]) continue;
      int end = first;
      while (end < rows && frames[static_cast<std::size_t>(end)]) ++end;
      const bool has_a = first > 0, has_b = end < rows;
      const double fallback = model.coordinates[static_cast<std::size_t>(c)].default_value;
      const double a = has_a ? solved(first - 1, c) : has_b ? solved(end, c) : fallback;
      const double b = has_b ? solved(end, c) : a;
      const double h = end - first + 1.0;
      const auto open_at = [&](int row) { return frames[static_cast<std::size_t>(row)]; };
      const double slope_a =
          has_a && first > 1 && !open_at(first - 2) ? h * (a - solved(first - 2, c)) : 0.0;
      const double slope_b =
          has_b && end + 1 < rows && !open_at(end + 1) ? h * (solved(end + 1, c) - b) : 0.0;
      const Bridge bridge = limited(a, b, slope_a, slope_b);
      for (int row = first; row < end; ++row) {
        task.values[static_cast<std::size_t>(first_frame + row)] =
            bridge.at((row - first + 1.0) / h);
      }
      first = end;
    }
    bridged.problem.coordinates.push_back({q, v, task.weight});
    bridged.coordinates.push_back(std::move(task));
  }
  return bridged;
}

}  // namespace sinew
