#include "pipeline/lab_motion.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <stdexcept>

#include "data/output_file.h"
#include "data/text.h"
#include "ik/auto_scale.h"
#include "ik/tracking.h"
#include "ik/upright_posture.h"
#include "model/kinematic_tree.h"
#include "pipeline/command.h"
#include "pipeline/prepare_options.h"

namespace sinew {
namespace {

constexpr double kRunningSpeed = 2.2;                          // [m/s]
constexpr double kWalkingCutoff = 6.0, kRunningCutoff = 15.0;  // [Hz]
// Splines are off by 2 to 3 mm over this time and by 8 to 17 mm over twice as much: kFilledWeight.
constexpr double kMaxGap = 0.1;  // [s]
// What a sample may be off to say as much of sizes as a measured one: less than skin moves it [m].
constexpr double kGoodFill = 0.002;
// Markers on a segment that tell where it is and how it is turned.
constexpr int kTellAPose = 3;
// As when sizes are fitted [1/rad² over 1/m²]. With a tenth of it spines of real trials buckled to
// one side and, from one frame to the next, to the other.
const double kPostureWeight =
    std::pow(AutoScaleOptions{}.marker_sd / AutoScaleOptions{}.posture_sd, 2);

// Markers that the model has, by index.
std::vector<int> tracked_markers(const MarkerTrajectories& markers,
                                 const MusculoskeletalModel& model) {
  std::vector<int> tracked;
  for (int i = 0; i < markers.marker_count(); ++i) {
    if (model.find_marker(markers.names[static_cast<std::size_t>(i)]) >= 0) tracked.push_back(i);
  }
  return tracked;
}

bool is_measured(const MarkerTrajectories& markers, int frame, int marker) {
  return !std::isnan(markers.p_WM(frame, 3 * marker));
}

int measured_count(const MarkerTrajectories& markers, int frame, const std::vector<int>& which) {
  return static_cast<int>(std::count_if(which.begin(), which.end(),
                                        [&](int m) { return is_measured(markers, frame, m); }));
}

// Horizontal way of the middle of all markers over time, of those frames in which it is known.
double speed_of(const MarkerTrajectories& markers) {
  double way = 0.0, time = 0.0;
  for (int m = 0; m < markers.marker_count(); ++m) {
    int first = -1, last = -1;
    for (int f = 0; f < markers.frame_count(); ++f) {
      if (!is_measured(markers, f, m)) continue;
      if (first < 0) first = f;
      last = f;
    }
    if (first < 0 || last == first) continue;
    Eigen::Vector3d d = markers.position(last, m) - markers.position(first, m);
    d.y() = 0.0;
    way += d.norm();
    time += markers.time[last] - markers.time[first];
  }
  return time > 0.0 ? way / time : 0.0;
}

// The frame in which most markers are measured.
int fullest_frame(const MarkerTrajectories& markers, const std::vector<int>& which) {
  int best = 0, most = -1;
  for (int f = 0; f < markers.frame_count(); ++f) {
    const int count = measured_count(markers, f, which);
    if (count <= most) continue;
    most = count;
    best = f;
  }
  return best;
}

}  // namespace

Decision matched_cutoff(const MarkerTrajectories& markers) {
  const double speed = speed_of(markers);
  const bool runs = speed > kRunningSpeed;
  const double cutoff = runs ? kRunningCutoff : kWalkingCutoff;
  Decision decision{"marker cutoff",
                    {},
                    cutoff,
                    fmt::format("{} at {:.2g} m/s", runs ? "running" : "walking", speed),
                    {},
                    "",
                    "--marker-cutoff",
                    Decision::Range::kCutoff};
  if (cutoff >= 0.5 * markers.rate) {
    decision.found = -1;
    decision.why = fmt::format("{} Hz is not below half of the markers' {} Hz", cutoff,
                               text::format_number(markers.rate));
  }
  return decision;
}

GapFillResult fill_lab_markers(MarkerTrajectories& markers, const std::string& path,
                               const std::filesystem::path& model_file,
                               const std::filesystem::path& filled_file, DecisionLog& log,
                               std::vector<Warning>& warnings) {
  PrepareOptions prepare;
  prepare.segments_from = model_file.string();
  prepare.max_gap = log.settle_number({"max gap",
                                       {},
                                       kMaxGap,
                                       "[s] by a spline, about ten frames",
                                       {},
                                       "",
                                       "--max-gap",
                                       Decision::Range::kZeroOrMore},
                                      true);
  prepare.fill_rigid =
      log.settle_flag({"fill rigid",
                       {},
                       true,
                       "from three or more markers of the same body, gaps of any length",
                       {},
                       "",
                       "--no-fill-rigid"},
                      true);
  const MarkerTrajectories before = markers;
  GapFillResult filled = prepare_markers(markers, path, prepare, warnings);
  // Unless something is filled, nobody has looked for gaps.
  if (!prepare.fills_gaps()) filled.left = find_gaps(before);
  write_file_atomically(filled_file, filled_gaps_csv(before, filled));
  return filled;
}

MarkerTrajectories well_filled(const MarkerTrajectories& markers, const GapFillResult& filled) {
  MarkerTrajectories result = markers;
  for (const FilledGap& gap : filled.filled) {
    if (gap.error <= kGoodFill) continue;
    result.p_WM.block(gap.gap.first, 3 * gap.gap.marker, gap.gap.count, 3).setConstant(kNaN);
  }
  return result;
}

double filter_lab_markers(MarkerTrajectories& markers, const std::string& path, DecisionLog& log,
                          std::vector<Warning>& warnings) {
  PrepareOptions prepare;
  const double cutoff = log.settle_number(matched_cutoff(markers));
  if (cutoff > 0.0) prepare.marker_cutoff = cutoff;
  prepare_markers(markers, path, prepare, warnings);
  return cutoff;
}

namespace {

// The body that a tracked marker is on.
int body_of(const MarkerTrajectories& markers, const MusculoskeletalModel& model, int marker) {
  const int m = model.find_marker(markers.names[static_cast<std::size_t>(marker)]);
  return model.markers[static_cast<std::size_t>(m)].body;
}

// Of the tracked markers those on the segment that all others hang from; none where it never has
// the three that tell its pose.
std::vector<int> root_markers(const MarkerTrajectories& markers, const MusculoskeletalModel& model,
                              const std::vector<int>& tracked) {
  std::map<int, std::vector<int>> by_body;
  for (const int m : tracked) {
    const int body = body_of(markers, model, m);
    if (body == 0) continue;
    const Joint& joint = model.joints[static_cast<std::size_t>(body) - 1];
    if (joint.parent == 0 && joint.kind != Joint::Kind::kWeld) by_body[body].push_back(m);
  }
  if (by_body.size() != 1) return {};
  const std::vector<int>& root = by_body.begin()->second;
  for (int f = 0; f < markers.frame_count(); ++f) {
    if (measured_count(markers, f, root) >= kTellAPose) return root;
  }
  return {};
}

}  // namespace

std::pair<double, double> settle_range(const MarkerTrajectories& markers,
                                       const MusculoskeletalModel& model, DecisionLog& log) {
  const std::vector<int> tracked = tracked_markers(markers, model);
  const std::vector<int> root = root_markers(markers, model, tracked);
  int first = -1, last = -1;
  for (int f = 0; f < markers.frame_count(); ++f) {
    if (2 * measured_count(markers, f, tracked) < static_cast<int>(tracked.size())) continue;
    if (!root.empty() && measured_count(markers, f, root) < kTellAPose) continue;
    if (first < 0) first = f;
    last = f;
  }
  std::string why = "[s] where at least half of the tracked markers are measured";
  if (!root.empty()) {
    const int body = body_of(markers, model, root.front());
    why += fmt::format(", three on the {} among them",
                       model.bodies[static_cast<std::size_t>(body)].name);
  }
  if (first < 0) {
    first = 0;
    last = markers.frame_count() - 1;
    why = "[s] the whole record, though nowhere half of the tracked markers are measured";
  }
  const double from = log.settle_number({"from", {}, markers.time[first], why, {}, "", "--from"});
  const double to = log.settle_number({"to", {}, markers.time[last], why, {}, "", "--to"});
  return {from, to};
}

std::vector<IkTask> marker_tasks(const MarkerTrajectories& markers,
                                 const MusculoskeletalModel& model) {
  std::vector<IkTask> tasks;
  for (const int m : tracked_markers(markers, model)) {
    if (!markers.p_WM.col(3 * m).array().isFinite().any()) continue;
    IkTask task;
    task.name = markers.names[static_cast<std::size_t>(m)];
    tasks.push_back(task);
  }
  return tasks;
}

std::vector<IkTask> posture_tasks(const MarkerTrajectories& markers,
                                  const MusculoskeletalModel& model, double weight) {
  const KinematicTree tree = compile_tree(model);
  BindingOptions markers_only;
  markers_only.wires.use = WireOptions::Use::kNone;
  markers_only.wires.virtual_link_weight = 0.0;
  markers_only.name_unmatched = false;
  const MarkerFile recording{"markers", markers, {}};
  const TrackingProblem tracking =
      bind_recording(model, tree, recording, nullptr, nullptr, markers_only);
  IkTargets targets(tracking.problem);
  set_targets(tracking, markers, fullest_frame(markers, tracked_markers(markers, model)), targets);
  const auto marker_weights = static_cast<double>(tracking.markers.size());  // 1 each
  std::vector<IkTask> tasks;
  for (const int c : undetermined_coordinates(model, tree, tracking, targets, tree.default_q)) {
    const Coordinate& coordinate = model.coordinates[static_cast<std::size_t>(c)];
    if (model.bodies[static_cast<std::size_t>(coordinate.joint) + 1].virtual_link) continue;
    IkTask task;
    task.kind = IkTask::Kind::kCoordinate;
    task.name = coordinate.name;
    task.weight = weight / marker_weights;
    tasks.push_back(task);
  }
  return tasks;
}

double default_posture_weight() { return kPostureWeight; }

namespace {

// As tasks of a file; angles in degrees.
TimeTable posture_table(const MusculoskeletalModel& model, const MarkerTrajectories& markers,
                        const UprightPosture& posture) {
  TimeTable table;
  table.name = "Coordinates";
  table.in_degrees = true;
  table.time = markers.time;
  table.values = posture.values * (180.0 / std::numbers::pi);
  for (const int c : posture.coordinates) {
    table.labels.push_back(model.coordinates[static_cast<std::size_t>(c)].name);
  }
  return table;
}

bool settle_upright(const std::vector<Segment>& segments, DecisionLog& log) {
  const std::string posture = log.settle_text(
      {"posture",
       {},
       "upright",
       fmt::format("{} {} no marker; people keep them upright", segments_in_words(segments),
                   segments.size() == 1 ? "has" : "have"),
       {},
       "",
       "--posture"});
  if (posture == "upright" || posture == "default") return posture == "upright";
  throw std::invalid_argument(
      fmt::format("the decision 'posture' is '{}'; expected upright or default", posture));
}

}  // namespace

LabTasks lab_tasks(const MarkerTrajectories& markers, const MusculoskeletalModel& model,
                   int threads, DecisionLog& log) {
  LabTasks result;
  std::vector<IkTask>& tasks = result.tasks;
  tasks = marker_tasks(markers, model);
  std::vector<IkTask> free = posture_tasks(markers, model, kPostureWeight);
  const double weight = log.settle_number(
      {"posture weight",
       {},
       kPostureWeight,
       fmt::format("[1/rad²] draws {} coordinates that the markers do not determine to their "
                   "defaults",
                   free.size()),
       {},
       "",
       "--posture-weight",
       Decision::Range::kZeroOrMore},
      true);
  if (!(weight > 0.0)) return result;
  const auto marker_weights = static_cast<double>(tasks.size());  // 1 each
  for (IkTask& task : free) {
    task.weight = weight / marker_weights;
    tasks.push_back(task);
  }
  TrackingOptions options;
  options.threads = threads;
  IkTaskSet set;
  set.tasks = tasks;
  const UprightPosture posture =
      upright_posture(model, compile_tree(model), {"markers", markers, {}}, set, weight, options);
  if (posture.empty() || !settle_upright(posture.segments, log)) return result;
  result.posture = posture_table(model, markers, posture);
  for (IkTask& task : tasks) {
    if (task.kind == IkTask::Kind::kCoordinate && result.posture->find_column(task.name) >= 0) {
      task.value_type = IkTask::ValueType::kFromFile;
    }
  }
  return result;
}

}  // namespace sinew
