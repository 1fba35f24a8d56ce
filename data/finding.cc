#include "data/finding.h"

#include <fmt/format.h>

#include <algorithm>

namespace sinew {
namespace {

bool needs_quotes(const std::string& word) {
  return word.empty() || word.find_first_of(" \t\"'$&|;()<>*?[]#~`\\!") != word.npos;
}

}  // namespace

const char* to_string(Finding::Severity severity) {
  switch (severity) {
    case Finding::Severity::kError:
      return "error";
    case Finding::Severity::kWarning:
      return "warning";
    case Finding::Severity::kNote:
      break;
  }
  return "note";
}

const char* confidence_word(double confidence) {
  if (confidence >= 0.95) return "certain";
  if (confidence >= 0.8) return "very likely";
  return confidence >= kLikely ? "likely" : "possible";
}

std::string remedy(const Finding& finding) {
  if (finding.flags.empty()) return "";
  std::string line = "sinew " + finding.command;
  for (const std::string& word : finding.flags) {
    if (!needs_quotes(word)) {
      line += " " + word;
      continue;
    }
    line += " '";
    for (const char c : word) line += c == '\'' ? std::string("'\\''") : std::string(1, c);
    line += "'";
  }
  return line;
}

void set_frames(Finding& finding, const MarkerTrajectories& markers, int first, int last) {
  const auto number = [&](int frame) {
    return markers.frame_numbers[static_cast<std::size_t>(frame)];
  };
  finding.first_frame = number(first);
  finding.last_frame = number(last);
  finding.from = markers.time[first];
  finding.to = markers.time[last];
}

std::string time_text(double seconds) {
  std::string text = fmt::format("{:.4f}", seconds);
  while (text.back() == '0') text.pop_back();
  if (text.back() == '.') text.pop_back();
  return text == "-0" ? "0" : text;
}

std::string list_names(const std::vector<std::string>& names, std::size_t most) {
  std::string text;
  const std::size_t shown = names.size() > most + 1 ? most : names.size();
  for (std::size_t i = 0; i < shown; ++i) {
    const bool last = i + 1 == names.size() && i > 0;
    text += (i == 0 ? "" : last ? " and " : ", ") + names[i];
  }
  if (shown < names.size()) text += fmt::format(" and {} others", names.size() - shown);
  return text;
}

}  // namespace sinew
