#pragma once

#include <optional>
#include <string>
#include <vector>

#include "data/marker_trajectories.h"
#include "data/numbers.h"

namespace sinew {

/// Something about a recording that would spoil what is computed from it, found before anything is.
struct Finding {
  enum class Severity {
    kError,    // results with this are wrong or cannot be had
    kWarning,  // probably a mistake
    kNote,     // worth knowing; often right
  };

  Severity severity = Severity::kWarning;
  std::string kind;   // a word for the check, such as `unit`
  std::string text;   // what it is, with figures; a sentence without its full stop
  std::string file;   // detectors leave it empty
  std::string where;  // marker, channel or platform; empty: the whole file
  std::optional<int> first_frame, last_frame;  // as the file numbers them
  double from = kNaN,                          // [s]; NaN: the whole record
      to = kNaN;
  double confidence = 0.0;          // 0 to 1
  std::string command = "convert";  // of sinew, whose options mend it
  // These options; none mends it where empty. Of other commands than convert they name the files.
  std::vector<std::string> flags;
  std::string output;  // what they write; `mended` with the file's ending where empty
  std::string advice;  // what else to do, or why no option mends it

  bool operator==(const Finding&) const = default;
};

const char* to_string(Finding::Severity severity);

/// From this confidence on a finding is worth saying where nobody asked.
inline constexpr double kLikely = 0.6;

/// `certain` from 0.95 on, `very likely` from 0.8, `likely` from kLikely, else `possible`.
const char* confidence_word(double confidence);

/// `sinew convert … --unit mm`, quoted for a shell; empty where no option mends it.
std::string remedy(const Finding& finding);

/// Frames `first` … `last` of the recording as the finding's place in time.
void set_frames(Finding& finding, const MarkerTrajectories& markers, int first, int last);

/// A time as options take it: four decimals, which tell frames up to 5 kHz apart.
std::string time_text(double seconds);

/// `A, B, C and 4 others`.
std::string list_names(const std::vector<std::string>& names, std::size_t most = 6);

}  // namespace sinew
