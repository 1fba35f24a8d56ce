#include "ik/marker_coverage.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "model/limb_paths.h"

namespace sinew {
namespace {

// Among the frames from first_frame on, `count` of them.
int fullest_frame(const TrackingProblem& tracking, const MarkerTrajectories& markers,
                  int first_frame, int count) {
  int best = first_frame, most = -1;
  for (int f = first_frame; f < first_frame + count; ++f) {
    const auto measured = static_cast<int>(std::count_if(
        tracking.markers.begin(), tracking.markers.end(),
        [&](const TrackedMarker& m) { return markers.position(f, m.recorded).allFinite(); }));
    if (measured <= most) continue;
    most = measured;
    best = f;
  }
  return best;
}

// By tracked marker: measured for a tenth of a second, or all the time where that is less. Less
// tells of no movement.
std::vector<bool> often_measured(const TrackingProblem& tracking, const MarkerTrajectories& markers,
                                 int first_frame, int count) {
  constexpr double kLeast = 0.1;  // [s]
  const int least = std::min(count, static_cast<int>(std::lround(kLeast * markers.rate)));
  std::vector<bool> often;
  for (std::size_t i = 0; i < tracking.markers.size(); ++i) {
    int measured = 0;
    for (int f = first_frame; f < first_frame + count; ++f) {
      measured +=
          !(tracking.filled.size() > 0 && tracking.filled(f, static_cast<Eigen::Index>(i))) &&
          markers.position(f, tracking.markers[i].recorded).allFinite();
    }
    often.push_back(measured > 0 && measured >= least);
  }
  return often;
}

bool moves(const MusculoskeletalModel& model, const KinematicTree& tree, int body) {
  const Joint& joint = model.joints[static_cast<std::size_t>(body) - 1];
  return std::any_of(joint.coordinates.begin(), joint.coordinates.end(), [&](int c) {
    const int v = tree.v_of_coordinate[static_cast<std::size_t>(c)];
    return v >= 0 && (tree.unknown_of_v[static_cast<std::size_t>(v)] >= 0 ||
                      tree.coupling_of_v[static_cast<std::size_t>(v)] >= 0);
  });
}

std::string some_names(const MusculoskeletalModel& model, const std::vector<int>& coordinates) {
  constexpr std::size_t kShown = 6;
  std::string text;
  for (std::size_t i = 0; i < std::min(kShown, coordinates.size()); ++i) {
    text += (i == 0 ? "" : ", ") + model.coordinates[static_cast<std::size_t>(coordinates[i])].name;
  }
  if (coordinates.size() > kShown) text += fmt::format(" and {} more", coordinates.size() - kShown);
  return text;
}

VerdictReason reason_of(const MusculoskeletalModel& model, const std::vector<int>& coordinates) {
  VerdictReason reason;
  reason.source = "Sinew";
  for (const int c : coordinates) {
    reason.angles.push_back(model.coordinates[static_cast<std::size_t>(c)].name);
  }
  reason.torques = reason.angles;
  return reason;
}

}  // namespace

std::vector<Segment> segments_of(const MusculoskeletalModel& model, const KinematicTree& tree) {
  std::vector<Segment> segments(model.bodies.size());
  for (std::size_t b = 1; b < model.bodies.size(); ++b) {
    const int parent = model.joints[b - 1].parent;
    segments[b] = parent > 0 && !moves(model, tree, static_cast<int>(b))
                      ? segments[static_cast<std::size_t>(parent)]
                      : segment_of_body(model.bodies[b].name);
  }
  return segments;
}

std::vector<int> coordinates_beside(const MusculoskeletalModel& model, const KinematicTree& tree,
                                    const std::vector<Segment>& segments,
                                    const std::vector<Segment>& bare) {
  const auto is_bare = [&](int body) {
    return body > 0 && std::find(bare.begin(), bare.end(),
                                 segments[static_cast<std::size_t>(body)]) != bare.end();
  };
  std::vector<int> coordinates;
  for (std::size_t c = 0; c < model.coordinates.size(); ++c) {
    const int v = tree.v_of_coordinate[c];
    const bool free = v >= 0 && (tree.unknown_of_v[static_cast<std::size_t>(v)] >= 0 ||
                                 tree.coupling_of_v[static_cast<std::size_t>(v)] >= 0);
    if (!free || of_virtual_link(model, static_cast<int>(c))) continue;
    const Joint& joint = model.joints[static_cast<std::size_t>(model.coordinates[c].joint)];
    if (is_bare(joint.child) || is_bare(joint.parent)) coordinates.push_back(static_cast<int>(c));
  }
  return coordinates;
}

TrackingProblem markers_alone(const TrackingProblem& tracking) {
  TrackingProblem alone = tracking;
  alone.coordinates.clear();
  alone.wires.clear();
  alone.virtual_links.clear();
  alone.problem.coordinates.clear();
  alone.problem.orientations.clear();
  alone.problem.distances.clear();
  alone.problem.wires.clear();
  alone.problem.wire_points.clear();
  // Their usual weight would make the markers' part look like rounding.
  for (CoincidenceResidual& loop : alone.problem.coincidences) loop.weight = 1.0;
  for (AlignmentResidual& loop : alone.problem.alignments) loop.weight = 1.0;
  return alone;
}

MarkerCoverage marker_coverage(const MusculoskeletalModel& model, const KinematicTree& tree,
                               const TrackingProblem& tracking, const MarkerTrajectories& markers,
                               int first_frame, const TrackingResult* solved) {
  MarkerCoverage coverage;
  const int count = solved != nullptr ? static_cast<int>(solved->frames.size())
                                      : markers.frame_count() - first_frame;
  const int frame = fullest_frame(tracking, markers, first_frame, count);
  const TrackingProblem alone = markers_alone(tracking);
  IkTargets targets(alone.problem);
  set_targets(alone, markers, frame, targets);
  std::vector<double> q = tree.default_q;
  for (std::size_t c = 0; solved != nullptr && c < tree.q_of_coordinate.size(); ++c) {
    q[static_cast<std::size_t>(tree.q_of_coordinate[c])] =
        solved->coordinates(frame - first_frame, static_cast<Eigen::Index>(c));
  }
  for (const int c : undetermined_coordinates(model, tree, alone, targets, q)) {
    if (!of_virtual_link(model, c)) coverage.undetermined.push_back(c);
  }
  const std::vector<Segment> segments = segments_of(model, tree);
  const std::vector<bool> told = often_measured(tracking, markers, first_frame, count);
  const auto has_marker = [&](const Segment& segment) {
    for (std::size_t i = 0; i < tracking.markers.size(); ++i) {
      const Marker& marker = model.markers[static_cast<std::size_t>(tracking.markers[i].model)];
      if (told[i] && segments[static_cast<std::size_t>(marker.body)] == segment) return true;
    }
    return false;
  };
  for (std::size_t b = 1; b < model.bodies.size(); ++b) {
    const Segment& segment = segments[b];
    const bool listed = std::find(coverage.bare_segments.begin(), coverage.bare_segments.end(),
                                  segment) != coverage.bare_segments.end();
    const bool small = segment.part == "knee cap" || model.bodies[b].virtual_link;
    if (listed || small || !moves(model, tree, static_cast<int>(b)) || has_marker(segment)) {
      continue;
    }
    coverage.bare_segments.push_back(segment);
  }
  coverage.bare_coordinates = coordinates_beside(model, tree, segments, coverage.bare_segments);
  return coverage;
}

std::vector<VerdictReason> coverage_reasons(const MusculoskeletalModel& model,
                                            const MarkerCoverage& coverage) {
  std::vector<VerdictReason> reasons;
  if (!coverage.bare_segments.empty()) {
    VerdictReason reason = reason_of(model, coverage.bare_coordinates);
    reason.code = "segment-without-marker";
    const std::string segments = segments_in_words(coverage.bare_segments);
    const bool one = coverage.bare_segments.size() == 1;
    reason.text = fmt::format("{} {} no marker", segments, one ? "has" : "have");
    if (!coverage.bare_coordinates.empty()) {
      reason.text +=
          fmt::format(": no measurement tells {}", some_names(model, coverage.bare_coordinates));
    }
    reason.remedy = "put markers there, or say with a map of names which recorded ones are there";
    reason.figure = static_cast<double>(coverage.bare_segments.size());
    reason.limit = 0.0;
    reasons.push_back(std::move(reason));
  }
  std::vector<int> others;
  std::set_difference(coverage.undetermined.begin(), coverage.undetermined.end(),
                      coverage.bare_coordinates.begin(), coverage.bare_coordinates.end(),
                      std::back_inserter(others));
  if (!others.empty()) {
    VerdictReason reason = reason_of(model, others);
    reason.code = "undetermined-coordinates";
    reason.text = fmt::format("the tracked markers do not tell {}", some_names(model, others));
    reason.remedy = "track more markers on the segments that these joints connect";
    reason.figure = static_cast<double>(others.size());
    reason.limit = 0.0;
    reasons.push_back(std::move(reason));
  }
  return reasons;
}

std::string misfit_causes(const MusculoskeletalModel& model, const KinematicTree& tree,
                          const TrackingProblem& tracking, double marker_rms) {
  if (!(marker_rms > kNoPerson)) return {};
  const auto carried = [&](int body) {
    for (int b = body; b > 0; b = model.joints[static_cast<std::size_t>(b) - 1].parent) {
      if (moves(model, tree, b)) return true;
    }
    return false;
  };
  const bool any = std::any_of(
      tracking.markers.begin(), tracking.markers.end(), [&](const TrackedMarker& marker) {
        return carried(model.markers[static_cast<std::size_t>(marker.model)].body);
      });
  const std::string far =
      fmt::format("the markers are {:.0f} mm from the model's", 1e3 * marker_rms);
  if (!any) {
    return far +
           ": none that is tracked is on a body that moves, so that no coordinate follows from "
           "them; `sinew model check` tells of such models";
  }
  return far +
         ", farther than those of any person: the recording's unit or axes, markers with exchanged "
         "names, or a model of somebody else; `sinew check RECORDING --model MODEL` tells which";
}

}  // namespace sinew
