#include "pipeline/lab_recording.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "data/c3d_labels.h"
#include "data/force_table.h"
#include "data/statistics.h"
#include "data/text.h"
#include "data/trc_description.h"
#include "data/trc_file.h"
#include "pipeline/command.h"
#include "pipeline/edit_options.h"
#include "pipeline/recording.h"
#include "pipeline/spikes.h"

namespace sinew {
namespace {

using Json = nlohmann::ordered_json;

// Markers of a person, of legs only or with the arms up, reach over this much [m].
constexpr double kSmallest = 0.3, kLargest = 3.5;
// Between legs of 1 m and somebody with the arms up: of several units the one that comes nearest.
constexpr double kUsual = 1.4;

constexpr const char* kUnits[] = {"mm", "cm", "m", "in", "ft"};

std::string name_of_unit(double metres_per_unit) {
  for (const char* unit : kUnits) {
    if (c3d::metres_per(unit) == metres_per_unit) return unit;
  }
  return "";
}

// The longest side of the box around all markers of a frame, in the middle over the frames.
double size_of_subject(const MarkerTrajectories& markers) {
  std::vector<double> sizes;
  for (int f = 0; f < markers.frame_count(); ++f) {
    Eigen::Vector3d low = Eigen::Vector3d::Constant(INFINITY), high = -low;
    for (int m = 0; m < markers.marker_count(); ++m) {
      const Eigen::Vector3d p = markers.position(f, m);
      if (!p.allFinite()) continue;
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
    if (high.allFinite()) sizes.push_back((high - low).maxCoeff());
  }
  if (sizes.empty()) return std::nan("");
  std::nth_element(sizes.begin(), sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() / 2),
                   sizes.end());
  return sizes[sizes.size() / 2];
}

C3dFile read_trial(const std::string& path, std::vector<Warning>& warnings) {
  const Format format = format_of(path);
  if (format == Format::kC3d) {
    C3dFile file = read_c3d(path);
    report(warnings, file.warnings);
    return file;
  }
  if (format != Format::kTrc) {
    throw InputError({path}, {"is no recording of markers", "a .c3d or .trc file",
                              path.substr(path.rfind('.')), "Convert it with `sinew convert`."});
  }
  MarkerFile read = read_trc(path);
  report(warnings, read.warnings);
  C3dFile file;
  file.path = path;
  file.markers = std::move(read.markers);
  file.metres_per_unit = read_trc_description(path).metres_per_unit;
  file.unit = name_of_unit(file.metres_per_unit);
  return file;
}

Decision unit_decision(const std::string& trial, const C3dFile& file) {
  const std::string stored = name_of_unit(file.metres_per_unit);
  Decision decision{trial + "unit", {}, stored, "as the file says", {}, "", "--unit"};
  const double size = size_of_subject(file.markers);
  decision.why += fmt::format(", which makes the subject {:.3g} m large", size);
  if (stored.empty() || std::isnan(size) || (size >= kSmallest && size <= kLargest))
    return decision;
  double nearest = INFINITY;
  for (const char* unit : kUnits) {
    const double other = size / file.metres_per_unit * *c3d::metres_per(unit);
    if (other < kSmallest || other > kLargest) continue;
    const double off = std::abs(std::log(other / kUsual));
    if (off >= nearest) continue;
    nearest = off;
    decision.found = unit;
    decision.confidence = 0.9;
    decision.why = fmt::format(
        "the file says {}, which makes the subject {:.3g} m large; {} makes it "
        "{:.3g} m",
        stored, size, unit, other);
  }
  return decision;
}

// Middle distances of the markers that both recordings have, of the first to the second: the middle
// of their ratios, or NaN where too few are common.
double ratio_of_distances(const MarkerTrajectories& a, const MarkerTrajectories& b) {
  constexpr int kLeastCommon = 5, kFrames = 50;
  std::vector<std::pair<int, int>> common;
  for (int m = 0; m < a.marker_count(); ++m) {
    const int other = b.find_marker(a.names[static_cast<std::size_t>(m)]);
    if (other >= 0) common.emplace_back(m, other);
  }
  if (common.size() < kLeastCommon) return std::nan("");
  const auto distance = [&](const MarkerTrajectories& markers, int x, int y) {
    std::vector<double> all;
    const int step = std::max(1, markers.frame_count() / kFrames);
    for (int f = 0; f < markers.frame_count(); f += step) {
      const double d = (markers.position(f, x) - markers.position(f, y)).norm();
      if (std::isfinite(d)) all.push_back(d);
    }
    return all.empty() ? std::nan("") : median(std::move(all));
  };
  std::vector<double> ratios;
  for (std::size_t i = 0; i < common.size(); ++i) {
    for (std::size_t k = i + 1; k < common.size(); ++k) {
      const double ratio = distance(a, common[i].first, common[k].first) /
                           distance(b, common[i].second, common[k].second);
      if (std::isfinite(ratio)) ratios.push_back(ratio);
    }
  }
  return ratios.empty() ? std::nan("") : median(std::move(ratios));
}

// Of a static trial, by the walk of the same subject: poses change the middle distance by a fifth,
// units by a factor of 2.5 or more.
Decision unit_by_walk(Decision decision, const C3dFile& file, const MarkerTrajectories& walk) {
  constexpr double kSame = 1.4;
  const double ratio = ratio_of_distances(file.markers, walk);
  if (!(ratio > 0.0) || std::abs(std::log(ratio)) < std::log(kSame)) return decision;
  for (const char* unit : kUnits) {
    const double other = ratio / file.metres_per_unit * *c3d::metres_per(unit);
    if (std::abs(std::log(other)) > std::log(kSame)) continue;
    decision.found = unit;
    decision.confidence = 0.95;
    decision.why = fmt::format(
        "the file says {}, which makes its distances {:.3g} times those of the walk; {} makes "
        "them {:.3g} times",
        name_of_unit(file.metres_per_unit), ratio, unit, other);
    return decision;
  }
  decision.found = nullptr;
  decision.why = fmt::format("its distances are {:.3g} times those of the walk", ratio);
  return decision;
}

void require_a_size(const C3dFile& file) {
  constexpr double kLeast = 1e-3;  // of what it is in any unit, a person is larger
  const double size = size_of_subject(file.markers) / file.metres_per_unit;
  if (!(size < kLeast)) return;
  throw InputError({file.path}, {"is no recording of a person: all markers are in one place",
                                 "markers at different places", fmt::format("{:.3g} apart", size),
                                 "Choose another file, or record the trial again."});
}

// What the options or an edited decisions.json put right; of the static trial only its unit.
RecordingEdits settle_edits(const std::string& trial, const C3dFile& file,
                            const MarkerTrajectories* walk, DecisionLog& log) {
  EditOptions said;
  Decision by_size = unit_decision(trial, file);
  if (walk != nullptr) by_size = unit_by_walk(std::move(by_size), file, *walk);
  const std::string option = by_size.option;
  if (by_size.found.is_null() && !log.said(by_size.name)) {
    throw InputError({file.path},
                     {"is of no unit that the walk would be of: " + by_size.why,
                      "a trial of the same subject, in mm, cm, m, in or ft", "",
                      "Give the static trial of this subject, or its unit with " + option + "."});
  }
  const std::string unit = log.settle_text(std::move(by_size));
  // A unit that has no name here stays as it was understood.
  if (!unit.empty() && unit != name_of_unit(file.metres_per_unit)) said.unit = unit;
  if (!trial.empty()) return said.edits();
  const auto decision = [](const char* name, const char* option) {
    return Decision{name, {}, {}, "", {}, "", option};
  };
  const auto settle_list = [&](const char* name, const char* option, auto& list) {
    if (log.said(name)) list = log.settle_texts(decision(name, option));
  };
  settle_list("swap", "--swap", said.swaps);
  settle_list("drop", "--drop", said.drops);
  if (log.said("swap sides")) {
    said.swap_sides = log.settle_flag(decision("swap sides", "--swap-sides"));
  }
  settle_list("rename", "--rename", said.renames);
  settle_list("drop samples", "--drop-samples", said.samples);
  settle_list("zero plates", "--zero-plates", said.unloaded);
  if (log.said("shift forces")) {
    said.shift_forces = log.settle_number(decision("shift forces", "--shift-forces"));
  }
  return said.edits();
}

// The sureness of what was found only; what is known has none.
Decision axis_decision(const std::string& name, const AxisDecision& axis, const char* option) {
  Decision decision{name, {}, {}, axis.reason, {}, "", option};
  if (axis.known()) decision.found = axis_name(axis.axis);
  if (axis.confidence > 0.0) decision.confidence = axis.confidence;
  return decision;
}

// Of a decision that somebody edited.
void require_axis(const std::string& axis, const std::string& path) {
  if (axis.empty() || parse_axis(axis)) return;
  throw InputError({path}, {"is turned by an axis that is none", "x, y, z, -x, -y or -z", axis,
                            "Correct the decision `up` or `forward`."});
}

Turn settle_turn(const std::string& trial, const LabTrial& recording, DecisionLog& log,
                 std::vector<Warning>& warnings) {
  const C3dFile& file = recording.file;
  PrepareOptions options;
  Turn turn;
  try {
    turn = find_turn(file.markers, file.path, file.screen, recording.plates, options, warnings);
  } catch (const InputError&) {
    if (!log.said(trial + "up")) throw;
  }
  options.up = log.settle_text(axis_decision(trial + "up", turn.axes.up, "--up"));
  if (options.up == "keep") return {};
  require_axis(options.up, file.path);
  std::vector<Warning> said_already;
  if (!turn.axes.up.known() || options.up != axis_name(turn.axes.up.axis)) {
    turn = find_turn(file.markers, file.path, file.screen, recording.plates, options, said_already);
  }
  const Json forward = log.settle(axis_decision(trial + "forward", turn.axes.forward, "--forward"));
  if (forward.is_string()) options.forward = forward.get<std::string>();
  require_axis(options.forward, file.path);
  const bool found = turn.axes.up.known() && options.up == axis_name(turn.axes.up.axis) &&
                     options.forward == axis_name(turn.axes.forward.axis);
  if (found) return turn;
  return find_turn(file.markers, file.path, file.screen, recording.plates, options, said_already);
}

}  // namespace

LabTrial read_lab_recording(const std::string& path, const std::string& trial, double threshold,
                            const MarkerTrajectories* walk, DecisionLog& log,
                            std::vector<Warning>& warnings) {
  LabTrial recording;
  recording.file = read_trial(path, warnings);
  require_c3d_part(recording.file, recording.file.markers.marker_count() > 0, "markers");
  require_a_size(recording.file);
  recording.edits = settle_edits(trial, recording.file, walk, log);
  // Before baselines are taken of the channels.
  for (SampleDrop& spike : settle_force_spikes(trial, recording.file, log)) {
    recording.edits.samples.push_back(std::move(spike));
  }
  edit_recording(recording.file, recording.edits);
  RecordingEdits spikes;
  spikes.spikes = settle_spikes(trial, recording.file.markers, log);
  edit_recording(recording.file, spikes);
  recording.edits.spikes = spikes.spikes;
  ForcePlatforms platforms = compute_forces(recording.file, {.threshold = threshold});
  report(warnings, platforms.warnings);
  recording.plates = std::move(platforms.recordings);
  recording.turn = settle_turn(trial, recording, log, warnings);
  rotate_vectors(recording.turn.R_MW, recording.file.markers.p_WM);
  for (ForcePlatformRecording& plate : recording.plates) rotate(plate, recording.turn.R_MW);
  return recording;
}

}  // namespace sinew
