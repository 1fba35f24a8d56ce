#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "data/marker_trajectories.h"

namespace sinew {

/// A recorded name and the model's; an empty model name: the marker is not used.
using MarkerMap = std::vector<std::pair<std::string, std::string>>;

/// Reads `recorded,model` rows of CSV with these two labels; `#` begins a comment. Throws
/// InputError naming the line for other labels, rows without two cells, an empty recorded name and
/// a name that stands twice on its side.
MarkerMap read_marker_map(const std::filesystem::path& path);
std::string marker_map_csv(const MarkerMap& map);

/// How a recorded marker and one of a model came together, from the surest.
enum class MatchKind { kSaid, kSame, kSpelling, kSite };
const char* to_string(MatchKind kind);

struct MarkerMatch {
  int recorded = 0, model = 0;  // indices
  MatchKind kind = MatchKind::kSame;
  bool operator==(const MarkerMatch&) const = default;
};

/// What of a recording is what of a model.
struct MarkerMatching {
  std::string subject;                // whose markers are taken; empty where names have no subjects
  std::vector<std::string> subjects;  // all, in order of appearance
  std::vector<MarkerMatch> matches;   // by recorded marker
  std::vector<int> unused;            // recorded ones of the subject that the model lacks
  std::vector<int> missing;           // the model's that the recording lacks

  int count(MatchKind kind) const;
};

struct MatchingOptions {
  MarkerMap map;        // what the user said; names that are not recorded or not the model's throw
  std::string subject;  // before the colon of `Subject:LASI`; empty: the one with most matches
};

/// Finds for recorded markers their names in a model: as `map` says; the same name without subject;
/// the same but for case and separators; the same site of the body by marker_site(). Surer matches
/// go first, and each marker is taken once. `path` is the recording's, for messages. Throws
/// InputError for a subject or a mapped name that does not exist, with what there is.
/// O(recorded · model).
MarkerMatching match_markers(const std::vector<std::string>& recorded,
                             const std::vector<std::string>& model, const MatchingOptions& options,
                             const std::string& path);

/// Throws InputError unless `least` markers matched: it lists the recorded names and for each that
/// is not used the model's nearest.
void require_matches(const MarkerMatching& matching, int least,
                     const std::vector<std::string>& recorded,
                     const std::vector<std::string>& model, const std::string& path);

/// The recording with the model's names; unused markers of the subject keep theirs without subject,
/// those of other subjects are left out.
MarkerTrajectories rename_markers(const MarkerTrajectories& markers, const MarkerMatching& matching,
                                  const std::vector<std::string>& model);

/// The name among `names` with the least edits (Levenshtein 1966) without case and separators;
/// empty where even that differs in more than half of its letters.
std::string nearest_name(const std::string& name, const std::vector<std::string>& names);

}  // namespace sinew
