#include "pipeline/prepare_options.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "data/conditioning.h"
#include "data/finding.h"
#include "data/text.h"
#include "model/osim_file.h"
#include "pipeline/command.h"
#include "pipeline/option_checks.h"

namespace sinew {
namespace {

// Markers of each body of the model, as indices into the recording.
std::vector<std::vector<int>> segments(const std::string& model_file,
                                       const MarkerTrajectories& markers) {
  const MusculoskeletalModel model = read_osim(model_file);
  std::map<int, std::vector<int>> by_body;
  for (const Marker& marker : model.markers) {
    const int index = markers.find_marker(marker.name);
    if (index >= 0) by_body[marker.body].push_back(index);
  }
  std::vector<std::vector<int>> result;
  for (const auto& [body, indices] : by_body) result.push_back(indices);
  return result;
}

}  // namespace

CLI::Validator an_axis(bool may_be_kept) {
  const std::string expected =
      std::string("auto, ") + (may_be_kept ? "keep, " : "") + "x, y, z, -x, -y or -z";
  return CLI::Validator(
      [=](std::string& value) {
        const bool word = value == "auto" || (may_be_kept && value == "keep");
        return word || parse_axis(value) ? std::string()
                                         : fmt::format("{} is not {}", value, expected);
      },
      "");
}

void PrepareOptions::add_to(CLI::App& command) {
  edit.add_to(command);
  command
      .add_option("--up", up,
                  "The laboratory's axis that points up: x, y, z, -x, -y, -z, auto to find it, or "
                  "keep to rotate nothing")
      ->check(an_axis(true));
  command
      .add_option("--forward", forward,
                  "The laboratory's axis along which the subject goes, or auto; becomes x")
      ->check(an_axis(false));
  command.add_option("--max-gap", max_gap, "Fill gaps of markers up to this long by a spline [s]")
      ->check(zero_or_more());
  command.add_flag(
      "--fill-rigid", fill_rigid,
      "Fill gaps, of any length, from three or more markers that move with the marker");
  command.add_option("--segments", segments_from,
                     "Model (.osim) whose bodies say which markers move together; without, markers "
                     "that keep their distances do");
  command.add_option("--marker-cutoff", marker_cutoff, "Zero-lag low-pass of markers [Hz]")
      ->check(more_than_zero());
  command
      .add_option("--force-cutoff", force_cutoff,
                  "Zero-lag low-pass of forces and moments, before the centre of pressure [Hz]")
      ->check(more_than_zero());
  command.add_option("--analog-cutoff", analog_cutoff, "Zero-lag low-pass of analog channels [Hz]")
      ->check(more_than_zero());
  command.add_option("--rate", rate, "Resample what is written at this rate [Hz]")
      ->check(more_than_zero());
  command
      .add_option("--threshold", threshold,
                  "Below this force on a platform nothing stands on it [N]")
      ->check(zero_or_more())
      ->capture_default_str();
}

namespace {

// `: A 0.1 s to 0.3 s, B 2 s to 2.2 s and 3 others`, the longest first; of markers that are never
// measured others tell.
std::string list_of(const MarkerTrajectories& markers, std::vector<MarkerGap> gaps) {
  std::erase_if(gaps, [&](const MarkerGap& gap) { return gap.count == markers.frame_count(); });
  std::stable_sort(gaps.begin(), gaps.end(),
                   [](const MarkerGap& a, const MarkerGap& b) { return a.count > b.count; });
  std::vector<std::string> texts;
  for (const MarkerGap& gap : gaps) {
    texts.push_back(fmt::format(
        "{} {} s to {} s", markers.names[static_cast<std::size_t>(gap.marker)],
        time_text(markers.time[gap.first]), time_text(markers.time[gap.first + gap.count - 1])));
  }
  return texts.empty() ? "" : ": " + list_names(texts, 4);
}

}  // namespace

GapFillResult prepare_markers(MarkerTrajectories& markers, const std::string& path,
                              const PrepareOptions& options, std::vector<Warning>& warnings) {
  GapFillResult filled;
  if (options.fills_gaps()) {
    GapFillOptions fill;
    fill.max_gap = options.max_gap.value_or(0.0);
    fill.rigid = options.fill_rigid;
    if (!options.segments_from.empty()) fill.segments = segments(options.segments_from, markers);
    filled = fill_gaps(markers, fill);
    int samples = 0, left = 0;
    for (const FilledGap& gap : filled.filled) samples += gap.gap.count;
    for (const MarkerGap& gap : filled.left) left += gap.count;
    if (!filled.filled.empty() || !filled.left.empty()) {
      report(warnings,
             {{{path},
               fmt::format("{} gaps of {} marker samples were filled; {} gaps of {} stay{}",
                           filled.filled.size(), samples, filled.left.size(), left,
                           list_of(markers, filled.left))}});
    }
  }
  if (options.marker_cutoff) {
    const int untouched = lowpass(markers, *options.marker_cutoff);
    if (untouched > 0) {
      report(warnings, {{{path},
                         fmt::format("{} marker samples lie in stretches of fewer than 6 frames "
                                     "and were not filtered",
                                     untouched)}});
    }
  }
  if (options.rate) {
    if (*options.rate < markers.rate &&
        options.marker_cutoff.value_or(1e300) > 0.5 * *options.rate) {
      report(warnings,
             {{{path},
               fmt::format("markers go from {} Hz to {} Hz without a low-pass below {} "
                           "Hz; --marker-cutoff gives one",
                           text::format_number(markers.rate), text::format_number(*options.rate),
                           text::format_number(0.5 * *options.rate))}});
    }
    markers = resample(markers, *options.rate);
  }
  return filled;
}

}  // namespace sinew
