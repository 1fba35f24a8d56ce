#include "pipeline/conversion.h"

#include <fmt/format.h>

#include <stdexcept>
#include <utility>

#include "data/c3d_writer.h"
#include "data/conditioning.h"
#include "data/csv_file.h"
#include "data/marker_table.h"
#include "data/output_file.h"
#include "data/storage_file.h"
#include "data/text.h"
#include "data/trc_file.h"
#include "pipeline/command.h"
#include "pipeline/gait_event_options.h"
#include "pipeline/ik_job.h"
#include "pipeline/laboratory.h"

namespace sinew {

namespace fs = std::filesystem;

fs::path Conversion::filled_path(const fs::path& output) const {
  if (!prepare.fills_gaps()) return {};
  return output.parent_path() / (output.stem().string() + "_filled.csv");
}

void Conversion::convert(const std::string& input, const fs::path& output) {
  const Format source = format_of(input), target = format_of(output);
  if (source == Format::kC3d) return from_c3d(input, output);
  if (!what.empty() && what != "events") {
    throw std::invalid_argument("--what chooses a part of a C3D file, which " + input +
                                " is not: leave it out");
  }
  Recording recording = read_recording(input, warnings);
  apply(prepare.edit.edits(), recording);
  if (what == "events") {
    require_markers(recording);
    const MarkerTrajectories& markers = *recording.markers;
    return write_events(output, input, find_gait_events(markers), markers);
  }
  if (target == Format::kTrc || target == Format::kC3d) require_markers(recording);
  condition(recording, output);
  if (target == Format::kC3d) {
    write_c3d(output, merge_to_c3d({recording}, output.string()), {.integers = integers});
    return done(output, "markers", recording.markers->frame_count(), recording.markers->rate);
  }
  if (target == Format::kTrc) return write_markers(output, *recording.markers);
  const TimeTable table = recording.table ? *recording.table : marker_table(*recording.markers);
  write_table(output, table);
}

void Conversion::condition(Recording& recording, const fs::path& output) {
  if (!recording.markers) return condition_table(recording);
  if (!prepare.up.empty() || !prepare.forward.empty()) {
    const Turn turn =
        find_turn(*recording.markers, recording.path, std::nullopt, {}, prepare, warnings);
    fmt::print("{}: {}\n", recording.path, describe(turn));
    if (turn.rotates) rotate_vectors(turn.R_MW, recording.markers->p_WM);
  }
  condition_markers(recording, output);
}

void Conversion::fill_and_filter(MarkerTrajectories& markers, const std::string& path,
                                 const fs::path& output) {
  if (prepare.conditions() && markers.frame_count() < 2) {
    throw InputError({path},
                     {"is too short to be filled, filtered or resampled", "at least 2 frames",
                      fmt::format("{}", markers.frame_count()), "Leave these options out."});
  }
  const MarkerTrajectories before = markers;
  const GapFillResult filled = prepare_markers(markers, path, prepare, warnings);
  if (!prepare.fills_gaps()) return;
  write_file_atomically(filled_path(output), filled_gaps_csv(before, filled));
}

void Conversion::condition_markers(Recording& recording, const fs::path& output) {
  MarkerTrajectories& markers = *recording.markers;
  fill_and_filter(markers, recording.path, output);
  const auto [first, end] = frames(markers.time, recording.path);
  markers = slice(markers, first, end);
}

void Conversion::condition_table(Recording& recording) {
  if (!prepare.up.empty() || !prepare.forward.empty() || prepare.fills_gaps() ||
      prepare.marker_cutoff || prepare.force_cutoff) {
    throw std::invalid_argument(
        fmt::format("{} is a table whose columns say nothing of axes, markers or forces: of the "
                    "options that change values only --analog-cutoff, --rate, --from and --to "
                    "apply to it",
                    recording.path));
  }
  TimeTable& table = *recording.table;
  if (prepare.analog_cutoff) lowpass(table, *prepare.analog_cutoff);
  if (prepare.rate) table = resample(table, *prepare.rate);
  table = cropped(table, recording.path);
}

void Conversion::merge(const std::vector<std::string>& inputs, const std::string& out) {
  std::vector<Recording> recordings;
  for (const std::string& input : inputs) {
    if (format_of(input) == Format::kC3d) {
      throw std::invalid_argument("a C3D file cannot be merged with others: " + input);
    }
    recordings.push_back(read_recording(input, warnings));
    edit_part(recordings.back());
    if (format_of(input) != Format::kTrc || recordings.size() == 1) continue;
    std::swap(recordings.front(), recordings.back());
  }
  require_markers(recordings.front());
  condition(recordings.front(), out);
  const C3dFile file = merge_to_c3d(recordings, out);
  write_c3d(out, file, {.integers = integers});
  done(out, "markers", file.markers.frame_count(), file.markers.rate);
}

std::pair<int, int> Conversion::frames(const Eigen::VectorXd& time, const std::string& path) {
  std::vector<Warning> more;
  TimeRange range;
  range.from = from;
  range.to = to;
  const auto result = frames_within(time, range, path, more);
  report(warnings, more);
  return result;
}

TimeTable Conversion::cropped(const TimeTable& table, const std::string& path) {
  const auto [first, end] = frames(table.time, path);
  return slice(table, first, end);
}

void Conversion::done(const fs::path& output, const char* what_is, Eigen::Index rows,
                      double rate) const {
  fmt::print("{}: {}, {} {} at {} Hz\n", output.string(), what_is, rows,
             std::string_view(what_is) == "markers" ? "frames" : "rows", text::format_number(rate));
}

// Of several inputs each gets the edits that are for its kind.
void Conversion::edit_part(Recording& recording) const {
  RecordingEdits edits = prepare.edit.edits();
  RecordingEdits of_table;
  std::swap(of_table.shift_forces, edits.shift_forces);
  std::swap(of_table.samples, edits.samples);
  apply(recording.markers ? edits : of_table, recording);
}

void Conversion::write_events(const fs::path& output, const std::string& input,
                              std::vector<GaitEvent> found,
                              const MarkerTrajectories& markers) const {
  if (format_of(output) != Format::kCsv) {
    throw std::invalid_argument(
        "--what events writes a table: give --out NAME.csv, or --events all for a C3D file");
  }
  std::erase_if(found, [&](const GaitEvent& event) {
    return (from && event.time < *from) || (to && event.time > *to);
  });
  write_file_atomically(output, events_csv(found, markers));
  fmt::print("{}: {} events of {}\n", output.string(), found.size(), input);
}

void Conversion::write_markers(const fs::path& output, const MarkerTrajectories& markers) {
  write_trc(output, markers);
  done(output, "markers", markers.frame_count(), markers.rate);
}

void Conversion::write_table(const fs::path& output, const TimeTable& table) {
  if (format_of(output) == Format::kCsv) {
    write_csv(output, table);
  } else {
    write_storage(output, table);
  }
  const Eigen::Index rows = table.time.size();
  fmt::print("{}: {} columns, {} rows from {:.6g} s to {:.6g} s\n", output.string(),
             table.labels.size(), rows, table.time[0], table.time[rows - 1]);
}

}  // namespace sinew
