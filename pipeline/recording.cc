#include "pipeline/recording.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "data/conditioning.h"
#include "data/csv_file.h"
#include "data/marker_table.h"
#include "data/storage_file.h"
#include "data/text.h"
#include "data/trc_description.h"
#include "data/trc_file.h"
#include "pipeline/command.h"

namespace sinew {
namespace {

namespace fs = std::filesystem;

// Samples at a whole multiple of the markers' rate, at or above the table's own.
void add_channels(const Recording& recording, C3dFile& file) {
  const TimeTable& table = *recording.table;
  const MarkerTrajectories& markers = file.markers;
  const double rate = uniform_rate(table);
  C3dAnalog& analog = file.analog;
  const int ratio = std::max(1, static_cast<int>(std::ceil(rate / markers.rate - 0.01)));
  if (analog.channel_count() > 0 && ratio != analog.samples_per_frame) {
    throw InputError(
        {recording.path},
        {"has another rate than the table before it", fmt::format("{} Hz", analog.rate),
         fmt::format("{:.6g} Hz", rate), "Resample it first: sinew convert --rate."});
  }
  analog.samples_per_frame = ratio;
  analog.rate = ratio * markers.rate;
  const Eigen::Index samples = Eigen::Index{markers.frame_count()} * ratio;
  Eigen::VectorXd time(samples);
  for (Eigen::Index i = 0; i < samples; ++i) {
    time[i] = markers.time[0] + static_cast<double>(i) / analog.rate;
  }
  // The last frame's samples go on behind it, where a table may have ended.
  const double last = table.time[table.time.size() - 1];
  if (table.time[0] > time[0] + 0.5 / rate ||
      last < markers.time[markers.time.size() - 1] - 0.5 / rate) {
    throw InputError({recording.path}, {"does not cover the markers",
                                        fmt::format("{:.6g} s to {:.6g} s", markers.time[0],
                                                    markers.time[markers.time.size() - 1]),
                                        fmt::format("{:.6g} s to {:.6g} s", table.time[0], last),
                                        "Crop the markers with --from and --to."});
  }
  const Eigen::VectorXd within = time.cwiseMax(table.time[0]).cwiseMin(last);
  const RowMatrix values = values_at(table.time, table.values, within);
  const Eigen::Index columns = analog.values.cols();
  analog.values.conservativeResize(samples, columns + values.cols());
  analog.values.rightCols(values.cols()) = values;
  analog.labels.insert(analog.labels.end(), table.labels.begin(), table.labels.end());
  analog.units.resize(analog.labels.size());
}

}  // namespace

Format format_of(const fs::path& path) {
  const std::string extension = text::lower(path.extension().string());
  if (extension == ".c3d") return Format::kC3d;
  if (extension == ".trc") return Format::kTrc;
  if (extension == ".mot") return Format::kMot;
  if (extension == ".sto") return Format::kSto;
  if (extension == ".csv") return Format::kCsv;
  throw InputError({path.string()},
                   {"is of no known format", fmt::format("{} at the end", kRecordingFormats),
                    extension, "Name the file so, or convert it elsewhere."});
}

Recording read_recording(const std::string& input, std::vector<Warning>& warnings) {
  Recording recording;
  recording.path = input;
  if (format_of(input) == Format::kTrc) {
    MarkerFile file = read_trc(input);
    report(warnings, file.warnings);
    recording.markers = std::move(file.markers);
    recording.metres_per_unit = read_trc_description(input).metres_per_unit;
    return recording;
  }
  TimeTableFile file = format_of(input) == Format::kCsv ? read_csv(input) : read_storage(input);
  report(warnings, file.warnings);
  if (file.table.time.size() == 0) {
    throw InputError({input}, {"has no rows", "", "", "Was it written completely?"});
  }
  if (holds_markers(file.table) && format_of(input) == Format::kCsv) {
    recording.markers = markers_from_table(file).markers;
    recording.metres_per_unit = metres_per_unit(file.table);
  } else {
    recording.table = std::move(file.table);
  }
  return recording;
}

void require_markers(Recording& recording) {
  if (recording.markers) return;
  recording.markers = markers_from_table({recording.path, *recording.table, {}}).markers;
  recording.table.reset();
}

C3dFile merge_to_c3d(const std::vector<Recording>& recordings, const std::string& path) {
  C3dFile file;
  file.path = path;
  file.markers = *recordings.front().markers;
  for (std::size_t i = 1; i < recordings.size(); ++i) {
    if (!recordings[i].table) {
      throw InputError({recordings[i].path}, {"is a second recording of markers", "one", "",
                                              "Merge one recording of markers with tables."});
    }
    add_channels(recordings[i], file);
  }
  return file;
}

void crop(C3dFile& file, int first, int end) {
  const int count = end - first, ratio = file.analog.samples_per_frame;
  const double start = file.markers.time[first];
  file.markers = slice(file.markers, first, end);
  const auto cut = [](auto& rows, int at, int n) {
    if (rows.rows() > 0) rows = rows.middleRows(at, n).eval();
  };
  cut(file.quality.residual, first, count);
  cut(file.quality.cameras, first, count);
  cut(file.computed.values, first, count);
  if (file.analog.channel_count() > 0) cut(file.analog.values, first * ratio, count * ratio);
  for (C3dEvent& event : file.events) event.time -= start;
  const double duration = static_cast<double>(count) / file.markers.rate;
  std::erase_if(file.events, [&](const C3dEvent& e) { return e.time < 0.0 || e.time > duration; });
}

}  // namespace sinew
