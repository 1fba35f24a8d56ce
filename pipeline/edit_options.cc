#include "pipeline/edit_options.h"

#include <fmt/format.h>

#include <stdexcept>

#include "pipeline/option_checks.h"

namespace sinew {
namespace {

template <typename Parse>
auto parse_all(const std::vector<std::string>& texts, const char* option, const char* form,
               const Parse& parse) {
  std::vector<typename decltype(parse(std::string()))::value_type> result;
  for (const std::string& text : texts) {
    auto parsed = parse(text);
    if (!parsed) throw std::invalid_argument(fmt::format("{}: {} is not {}", option, text, form));
    result.push_back(std::move(*parsed));
  }
  return result;
}

}  // namespace

void EditOptions::add_to(CLI::App& command) {
  command
      .add_option("--unit", unit, "What lengths are in, whatever the file says: mm, cm, m, in, ft")
      ->check(CLI::IsMember({"mm", "cm", "m", "in", "ft"}));
  const auto repeated = [&](const char* name, std::vector<std::string>& values, const char* help) {
    command.add_option(name, values, help)->allow_extra_args(false);
  };
  repeated("--swap", swaps,
           "Exchange the names of two markers, A,B or A,B@FROM-TO [s]; may be repeated");
  repeated("--drop", drops, "Leave a marker out, NAME or NAME@FROM-TO [s]; may be repeated");
  command.add_flag("--swap-sides", swap_sides,
                   "Exchange the names of all left markers with those of their right partners");
  repeated("--rename", renames, "Call a marker otherwise, OLD=NEW; may be repeated");
  repeated(
      "--zero-plates", unloaded,
      "Take forces between these times as zero, FROM-TO or PLATE@FROM-TO [s]; given twice, the "
      "baseline goes straight from one to the other");
  repeated("--drop-samples", samples,
           "Leave samples of a channel or column out, NAME@FROM-TO [s], and go straight from the "
           "one before to the one behind; may be repeated");
  command
      .add_option("--shift-forces", shift_forces,
                  "Move forces and all channels to later times by this; negative for earlier [s]")
      ->check(a_time());
}

RecordingEdits EditOptions::edits() const {
  RecordingEdits edits;
  edits.unit = unit;
  edits.swap_sides = swap_sides;
  edits.shift_forces = shift_forces;
  edits.swaps = parse_all(swaps, "--swap", "A,B or A,B@FROM-TO with FROM before TO", parse_swap);
  edits.drops = parse_all(drops, "--drop", "NAME or NAME@FROM-TO with FROM before TO", parse_drop);
  edits.renames = parse_all(renames, "--rename", "OLD=NEW", parse_rename);
  edits.samples = parse_all(samples, "--drop-samples",
                            "NAME@FROM-TO, in seconds, with FROM before TO", parse_sample_drop);
  edits.unloaded =
      parse_all(unloaded, "--zero-plates", "FROM-TO or PLATE@FROM-TO, in seconds", parse_unloaded);
  return edits;
}

void apply(const RecordingEdits& edits, Recording& recording) {
  const auto refuse = [&](const char* options, const char* of) {
    throw std::invalid_argument(fmt::format(
        "{} {} not apply to {}, which holds {}", options,
        std::string(options).find(' ') == std::string::npos ? "does" : "do", recording.path, of));
  };
  if (!edits.unloaded.empty()) refuse("--zero-plates", "no channels of force platforms");
  if (recording.markers) {
    if (edits.shift_forces != 0.0) refuse("--shift-forces", "markers");
    if (!edits.samples.empty()) refuse("--drop-samples", "markers");
    return edit_markers(*recording.markers, recording.metres_per_unit, edits);
  }
  if (edits.edits_markers()) {
    refuse("--unit, --swap, --drop, --swap-sides and --rename", "a table");
  }
  drop_samples(*recording.table, edits.samples);
  recording.table->time.array() += edits.shift_forces;
}

}  // namespace sinew
