#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "data/c3d_reader.h"
#include "data/c3d_writer.h"
#include "data/conditioning.h"
#include "data/force_table.h"
#include "data/marker_table.h"
#include "data/trc_file.h"
#include "pipeline/command.h"
#include "pipeline/conversion.h"
#include "pipeline/gait_event_options.h"
#include "pipeline/lab_trial.h"
#include "pipeline/laboratory.h"

namespace sinew {
namespace {

namespace fs = std::filesystem;

// Enough frames to see which way is up and where the subject goes, in bounded memory.
constexpr std::uint64_t kSampleBytes = std::uint64_t{32} << 20;
constexpr int kBlockFrames = 256;

}  // namespace

// What of a C3D file goes into a file of this format.
std::string Conversion::what_of(Format target) const {
  if (!what.empty()) {
    if (target == Format::kTrc && what != "markers") {
      throw std::invalid_argument(fmt::format(
          "--what {} does not go into a TRC file, which holds markers: choose .mot, .sto or .csv",
          what));
    }
    return what;
  }
  if (target == Format::kMot) return "forces";
  return target == Format::kSto ? "analog" : "markers";
}

void Conversion::from_c3d(const std::string& input, const fs::path& output) {
  const Format target = format_of(output);
  const bool markers_only = target == Format::kTrc && what_of(target) == "markers";
  const bool changes = prepare.conditions() || prepare.edit.edits().any();
  if (markers_only && !changes) return stream_markers(input, output);
  return target == Format::kC3d ? rewrite_c3d(input, output) : convert_c3d(input, output);
}

void Conversion::stream_markers(const std::string& input, const fs::path& output) {
  C3dReader reader(input);
  const C3dLayout layout = reader.description().layout;
  require_c3d_part(reader.description(), !reader.description().markers.names.empty(), "markers");
  const Turn turn = turn_of_start(input, layout);
  const double step = 1.0 / layout.rate;
  std::int64_t first = 0, end = layout.frames;
  if (from || to) {
    // A thousandth of a step is more than rounding and less than a frame.
    if (from) first = std::max<std::int64_t>(0, std::llround(std::ceil(*from / step - 1e-3)));
    if (to) end = std::min<std::int64_t>(end, std::llround(std::floor(*to / step + 1e-3)) + 1);
    if (first >= end) {
      throw InputError({input}, {"no frame lies between --from and --to",
                                 fmt::format("times in 0 s to {:.6g} s",
                                             static_cast<double>(layout.frames - 1) * step),
                                 "", "Choose other times."});
    }
  }
  TrcWriter writer(
      output,
      {reader.description().markers.names, layout.rate, end - first, layout.first_frame + first},
      TrcPrecision::kSingle);
  watch_interrupts();
  C3dFrames block;
  while (reader.frames_left() > 0) {
    if (interrupted()) throw std::runtime_error("stopped; nothing was written");
    const int count = reader.read(kBlockFrames, block);
    if (turn.rotates) rotate_vectors(turn.R_MW, block.p_WM);
    for (int i = 0; i < count; ++i) {
      const std::int64_t frame = block.first + i;
      if (frame < first || frame >= end) continue;
      writer.append(layout.first_frame + frame, static_cast<double>(frame) / layout.rate,
                    block.p_WM.row(i).data());
    }
  }
  report(warnings, reader.description().warnings);
  writer.finish();
  done(output, "markers", end - first, layout.rate);
}

Turn Conversion::turn_of_start(const std::string& input, const C3dLayout& layout) {
  if (prepare.up == "keep") return {};
  const auto frames = std::max<std::uint64_t>(kSampleBytes / layout.frame_bytes, 1);
  const C3dFile start = read_c3d(input, static_cast<std::int64_t>(frames));
  return announce_turn(start, compute_forces(start).recordings, prepare, warnings);
}

void Conversion::convert_c3d(const std::string& input, const fs::path& output) {
  const C3dFile file = read_edited_c3d(input, prepare, warnings);
  const std::string part = what_of(format_of(output));
  const ForcePlatforms platforms = compute_forces(file, {.threshold = prepare.threshold});
  if (part == "forces") report(warnings, platforms.warnings);
  if (part == "events") {
    return write_events(output, input, find_gait_events(file, platforms.recordings), file.markers);
  }
  if (part == "markers") {
    require_c3d_part(file, file.markers.marker_count() > 0, "markers");
    Recording recording{input, file.markers, {}};
    const Turn turn = announce_turn(file, platforms.recordings, prepare, warnings);
    if (turn.rotates) rotate_vectors(turn.R_MW, recording.markers->p_WM);
    condition_markers(recording, output);
    if (format_of(output) == Format::kTrc) return write_markers(output, *recording.markers);
    return write_table(output, marker_table(*recording.markers));
  }
  if (part == "forces") return convert_forces(file, platforms.recordings, output);
  write_table(output, part == "analog" ? analog_table(file) : computed_table(file));
}

void Conversion::convert_forces(const C3dFile& file, std::vector<ForcePlatformRecording> plates,
                                const fs::path& output) {
  const Turn turn = announce_turn(file, plates, prepare, warnings);
  for (ForcePlatformRecording& plate : plates) rotate(plate, turn.R_MW);
  condition_plates(plates, prepare);
  const TimeTable table = force_table(plates);
  require_c3d_part(file, !table.labels.empty(), "force platform that can be used");
  write_table(output, cropped(table, file.path));
}

TimeTable Conversion::analog_table(const C3dFile& file) {
  require_c3d_part(file, file.analog.channel_count() > 0, "analog channels");
  TimeTable table;
  table.name = "Analog channels";
  table.labels = file.analog.labels;
  table.values = file.analog.values;
  table.time = Eigen::VectorXd::LinSpaced(
      table.values.rows(), 0.0, static_cast<double>(table.values.rows() - 1) / file.analog.rate);
  if (prepare.analog_cutoff) lowpass(table, *prepare.analog_cutoff);
  if (prepare.rate) table = resample(table, *prepare.rate);
  return cropped(table, file.path);
}

TimeTable Conversion::computed_table(const C3dFile& file) {
  require_c3d_part(file, file.computed.count() > 0, "computed trajectories");
  TimeTable table;
  table.name = "Computed trajectories";
  for (const std::string& label : file.computed.labels) {
    for (const char axis : {'x', 'y', 'z'}) table.labels.push_back(label + "." + axis);
  }
  table.time = file.markers.time;
  table.values = file.computed.values;
  return cropped(table, file.path);
}

// C3D to C3D keeps the laboratory's axes unless --up or --forward asks for others.
void Conversion::rewrite_c3d(const std::string& input, const fs::path& output) {
  if (prepare.rate) {
    throw std::invalid_argument(
        "--rate does not go with C3D files, whose channels are tied to the frames: convert to "
        "TRC and MOT");
  }
  if (prepare.force_cutoff) {
    throw std::invalid_argument(
        "--force-cutoff does not go with C3D files, which hold the plates' channels: give "
        "--analog-cutoff, or convert to MOT");
  }
  C3dFile file = read_edited_c3d(input, prepare, warnings);
  if (!events.empty()) {
    const ForcePlatforms platforms = compute_forces(file, {.threshold = prepare.threshold});
    replace_gait_events(file, find_gait_events(file, platforms.recordings, events));
  }
  if (!prepare.up.empty() || !prepare.forward.empty()) {
    const Turn turn = announce_turn(file, compute_forces(file).recordings, prepare, warnings);
    if (turn.rotates) sinew::rotate(file, turn.R_MW);
  }
  fill_and_filter(file.markers, input, output);
  if (prepare.analog_cutoff) filter_analog(file);
  if (from || to) {
    const auto [first, end] = frames(file.markers.time, file.path);
    crop(file, first, end);
  }
  write_c3d(output, file, {.integers = integers});
  done(output, "markers", file.markers.frame_count(), file.markers.rate);
}

void Conversion::filter_analog(C3dFile& file) const {
  TimeTable table;
  table.labels = file.analog.labels;
  table.values = std::move(file.analog.values);
  table.time = Eigen::VectorXd::LinSpaced(
      table.values.rows(), 0.0, static_cast<double>(table.values.rows() - 1) / file.analog.rate);
  lowpass(table, *prepare.analog_cutoff);
  file.analog.values = std::move(table.values);
}

}  // namespace sinew
