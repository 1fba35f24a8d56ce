#include "pipeline/ik_job.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>
#include <utility>

#include "data/storage_file.h"
#include "data/trc_file.h"
#include "dynamics/coordinate_spline.h"
#include "model/osim_file.h"

namespace sinew {
namespace {

void append(std::vector<Warning>& all, const std::vector<Warning>& more) {
  all.insert(all.end(), more.begin(), more.end());
}

// Values of a coordinate file at the recording's times; NaN outside the file and for coordinates
// that it does not have.
RowMatrix values_at(const Eigen::VectorXd& time, const CoordinateTable& table) {
  const CoordinateSpline spline(table.time, table.q);
  RowMatrix values = RowMatrix::Constant(time.size(), table.q.cols(), kNaN);
  std::vector<double> q(static_cast<std::size_t>(spline.size()));
  for (Eigen::Index frame = 0; frame < time.size(); ++frame) {
    if (time[frame] < spline.first_time() || time[frame] > spline.last_time()) continue;
    spline.evaluate(time[frame], q, {}, {});
    for (Eigen::Index c = 0; c < values.cols(); ++c) {
      if (table.measured[static_cast<std::size_t>(c)]) {
        values(frame, c) = q[static_cast<std::size_t>(c)];
      }
    }
  }
  return values;
}

}  // namespace

IkJob prepare_ik(const IkInputs& inputs) {
  IkJob job;
  job.model = read_osim(inputs.model_file);
  job.tree = compile_tree(job.model);
  job.recording = read_trc(inputs.marker_file);
  append(job.warnings, job.model.warnings);
  append(job.warnings, job.recording.warnings);
  RowMatrix values;
  if (!inputs.coordinate_file.empty()) {
    const CoordinateTable table = coordinate_table(job.model, read_storage(inputs.coordinate_file));
    append(job.warnings, table.warnings);
    values = values_at(job.recording.markers.time, table);
  }
  if (inputs.tasks) append(job.warnings, inputs.tasks->warnings);
  job.tracking =
      bind_recording(job.model, job.tree, job.recording, inputs.tasks ? &*inputs.tasks : nullptr,
                     values.size() > 0 ? &values : nullptr);
  append(job.warnings, job.tracking.warnings);
  std::tie(job.options.first_frame, job.options.end_frame) =
      frames_within(job.recording.markers.time, inputs.from, inputs.to, job.recording.path);
  job.options.minimizer.method = method_from_string(inputs.method);
  job.options.minimizer.gradient_tolerance = inputs.tolerance;
  job.options.threads = inputs.threads;
  return job;
}

std::pair<int, int> frames_within(const Eigen::VectorXd& time, std::optional<double> from,
                                  std::optional<double> to, const std::string& file) {
  const Eigen::Index n = time.size();
  // Files print times rounded; a thousandth of a step is far more than that and far less than one.
  const double slack = n > 1 ? 1e-3 * (time[n - 1] - time[0]) / static_cast<double>(n - 1) : 0.0;
  Eigen::Index first = 0, end = n;
  while (first < n && from && time[first] < *from - slack) ++first;
  while (end > first && to && time[end - 1] > *to + slack) --end;
  if (first >= end) {
    throw InputError({file},
                     {fmt::format("no frame lies between {} s and {} s", from.value_or(-HUGE_VAL),
                                  to.value_or(HUGE_VAL)),
                      n == 0 ? "at least one frame"
                             : fmt::format("a range within {} s to {} s", time[0], time[n - 1]),
                      "", "Correct the time range."});
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
                  const std::string& element) {
  if (!file.empty() && std::filesystem::exists(file)) return;
  throw InputError(named_at, {fmt::format("<{}> names a file that does not exist", element),
                              "an existing file, relative to the setup's folder",
                              file.empty() ? "nothing" : file.string(),
                              "Correct the path, or give the file on the command line."});
}

}  // namespace sinew
