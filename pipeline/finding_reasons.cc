#include "pipeline/finding_reasons.h"

#include <fmt/format.h>

#include <cmath>

#include "data/preflight_order.h"
#include "data/preflight_sides.h"
#include "data/preflight_swaps.h"
#include "pipeline/check_report.h"

namespace sinew {
namespace {

// Two that jump at once, each to where the other was about to be, are hardly ever anything else.
constexpr double kCertain = 0.95, kCertainOfJumps = 0.8;

VerdictReason make(const Finding& finding, double share, const std::string& static_trial) {
  VerdictReason reason;
  reason.code = "exchanged-markers";
  // Sizes are fitted to these samples too, so that a few spoil every frame.
  reason.weight = VerdictReason::Weight::kUnusable;
  std::string place = finding.where;
  if (!static_trial.empty() && finding.file == static_trial) {
    place += place.empty() ? "in the static trial" : " in the static trial";
  }
  if (std::isfinite(finding.from)) {
    place += fmt::format(", {} s to {} s", time_text(finding.from), time_text(finding.to));
  }
  reason.text = fmt::format("{}{}{}", place, place.empty() ? "" : ": ", finding.text);
  reason.figure = 100.0 * share;
  reason.limit = 0.0;
  reason.unit = "% of the record";
  reason.source = "Sinew";
  reason.remedy = run_remedy(finding, static_trial);
  return reason;
}

VerdictReason of_forces(const Finding& finding, const std::string& static_trial) {
  VerdictReason reason;
  reason.code = "forces-" + finding.kind;
  reason.text = fmt::format("{} ({})", finding.text, confidence_word(finding.confidence));
  reason.figure = 100.0 * finding.confidence;
  reason.unit = "% sure";
  reason.source = "Sinew";
  reason.remedy = run_remedy(finding, static_trial);
  return reason;
}

}  // namespace

std::string run_remedy(const Finding& finding, const std::string& static_trial) {
  if (finding.flags.empty()) return finding.advice;
  if (!static_trial.empty() && finding.file == static_trial) return remedy_command(finding);
  if (finding.command != "convert") return remedy(finding);
  const std::string command = remedy(finding), before = "sinew " + finding.command + " ";
  return command.substr(before.size());
}

std::vector<VerdictReason> finding_reasons(const std::vector<Finding>& findings, double begin,
                                           double end, const std::string& static_trial) {
  std::vector<VerdictReason> reasons;
  for (const Finding& finding : findings) {
    if (finding.kind == "clock" || finding.kind == "place") {
      if (finding.confidence >= kLikely) reasons.push_back(of_forces(finding, static_trial));
      continue;
    }
    if (finding.kind != "swap" && finding.kind != "side") continue;
    const double certain = finding.kind == "swap" ? kCertainOfJumps : kCertain;
    if (finding.severity != Finding::Severity::kError || finding.confidence < certain) continue;
    // A static trial is one pose: what is exchanged in a part of it spoils its mean.
    const bool whole =
        !std::isfinite(finding.from) || (!static_trial.empty() && finding.file == static_trial);
    const double share = whole ? 1.0 : (finding.to - finding.from) / (end - begin);
    reasons.push_back(make(finding, share, static_trial));
  }
  return reasons;
}

std::vector<VerdictReason> exchange_reasons(const MarkerFile& file) {
  const MarkerTrajectories& markers = file.markers;
  AxisEvidence evidence;
  evidence.markers = &markers;
  const LaboratoryAxes axes = find_axes(evidence);
  std::vector<Finding> findings = find_swap_faults(markers, axes);
  for (const std::vector<Finding>& more :
       {find_side_faults(markers, axes), find_order_faults(markers, axes)}) {
    findings.insert(findings.end(), more.begin(), more.end());
  }
  std::vector<VerdictReason> reasons;
  for (Finding& finding : findings) {
    finding.file = file.path;
    for (VerdictReason& reason :
         finding_reasons({finding}, markers.time[0], markers.time[markers.time.size() - 1], "")) {
      if (!finding.flags.empty()) reason.remedy = remedy_command(finding);
      reasons.push_back(std::move(reason));
    }
  }
  return reasons;
}

}  // namespace sinew
