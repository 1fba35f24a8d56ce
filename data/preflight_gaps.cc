#include "data/preflight_gaps.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

namespace sinew {
namespace {

using Severity = Finding::Severity;

const std::string& name_of(const MarkerTrajectories& markers, int marker) {
  return markers.names[static_cast<std::size_t>(marker)];
}

struct GapClass {
  double longest;
  Severity severity;
  double confidence;
  std::vector<std::string> flags;
  const char* what;
  const char* advice;
};

Finding describe_gaps(const MarkerTrajectories& markers, const std::vector<MarkerGap>& gaps,
                      const GapClass& of) {
  std::map<int, int> by_marker;
  for (const MarkerGap& gap : gaps) ++by_marker[gap.marker];
  std::vector<std::string> names;
  // Gaps come longest first, and so do the names.
  for (const MarkerGap& gap : gaps) {
    const std::string& name = name_of(markers, gap.marker);
    if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
  }
  const MarkerGap& longest = gaps.front();
  Finding finding;
  finding.severity = of.severity;
  finding.kind = "gap";
  finding.where = list_names(names);
  finding.confidence = of.confidence;
  set_frames(finding, markers, longest.first, longest.first + longest.count - 1);
  finding.text =
      fmt::format("{} gap{} {}; the longest, of {} frames ({} s), is in {}", gaps.size(),
                  gaps.size() == 1 ? "" : "s", of.what, longest.count,
                  time_text(longest.count / markers.rate), name_of(markers, longest.marker));
  finding.flags = of.flags;
  finding.advice = of.advice;
  return finding;
}

}  // namespace

std::vector<MarkerGap> find_inner_gaps(const MarkerTrajectories& markers) {
  std::vector<MarkerGap> gaps = find_gaps(markers);
  std::erase_if(gaps, [&](const MarkerGap& gap) {
    return gap.first == 0 || gap.first + gap.count == markers.frame_count();
  });
  std::stable_sort(gaps.begin(), gaps.end(),
                   [](const MarkerGap& a, const MarkerGap& b) { return a.count > b.count; });
  return gaps;
}

std::vector<Finding> find_gap_faults(const MarkerTrajectories& markers,
                                     const MarkerCheckOptions& options) {
  options.validate();
  // A thousandth of a step on top, so that lengths that are whole frames are within.
  const double step = 1.0 / markers.rate;
  const std::string by_spline = time_text(options.short_gap);
  const GapClass classes[] = {
      {std::numeric_limits<double>::infinity(),
       Severity::kWarning,
       0.9,
       {"--fill-rigid"},
       "longer than half a second",
       "fills it where three markers of the same segment are seen; else weigh the marker 0"},
      {options.long_gap, Severity::kNote, 0.9, {"--fill-rigid"}, "of medium length", ""},
      {options.short_gap,
       Severity::kNote,
       0.95,
       {"--max-gap", by_spline},
       "short enough for a spline",
       ""}};
  std::vector<Finding> findings;
  const std::vector<MarkerGap> gaps = find_inner_gaps(markers);
  for (std::size_t k = 0; k < std::size(classes); ++k) {
    const double shortest = k + 1 < std::size(classes) ? classes[k + 1].longest : 0.0;
    std::vector<MarkerGap> within;
    for (const MarkerGap& gap : gaps) {
      const double length = gap.count * step;
      if (length <= classes[k].longest + 1e-3 * step && length > shortest + 1e-3 * step) {
        within.push_back(gap);
      }
    }
    if (!within.empty()) findings.push_back(describe_gaps(markers, within, classes[k]));
  }
  return findings;
}

}  // namespace sinew
