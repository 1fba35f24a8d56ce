#include "pipeline/lab_names.h"

#include <fmt/format.h>

#include <algorithm>

#include "data/finding.h"
#include "data/marker_matching.h"
#include "pipeline/command.h"

namespace sinew {
namespace {

using Json = nlohmann::ordered_json;

// What two bodies need to be found.
constexpr int kLeastMarkers = 6;
constexpr std::size_t kNamesShown = 12;

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
    if (indices.empty()) return;
    report(warnings, {{{path},
                       fmt::format("{} {}: {}", indices.size(), what,
                                   list_names(names_of(indices, names), kNamesShown))}});
  };
  tell(matching.unused, recorded, "recorded markers have no name that the model knows");
  tell(matching.missing, model, "markers of the model are not recorded");
}

}  // namespace

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
  // One option serves both trials, of which the static one may have a single, unnamed subject.
  if (found.subjects.empty() && !options.subject.empty() && trial.empty()) {
    throw InputError({path}, {fmt::format("has no subject '{}'", options.subject),
                              "names of markers that begin with their subject's and a colon",
                              recorded.empty() ? "" : recorded.front(), "Leave --subject out."});
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
