#include "pipeline/check_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

namespace sinew {
namespace {

std::string time_of(const Finding& finding) {
  if (std::isnan(finding.from)) return "";
  std::string text =
      finding.from == finding.to
          ? time_text(finding.from) + " s"
          : fmt::format("{} s to {} s", time_text(finding.from), time_text(finding.to));
  if (!finding.first_frame) return text;
  return text +
         (*finding.first_frame == *finding.last_frame
              ? fmt::format(" (frame {})", *finding.first_frame)
              : fmt::format(" (frames {} to {})", *finding.first_frame, *finding.last_frame));
}

}  // namespace

FindingCounts count(const std::vector<Finding>& findings) {
  FindingCounts counts;
  for (const Finding& finding : findings) {
    switch (finding.severity) {
      case Finding::Severity::kError:
        ++counts.errors;
        break;
      case Finding::Severity::kWarning:
        ++counts.warnings;
        break;
      case Finding::Severity::kNote:
        ++counts.notes;
        break;
    }
  }
  return counts;
}

std::string remedy_command(const Finding& finding) {
  if (finding.flags.empty()) return "";
  if (finding.command != "convert") return remedy(finding);
  Finding named = finding;
  named.flags.insert(named.flags.begin(), finding.file);
  const std::string ending = std::filesystem::path(finding.file).extension().string();
  named.flags.insert(named.flags.end(),
                     {"--out", finding.output.empty() ? "mended" + ending : finding.output});
  return remedy(named);
}

std::string findings_text(const std::vector<Finding>& findings, const std::string& path) {
  std::string text;
  for (const Finding& finding : findings) {
    if (finding.file != path) continue;
    text += fmt::format("  {:<8} {:<11} ", to_string(finding.severity), finding.kind);
    const std::string when = time_of(finding);
    std::string place = finding.where;
    if (!when.empty()) place += (place.empty() ? "" : ", ") + when;
    if (!place.empty()) text += place + ": ";
    text += fmt::format("{} [{}, {:.0f} %]\n", finding.text, confidence_word(finding.confidence),
                        100.0 * finding.confidence);
    constexpr const char* kIndent = "                       ";
    if (const std::string command = remedy_command(finding); !command.empty()) {
      text += kIndent + command + "\n";
    }
    if (!finding.advice.empty()) text += kIndent + finding.advice + "\n";
  }
  return text;
}

nlohmann::ordered_json findings_json(const std::vector<Finding>& findings) {
  nlohmann::ordered_json all = nlohmann::ordered_json::array();
  for (const Finding& finding : findings) {
    nlohmann::ordered_json one;
    one["severity"] = to_string(finding.severity);
    one["kind"] = finding.kind;
    one["file"] = finding.file;
    if (!finding.where.empty()) one["where"] = finding.where;
    if (!std::isnan(finding.from)) {
      one["from"] = finding.from;
      one["to"] = finding.to;
    }
    if (finding.first_frame) {
      one["first_frame"] = *finding.first_frame;
      one["last_frame"] = *finding.last_frame;
    }
    one["text"] = finding.text;
    one["confidence"] = finding.confidence;
    one["sure"] = confidence_word(finding.confidence);
    if (!finding.flags.empty()) {
      one["command"] = finding.command;
      one["flags"] = finding.flags;
      one["remedy"] = remedy_command(finding);
    }
    if (!finding.advice.empty()) one["advice"] = finding.advice;
    all.push_back(std::move(one));
  }
  return all;
}

}  // namespace sinew
