#include "pipeline/ik_job.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "data/gap_filling.h"
#include "data/storage_file.h"
#include "data/trc_file.h"
#include "model/osim_file.h"
#include "pipeline/command.h"
#include "pipeline/coordinate_values.h"
#include "pipeline/gap_reasons.h"
#include "pipeline/spikes.h"

namespace sinew {
namespace {

void append(std::vector<Warning>& all, const std::vector<Warning>& more) {
  all.insert(all.end(), more.begin(), more.end());
}

// `1 s to 2 s`, `from 1 s on`, …
std::string to_text(const TimeRange& range) {
  if (!range.from) return range.to ? fmt::format("up to {:.6g} s", *range.to) : "all";
  if (!range.to) return fmt::format("from {:.6g} s on", *range.from);
  return fmt::format("{:.6g} s to {:.6g} s", *range.from, *range.to);
}

void weigh_filled(const IkInputs& inputs, IkJob& job) {
  const MarkerTrajectories& markers = job.recording.markers;
  std::vector<FilledStretch> stretches;
  for (const FilledGap& filled : read_filled_gaps(inputs.filled_file, markers)) {
    const bool left = filled.method == FilledGap::Method::kNone;
    stretches.push_back({markers.names[static_cast<std::size_t>(filled.gap.marker)],
                         filled.gap.first, filled.gap.count,
                         left ? std::numeric_limits<double>::infinity() : filled.error});
  }
  weigh_filled_samples(job.tracking, markers, stretches, inputs.filled_weight);
}

// Where too few markers are seen nothing is invented: coordinates go from what is known before to
// what is known behind, and the reasons say which and when.
void bridge_gaps(IkJob& job, TrackingResult& result) {
  const MarkerTrajectories& markers = job.recording.markers;
  const int first = job.options.first_frame;
  const std::vector<UndeterminedStretch>& stretches = job.stretches = find_undetermined_stretches(
      job.model, job.tree, job.tracking, markers, first, result.coordinates);
  job.reasons = gap_reasons(
      job.model, job.tracking, markers, first, job.options.end_frame, stretches, job.reach,
      [&](const std::string& name) { return shown_marker(job.recorded_names, name); });
  if (stretches.empty()) return;
  const double seconds = result.seconds;
  const TrackingProblem bridged =
      bridge_stretches(job.model, job.tree, job.tracking, stretches, markers.frame_count(), first,
                       result.coordinates);
  result = track(job.model, job.tree, bridged, markers, job.options);
  result.seconds += seconds;
}

}  // namespace

std::string shown_marker(const std::map<std::string, std::string>& recorded_names,
                         const std::string& name) {
  const auto found = recorded_names.find(name);
  return found == recorded_names.end() ? name
                                       : fmt::format("{} (the model's {})", found->second, name);
}

InputFiles input_files(const IkInputs& inputs) {
  return {{"model", inputs.model_file},
          {"markers", inputs.marker_file},
          {"tasks", inputs.task_file},
          {"task_coordinates", inputs.coordinate_file},
          {"filled", inputs.filled_file}};
}

IkJob prepare_ik(const IkInputs& inputs) {
  IkJob job;
  job.model = read_osim(inputs.model_file);
  job.tree = compile_tree(job.model);
  job.recording = read_trc(inputs.marker_file);
  append(job.warnings, job.model.warnings);
  append(job.warnings, job.recording.warnings);
  if (inputs.leave_out_spikes) {
    leave_out_spikes(job.recording.markers, job.recording.path, "--spikes none", job.warnings);
  }
  RowMatrix values;
  if (!inputs.coordinate_file.empty()) {
    const CoordinateTable table = coordinate_table(job.model, read_storage(inputs.coordinate_file));
    append(job.warnings, table.warnings);
    values = coordinate_values_at(job.recording.markers.time, table);
  }
  if (inputs.tasks) append(job.warnings, inputs.tasks->warnings);
  BindingOptions binding;
  binding.wires = inputs.wires;
  binding.name_unmatched = inputs.name_unmatched;
  job.tracking =
      bind_recording(job.model, job.tree, job.recording, inputs.tasks ? &*inputs.tasks : nullptr,
                     values.size() > 0 ? &values : nullptr, binding);
  append(job.warnings, job.tracking.warnings);
  if (!inputs.filled_file.empty()) weigh_filled(inputs, job);
  std::tie(job.options.first_frame, job.options.end_frame) =
      frames_within(job.recording.markers.time, inputs.range, job.recording.path, job.warnings);
  job.options.minimizer.method = method_from_string(inputs.method);
  job.options.minimizer.gradient_tolerance = inputs.tolerance;
  job.options.cold_start.starts = inputs.starts;
  job.options.minimizer.record_iterations = inputs.record_iterations;
  job.options.threads = inputs.threads;
  job.check_recording = inputs.check_recording;
  job.recorded_names = inputs.recorded_names;
  job.reach = static_cast<int>(std::ceil(inputs.reach * job.recording.markers.rate));
  return job;
}

std::optional<TrackingResult> solve_ik(IkJob& job) {
  job.options.progress = progress_bar("inverse kinematics");
  TrackingResult result =
      track(job.model, job.tree, job.tracking, job.recording.markers, job.options);
  if (!result.stopped) bridge_gaps(job, result);
  if (result.stopped) {
    fmt::print(stderr, "stopped; no results were written\n");
    return std::nullopt;
  }
  require_finite_results(coordinate_motion(job.model, result), "inverse kinematics");
  return result;
}

void TimeRange::fill(std::optional<double> setup_from, std::optional<double> setup_to,
                     const SourceLocation& setup_at) {
  if ((!from && setup_from) || (!to && setup_to)) at = setup_at;
  if (!from) from = setup_from;
  if (!to) to = setup_to;
}

std::pair<int, int> frames_within(const Eigen::VectorXd& time, const TimeRange& range,
                                  const std::string& file, std::vector<Warning>& warnings) {
  const SourceLocation at = range.at.file.empty() ? SourceLocation{file, 0} : range.at;
  // Where one of them is beside the record, exchanging them helps nobody.
  if (range.from && range.to && *range.from > *range.to && *range.to < time[time.size() - 1] &&
      *range.from > time[0]) {
    throw InputError(
        at, {fmt::format("the time range ends at {:.6g} s, before it begins at {:.6g} s", *range.to,
                         *range.from),
             "", "", "Exchange --from and --to."});
  }
  const Eigen::Index n = time.size();
  // Files print times rounded; a thousandth of a step is far more than that and far less than one.
  const double step = n > 1 ? (time[n - 1] - time[0]) / static_cast<double>(n - 1) : 0.0;
  const double slack = 1e-3 * step;
  const double from = range.from.value_or(time[0]), to = range.to.value_or(time[n - 1]);
  Eigen::Index first = 0, end = n;
  while (first < n && time[first] < from - slack) ++first;
  while (end > first && time[end - 1] > to + slack) --end;
  const std::string record = fmt::format("{} has {:.6g} s to {:.6g} s", file, time[0], time[n - 1]);
  if (first >= end) {
    throw InputError(
        at, {fmt::format("no frame lies in the time range, {}; {}", to_text(range), record), "", "",
             "Choose another with --from and --to."});
  }
  if (from < time[0] - step - slack || to > time[n - 1] + step + slack) {
    warnings.push_back({at, fmt::format("the time range, {}, goes beyond the record; {}, and only "
                                        "that is solved",
                                        to_text(range), record)});
  }
  return {static_cast<int>(first), static_cast<int>(end)};
}

TimeTable coordinate_motion(const MusculoskeletalModel& model, const TrackingResult& result) {
  TimeTable table;
  table.name = "Coordinates";
  table.in_degrees = true;
  table.time = result.time;
  table.values = result.coordinates;
  for (std::size_t c = 0; c < model.coordinates.size(); ++c) {
    table.labels.push_back(model.coordinates[c].name);
    if (model.coordinates[c].motion == Coordinate::Motion::kRotational) {
      table.values.col(static_cast<Eigen::Index>(c)) *= 180.0 / std::numbers::pi;
    }
  }
  return table;
}

CoordinateTable coordinate_table(const MusculoskeletalModel& model, const TrackingResult& result) {
  CoordinateTable table;
  table.path = "inverse kinematics";
  table.time = result.time;
  table.q = result.coordinates;
  table.measured.assign(model.coordinates.size(), true);
  return table;
}

void require_file(const std::filesystem::path& file, const SourceLocation& named_at,
                  const std::string& element, const std::string& option) {
  const std::string remedy = fmt::format("Correct the setup, or give {} FILE.", option);
  if (file.empty()) {
    throw InputError(named_at, {fmt::format("<{}> names no file", element), "", "", remedy});
  }
  std::error_code error;
  if (std::filesystem::exists(file, error)) return;
  throw InputError(named_at, {fmt::format("<{}> names a file that does not exist", element),
                              "a path, relative to the setup's folder", file.string(), remedy});
}

void require_own_path(const std::filesystem::path& output, const SourceLocation& named_at,
                      const std::string& element) {
  if (output.is_absolute()) return;
  throw InputError(named_at, {fmt::format("<{}> is a path of another system", element),
                              "a path, relative to the setup's folder", output.string(),
                              "Correct the setup, or give --out FILE."});
}

namespace {

// Frames on one side of the range that have the tracked markers which `at` has: from it on, by
// steps of `step`, at most `most`.
int frames_beside(const IkJob& job, int at, int step, int most) {
  const MarkerTrajectories& markers = job.recording.markers;
  const auto complete = [&](int frame) {
    for (const TrackedMarker& marker : job.tracking.markers) {
      if (markers.position(at, marker.recorded).allFinite() &&
          !markers.position(frame, marker.recorded).allFinite()) {
        return false;
      }
    }
    return true;
  };
  int count = 0;
  for (int frame = at + step; count < most && frame >= 0 && frame < markers.frame_count();
       frame += step) {
    if (!complete(frame)) break;
    ++count;
  }
  return count;
}

}  // namespace

std::optional<CoordinateTable> motion_around(const IkJob& job, const TrackingResult& result,
                                             double seconds) {
  const CoordinateTable own = coordinate_table(job.model, result);
  const auto most = static_cast<int>(std::ceil(seconds * job.recording.markers.rate));
  const auto n = static_cast<int>(own.time.size());
  const int first = job.options.first_frame, last = first + n - 1;
  const int before = frames_beside(job, first, -1, most), after = frames_beside(job, last, 1, most);
  if (before == 0 && after == 0) return own;
  CoordinateTable all = own;
  all.time = job.recording.markers.time.segment(first - before, before + n + after);
  all.q.resize(before + n + after, own.q.cols());
  all.q.middleRows(before, n) = own.q;
  // `count` frames from `begin` on, of which the one in row `shared` is row `to` of the range too.
  const auto add = [&](int begin, int count, int shared, int to, int row) {
    TrackingOptions options = job.options;
    options.first_frame = begin;
    options.end_frame = begin + count;
    options.progress = progress_bar("frames beside the range");
    const TrackingResult beside =
        track(job.model, job.tree, job.tracking, job.recording.markers, options);
    if (beside.stopped) return false;
    const RowMatrix q = coordinate_table(job.model, beside).q;
    all.q.middleRows(row, count) = q.rowwise() + (own.q.row(to) - q.row(shared));
    all.q.row(row + shared) = own.q.row(to);
    return true;
  };
  if ((before > 0 && !add(first - before, before + 1, before, 0, 0)) ||
      (after > 0 && !add(last, after + 1, 0, n - 1, before + n - 1))) {
    fmt::print(stderr, "stopped; no results were written\n");
    return std::nullopt;
  }
  return all;
}

}  // namespace sinew
