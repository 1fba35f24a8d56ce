#include "pipeline/lab_recording.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "data/force_table.h"
#include "data/marker_matching.h"
#include "data/text.h"
#include "data/trc_file.h"
#include "pipeline/command.h"
#include "pipeline/recording.h"

namespace sinew {
namespace {

using Json = nlohmann::ordered_json;

// Markers of a person, of legs only or with the arms up, reach over this much [m].
constexpr double kSmallest = 0.3, kLargest = 3.5;
// What two bodies need to be found.
constexpr int kLeastMarkers = 6;

double metres(const std::string& unit) { return unit == "m" ? 1.0 : unit == "cm" ? 1e-2 : 1e-3; }

std::string name_of_unit(double metres_per_unit) {
  if (metres_per_unit == 1.0) return "m";
  return metres_per_unit == 1e-2 ? "cm" : metres_per_unit == 1e-3 ? "mm" : "";
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
  file.unit = "m";
  file.metres_per_unit = 1.0;
  return file;
}

Decision unit_decision(const std::string& trial, const C3dFile& file) {
  const std::string stored = name_of_unit(file.metres_per_unit);
  Decision decision{trial + "unit", {}, stored, "as the file says", {}, "", "--unit"};
  const double size = size_of_subject(file.markers);
  decision.why += fmt::format(", which makes the subject {:.3g} m large", size);
  if (stored.empty() || std::isnan(size) || (size >= kSmallest && size <= kLargest))
    return decision;
  for (const char* unit : {"mm", "cm", "m"}) {
    const double other = size / file.metres_per_unit * metres(unit);
    if (other < kSmallest || other > kLargest) continue;
    decision.found = unit;
    decision.confidence = 0.9;
    decision.why = fmt::format(
        "the file says {}, which makes the subject {:.3g} m large; {} makes it "
        "{:.3g} m",
        stored, size, unit, other);
  }
  return decision;
}

void settle_unit(const std::string& trial, C3dFile& file, DecisionLog& log) {
  const std::string unit = log.settle_text(unit_decision(trial, file));
  // A unit that has no name here, such as inches, stays as it was understood.
  if (unit.empty() || unit == name_of_unit(file.metres_per_unit)) return;
  const double factor = metres(unit) / file.metres_per_unit;
  file.markers.p_WM *= factor;
  file.computed.values *= factor;
  file.unit = unit;
  file.metres_per_unit = metres(unit);
}

// The sureness of what was found only; what is known has none.
Decision axis_decision(const std::string& name, const AxisDecision& axis, const char* option) {
  Decision decision{name, {}, {}, axis.reason, {}, "", option};
  if (axis.known()) decision.found = axis_name(axis.axis);
  if (axis.confidence > 0.0) decision.confidence = axis.confidence;
  return decision;
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
  const Json forward = log.settle(axis_decision(trial + "forward", turn.axes.forward, "--forward"));
  if (forward.is_string()) options.forward = forward.get<std::string>();
  for (const std::string& axis : {options.up, options.forward}) {
    if (axis.empty() || parse_axis(axis)) continue;
    throw InputError({file.path}, {"is turned by an axis that is none", "x, y, z, -x, -y or -z",
                                   axis, "Correct the decision `up` or `forward`."});
  }
  std::vector<Warning> said_already;
  const bool found = turn.axes.up.known() && options.up == axis_name(turn.axes.up.axis) &&
                     options.forward == axis_name(turn.axes.forward.axis);
  if (found) return turn;
  return find_turn(file.markers, file.path, file.screen, recording.plates, options, said_already);
}

// Entries of the user's map that this recording has, for one map may serve several trials.
MarkerMap entries_of(const MarkerMap& map, const std::vector<std::string>& recorded) {
  MarkerMap result;
  for (const auto& entry : map) {
    const bool there = std::any_of(recorded.begin(), recorded.end(), [&](const std::string& name) {
      return name == entry.first || name.ends_with(":" + entry.first);
    });
    if (there) result.push_back(entry);
  }
  return result;
}

Json to_json(const MarkerMatching& matching, const std::vector<std::string>& recorded,
             const std::vector<std::string>& model) {
  Json map = Json::object();
  for (const MarkerMatch& match : matching.matches) {
    map[recorded[static_cast<std::size_t>(match.recorded)]] =
        model[static_cast<std::size_t>(match.model)];
  }
  return map;
}

// All that is not in the decision is not used.
MarkerMap map_of(const Json& value, const std::vector<std::string>& recorded,
                 const std::string& path) {
  MarkerMap map;
  if (!value.is_object()) {
    throw InputError({path}, {"the value of decision 'markers' is of the wrong kind",
                              "an object of recorded and model names", value.dump(), ""});
  }
  for (const auto& [from, to] : value.items()) {
    if (to.is_string()) map.emplace_back(from, to.get<std::string>());
  }
  for (const std::string& name : recorded) {
    if (!value.contains(name)) map.emplace_back(name, "");
  }
  return map;
}

std::string how_matched(const MarkerMatching& matching) {
  std::string text;
  for (const MatchKind kind :
       {MatchKind::kSaid, MatchKind::kSame, MatchKind::kSpelling, MatchKind::kSite}) {
    if (matching.count(kind) == 0) continue;
    text += fmt::format("{}{} {}", text.empty() ? "" : ", ", matching.count(kind), to_string(kind));
  }
  return text.empty() ? "no name matches" : text;
}

std::vector<std::string> names_of(const std::vector<int>& indices,
                                  const std::vector<std::string>& names) {
  std::vector<std::string> result;
  for (const int i : indices) result.push_back(names[static_cast<std::size_t>(i)]);
  return result;
}

void report_unmatched(const MarkerMatching& matching, const std::vector<std::string>& recorded,
                      const std::vector<std::string>& model, const std::string& path,
                      std::vector<Warning>& warnings) {
  const auto tell = [&](const std::vector<int>& indices, const std::vector<std::string>& names,
                        const char* what) {
    std::string list;
    for (const std::string& name : names_of(indices, names)) {
      list += (list.empty() ? "" : ", ") + name;
    }
    if (!indices.empty()) {
      report(warnings, {{{path}, fmt::format("{} {}: {}", indices.size(), what, list)}});
    }
  };
  tell(matching.unused, recorded, "recorded markers are not the model's and are not tracked");
  tell(matching.missing, model, "markers of the model are not recorded");
}

}  // namespace

LabTrial read_lab_recording(const std::string& path, const std::string& trial, const LabOptions&,
                            double threshold, DecisionLog& log, std::vector<Warning>& warnings) {
  LabTrial recording;
  recording.file = read_trial(path, warnings);
  require_c3d_part(recording.file, recording.file.markers.marker_count() > 0, "markers");
  settle_unit(trial, recording.file, log);
  ForcePlatforms platforms = compute_forces(recording.file, {.threshold = threshold});
  report(warnings, platforms.warnings);
  recording.plates = std::move(platforms.recordings);
  recording.turn = settle_turn(trial, recording, log, warnings);
  rotate_vectors(recording.turn.R_MW, recording.file.markers.p_WM);
  for (ForcePlatformRecording& plate : recording.plates) rotate(plate, recording.turn.R_MW);
  return recording;
}

MarkerTrajectories name_lab_markers(const LabTrial& recording, const std::string& trial,
                                    const std::vector<std::string>& model_names,
                                    const LabOptions& options, DecisionLog& log,
                                    std::vector<Warning>& warnings) {
  const std::string& path = recording.file.path;
  const std::vector<std::string>& recorded = recording.file.markers.names;
  MatchingOptions matching_options;
  MarkerMatching found = match_markers(recorded, model_names, matching_options, path);
  if (!found.subjects.empty()) {
    matching_options.subject =
        log.settle_text({trial + "subject",
                         {},
                         found.subject,
                         fmt::format("of {} subject{}, the one with most of the model's markers",
                                     found.subjects.size(), found.subjects.size() == 1 ? "" : "s"),
                         {},
                         "",
                         "--subject"});
    found = match_markers(recorded, model_names, matching_options, path);
  }
  if (!options.map.empty()) {
    matching_options.map = entries_of(read_marker_map(options.map), recorded);
    const MarkerMatching said = match_markers(recorded, model_names, matching_options, path);
    log.say(trial + "markers", to_json(said, recorded, model_names),
            options.given_now.contains("--map"));
  }
  const Json value = log.settle({trial + "markers",
                                 {},
                                 to_json(found, recorded, model_names),
                                 how_matched(found),
                                 {},
                                 "",
                                 "--map"});
  matching_options.map = map_of(value, recorded, path);
  const MarkerMatching matching = match_markers(recorded, model_names, matching_options, path);
  require_matches(matching, std::min(kLeastMarkers, static_cast<int>(model_names.size())), recorded,
                  model_names, path);
  report_unmatched(matching, recorded, model_names, path, warnings);
  return rename_markers(recording.file.markers, matching, model_names);
}

}  // namespace sinew
