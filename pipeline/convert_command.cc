#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <stdexcept>

#include "data/c3d_reader.h"
#include "data/c3d_writer.h"
#include "data/conditioning.h"
#include "data/csv_file.h"
#include "data/force_table.h"
#include "data/marker_table.h"
#include "data/output_file.h"
#include "data/storage_file.h"
#include "data/text.h"
#include "data/trc_file.h"
#include "model/osim_file.h"
#include "pipeline/command.h"
#include "pipeline/ground_reaction.h"
#include "pipeline/ik_job.h"
#include "pipeline/laboratory.h"
#include "pipeline/option_checks.h"
#include "pipeline/output_check.h"
#include "pipeline/prepare_options.h"
#include "pipeline/recording.h"

namespace sinew {
namespace {

namespace fs = std::filesystem;

// Enough frames to see which way is up and where the subject goes, in bounded memory.
constexpr std::uint64_t kSampleBytes = std::uint64_t{32} << 20;
constexpr int kBlockFrames = 256;

struct ConvertCommand {
  std::vector<std::string> inputs;
  std::string out, format, what, loads, model;
  std::vector<std::string> assign;
  std::optional<double> from, to;
  bool integers = false;
  PrepareOptions prepare;
  std::vector<Warning> warnings;

  int run() {
    if (out.empty()) throw std::invalid_argument("no output: give --out FILE");
    InputFiles files;
    for (const std::string& input : inputs) files.emplace_back("input", input);
    files.emplace_back("segments", prepare.segments_from);
    if (!loads.empty() || !assign.empty()) {
      files.emplace_back("model", model);
      check_outputs({out, loads, contacts_path(out)}, files);
      assign_loads();
    } else if (inputs.size() == 1 && format.empty()) {
      check_outputs({out, filled_path(out)}, files);
      convert(inputs.front(), out);
    } else if (format.empty() && format_of(out) == Format::kC3d) {
      check_outputs({out, filled_path(out)}, files);
      merge();
    } else {
      convert_all(files);
    }
    return kExitOk;
  }

  // Each input into a file of its name in the folder --out.
  void convert_all(const InputFiles& files) {
    if (format.empty()) {
      throw std::invalid_argument(
          "several inputs become one file only if that is a C3D file: give --out FILE.c3d, or "
          "--format trc and a folder as --out");
    }
    std::vector<fs::path> outputs;
    for (const std::string& input : inputs) {
      outputs.push_back(fs::path(out) / (fs::path(input).stem().string() + "." + format));
    }
    check_outputs(outputs, files);
    for (std::size_t i = 0; i < inputs.size(); ++i) convert(inputs[i], outputs[i]);
  }

  // The list of filled samples, beside the output; none where nothing is filled.
  fs::path filled_path(const fs::path& output) const {
    if (!prepare.fills_gaps()) return {};
    return output.parent_path() / (output.stem().string() + "_filled.csv");
  }

  void convert(const std::string& input, const fs::path& output) {
    const Format source = format_of(input), target = format_of(output);
    if (source == Format::kC3d) {
      const bool markers_only = target == Format::kTrc && what_of(target) == "markers";
      if (markers_only && !prepare.conditions()) return stream_markers(input, output);
      return target == Format::kC3d ? rewrite_c3d(input, output) : convert_c3d(input, output);
    }
    if (!what.empty()) {
      throw std::invalid_argument("--what chooses a part of a C3D file, which " + input +
                                  " is not: leave it out");
    }
    Recording recording = read_recording(input, warnings);
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

  // What of a C3D file goes into a file of this format.
  std::string what_of(Format target) const {
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

  std::pair<int, int> frames(const Eigen::VectorXd& time, const std::string& path) {
    std::vector<Warning> more;
    TimeRange range;
    range.from = from;
    range.to = to;
    const auto result = frames_within(time, range, path, more);
    report(warnings, more);
    return result;
  }

  void done(const fs::path& output, const char* what_is, Eigen::Index rows, double rate) const {
    fmt::print("{}: {}, {} {} at {} Hz\n", output.string(), what_is, rows,
               std::string_view(what_is) == "markers" ? "frames" : "rows",
               text::format_number(rate));
  }

  // ---- C3D, block by block

  void stream_markers(const std::string& input, const fs::path& output) {
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

  Turn turn_of_start(const std::string& input, const C3dLayout& layout) {
    if (prepare.up == "keep") return {};
    const auto frames = std::max<std::uint64_t>(kSampleBytes / layout.frame_bytes, 1);
    const C3dFile start = read_c3d(input, static_cast<std::int64_t>(frames));
    return turn_of(start, compute_forces(start).recordings);
  }

  Turn turn_of(const C3dFile& file, const std::vector<ForcePlatformRecording>& plates) {
    const Turn turn = find_turn(file.markers, file.path, file.screen, plates, prepare, warnings);
    fmt::print("{}: {}\n", file.path, describe(turn));
    return turn;
  }

  void require_c3d_part(const C3dFile& file, bool present, const std::string& part) const {
    if (present) return;
    throw InputError({file.path}, {fmt::format("has no {}", part), "", "",
                                   "Choose another part with --what, or another file."});
  }

  // ---- C3D, whole

  void convert_c3d(const std::string& input, const fs::path& output) {
    C3dFile file = read_c3d(input);
    report(warnings, file.warnings);
    const std::string part = what_of(format_of(output));
    const ForcePlatforms platforms = compute_forces(file, {.threshold = prepare.threshold});
    if (part == "forces") report(warnings, platforms.warnings);
    if (part == "markers") {
      require_c3d_part(file, file.markers.marker_count() > 0, "markers");
      Recording recording{input, file.markers, {}};
      const Turn turn = turn_of(file, platforms.recordings);
      if (turn.rotates) rotate_vectors(turn.R_MW, recording.markers->p_WM);
      condition_markers(recording, output);
      if (format_of(output) == Format::kTrc) return write_markers(output, *recording.markers);
      return write_table(output, marker_table(*recording.markers));
    }
    if (part == "forces") return convert_forces(file, platforms.recordings, output);
    write_table(output, part == "analog" ? analog_table(file) : computed_table(file));
  }

  void convert_forces(const C3dFile& file, std::vector<ForcePlatformRecording> plates,
                      const fs::path& output) {
    const Turn turn = turn_of(file, plates);
    for (ForcePlatformRecording& plate : plates) {
      rotate(plate, turn.R_MW);
      sinew::condition(plate, {prepare.force_cutoff, prepare.rate, prepare.threshold});
    }
    const TimeTable table = force_table(plates);
    require_c3d_part(file, !table.labels.empty(), "force platform that can be used");
    write_table(output, cropped(table, file.path));
  }

  // Which foot stands where, and the loads of each foot for inverse dynamics.
  void assign_loads() {
    const bool to_motion = inputs.size() == 1 && format_of(inputs.front()) == Format::kC3d &&
                           format.empty() &&
                           (format_of(out) == Format::kMot || format_of(out) == Format::kSto);
    if (!to_motion || loads.empty()) {
      throw std::invalid_argument(
          "feet are assigned to the platforms of one C3D file: give FILE.c3d --out GRF.mot --loads "
          "GRF.xml");
    }
    const std::vector<AssignmentOverride> overrides = parse_overrides(assign);
    const C3dFile file = read_c3d(inputs.front());
    report(warnings, file.warnings);
    ForcePlatforms platforms = compute_forces(file, {.threshold = prepare.threshold});
    report(warnings, platforms.warnings);
    require_c3d_part(file, !force_table(platforms.recordings).labels.empty(),
                     "force platform that can be used");
    const Turn turn = turn_of(file, platforms.recordings);
    MarkerTrajectories markers = file.markers;
    rotate_vectors(turn.R_MW, markers.p_WM);
    std::optional<MusculoskeletalModel> description;
    if (!model.empty()) description = read_osim(model);
    for (ForcePlatformRecording& plate : platforms.recordings) {
      rotate(plate, turn.R_MW);
      sinew::condition(plate, {prepare.force_cutoff, prepare.rate, prepare.threshold});
    }
    const FootAssignment assignment =
        assign_feet(markers, feet_of(markers, file.path, description ? &*description : nullptr),
                    platforms.recordings, prepare.threshold, overrides);
    for (const PlateContact& contact : assignment.contacts) {
      fmt::print("{}: {}\n", file.path, describe(contact, assignment, platforms.recordings));
    }
    const TimeTable table = cropped(foot_loads(assignment, platforms.recordings), file.path);
    write_ground_reactions(assignment, platforms.recordings, table, out, loads);
    fmt::print("{}, {}, {}\n", out, loads, contacts_path(out).string());
  }

  TimeTable analog_table(const C3dFile& file) {
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

  TimeTable computed_table(const C3dFile& file) {
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

  TimeTable cropped(const TimeTable& table, const std::string& path) {
    const auto [first, end] = frames(table.time, path);
    return slice(table, first, end);
  }

  // C3D to C3D keeps the laboratory's axes unless --up or --forward asks for others.
  void rewrite_c3d(const std::string& input, const fs::path& output) {
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
    C3dFile file = read_c3d(input);
    report(warnings, file.warnings);
    if (!prepare.up.empty() || !prepare.forward.empty()) {
      const Turn turn = turn_of(file, compute_forces(file).recordings);
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

  void filter_analog(C3dFile& file) const {
    TimeTable table;
    table.labels = file.analog.labels;
    table.values = std::move(file.analog.values);
    table.time = Eigen::VectorXd::LinSpaced(
        table.values.rows(), 0.0, static_cast<double>(table.values.rows() - 1) / file.analog.rate);
    lowpass(table, *prepare.analog_cutoff);
    file.analog.values = std::move(table.values);
  }

  // ---- other formats

  void condition(Recording& recording, const fs::path& output) {
    if (!recording.markers) return condition_table(recording);
    if (!prepare.up.empty() || !prepare.forward.empty()) {
      const Turn turn =
          find_turn(*recording.markers, recording.path, std::nullopt, {}, prepare, warnings);
      fmt::print("{}: {}\n", recording.path, describe(turn));
      if (turn.rotates) rotate_vectors(turn.R_MW, recording.markers->p_WM);
    }
    condition_markers(recording, output);
  }

  void fill_and_filter(MarkerTrajectories& markers, const std::string& path,
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

  void condition_markers(Recording& recording, const fs::path& output) {
    MarkerTrajectories& markers = *recording.markers;
    fill_and_filter(markers, recording.path, output);
    const auto [first, end] = frames(markers.time, recording.path);
    markers = slice(markers, first, end);
  }

  void condition_table(Recording& recording) {
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

  // Several inputs into one C3D file: one recording of markers, and tables as analog channels.
  void merge() {
    std::vector<Recording> recordings;
    for (const std::string& input : inputs) {
      if (format_of(input) == Format::kC3d) {
        throw std::invalid_argument("a C3D file cannot be merged with others: " + input);
      }
      recordings.push_back(read_recording(input, warnings));
      if (format_of(input) != Format::kTrc || recordings.size() == 1) continue;
      std::swap(recordings.front(), recordings.back());
    }
    require_markers(recordings.front());
    condition(recordings.front(), out);
    const C3dFile file = merge_to_c3d(recordings, out);
    write_c3d(out, file, {.integers = integers});
    done(out, "markers", file.markers.frame_count(), file.markers.rate);
  }

  void write_markers(const fs::path& output, const MarkerTrajectories& markers) {
    write_trc(output, markers);
    done(output, "markers", markers.frame_count(), markers.rate);
  }

  void write_table(const fs::path& output, const TimeTable& table) {
    if (format_of(output) == Format::kCsv) {
      write_csv(output, table);
    } else {
      write_storage(output, table);
    }
    const Eigen::Index rows = table.time.size();
    fmt::print("{}: {} columns, {} rows from {:.6g} s to {:.6g} s\n", output.string(),
               table.labels.size(), rows, table.time[0], table.time[rows - 1]);
  }
};

}  // namespace

void add_convert_command(CLI::App& app, int& exit_code) {
  auto command = std::make_shared<ConvertCommand>();
  CLI::App* sub = app.add_subcommand(
      "convert",
      "Recordings between C3D, TRC, MOT, STO and CSV; rotated, cropped, filled, filtered");
  sub->add_option("inputs", command->inputs, fmt::format("Recordings ({})", kRecordingFormats))
      ->required();
  sub->add_option("--out", command->out,
                  "File to write; several tables and one recording of markers go into one C3D "
                  "file; with --format a folder");
  sub->add_option("--format", command->format, "Write every input as c3d, trc, mot, sto or csv")
      ->check(CLI::IsMember({"c3d", "trc", "mot", "sto", "csv"}));
  sub->add_option("--what", command->what,
                  "Part of a C3D file: markers (of .trc and .csv unless given), forces (of .mot), "
                  "analog (of .sto), computed")
      ->check(CLI::IsMember({"markers", "forces", "analog", "computed"}));
  sub->add_option("--loads", command->loads,
                  "Assign feet to a C3D file's platforms: --out gets the feet's loads (.mot), this "
                  "file the ExternalLoads (.xml) that `sinew id` and OpenSim read");
  sub->add_option("--assign", command->assign,
                  "Say which foot stands on a platform: PLATE:FOOT or PLATE:FOOT@FROM-TO, FOOT "
                  "right, left or none; may be repeated")
      ->allow_extra_args(false);
  sub->add_option(
      "--model", command->model,
      "Model (.osim) whose foot markers and bodies the loads are for; without, names of "
      "markers tell, and the bodies are calcn_r and calcn_l");
  sub->add_option("--from", command->from, "First time to write [s]")->check(a_time());
  sub->add_option("--to", command->to, "Last time to write [s]")->check(a_time());
  sub->add_flag("--integers", command->integers, "Write C3D numbers as 16-bit integers");
  command->prepare.add_to(*sub);
  sub->callback([command, &exit_code] { exit_code = command->run(); });
}

}  // namespace sinew
