#include "pipeline/gap_reasons.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "data/finding.h"

namespace sinew {
namespace {

constexpr double kMostFilledMarker = 0.25, kMostUndetermined = 0.25;
constexpr double kFewest = 0.1;  // [s]

struct Missing {
  std::string name;
  double share = 0.0;  // of the frames, not measured
  int measured = 0;
};

std::vector<Missing> missing_of(const TrackingProblem& tracking, const MarkerTrajectories& markers,
                                int first, int end) {
  std::vector<Missing> result;
  for (std::size_t i = 0; i < tracking.markers.size(); ++i) {
    Missing missing{tracking.markers[i].name, 0.0, 0};
    for (int f = first; f < end; ++f) {
      const bool filled =
          tracking.filled.size() > 0 && tracking.filled(f, static_cast<Eigen::Index>(i));
      const bool absent = std::isnan(markers.p_WM(f, 3 * tracking.markers[i].recorded));
      missing.measured += !filled && !absent;
    }
    missing.share = 1.0 - double(missing.measured) / (end - first);
    result.push_back(missing);
  }
  return result;
}

VerdictReason of(const char* code, std::string text, double figure, double limit,
                 const char* remedy) {
  VerdictReason reason;
  reason.code = code;
  reason.text = std::move(text);
  reason.figure = figure;
  reason.limit = limit;
  reason.unit = "%";
  reason.source = "Sinew";
  reason.remedy = remedy;
  return reason;
}

void add_shares(const std::vector<Missing>& all, int frames, double rate,
                std::vector<VerdictReason>& reasons) {
  std::vector<std::string> often, hardly;
  double most = 0.0;
  const int fewest = static_cast<int>(std::lround(kFewest * rate));
  for (const Missing& missing : all) {
    if (missing.measured < std::min(fewest, frames)) {
      hardly.push_back(fmt::format("{} ({} of {} frames)", missing.name, missing.measured, frames));
    } else if (missing.share > kMostFilledMarker) {
      often.push_back(fmt::format("{} ({:.0f} %)", missing.name, 100.0 * missing.share));
      most = std::max(most, missing.share);
    }
  }
  if (!often.empty()) {
    reasons.push_back(of("filled-share",
                         fmt::format("seldom seen marker{}: not measured in more than a quarter of "
                                     "the frames: {}",
                                     often.size() == 1 ? "" : "s", list_names(often)),
                         100.0 * most, 100.0 * kMostFilledMarker,
                         "Label them, or leave them out with --drop."));
  }
  if (!hardly.empty()) {
    VerdictReason reason =
        of("gap",
           fmt::format("marker{} that {} hardly ever seen and say{} nothing: {}",
                       hardly.size() == 1 ? "" : "s", hardly.size() == 1 ? "is" : "are",
                       hardly.size() == 1 ? "s" : "", list_names(hardly)),
           std::nan(""), std::nan(""), "Label them, or leave them out with --drop.");
    reason.unit.clear();
    reasons.push_back(reason);
  }
}

std::string times_of(const UndeterminedStretch& stretch, const MarkerTrajectories& markers) {
  return fmt::format("{} s to {} s", time_text(markers.time[stretch.first]),
                     time_text(markers.time[stretch.first + stretch.count - 1]));
}

void add_undetermined(const MusculoskeletalModel& model, const MarkerTrajectories& markers,
                      int frames, const std::vector<UndeterminedStretch>& stretches,
                      std::vector<VerdictReason>& reasons) {
  if (stretches.empty()) return;
  std::set<int> frames_seen, coordinates;
  std::vector<std::string> times;
  bool nothing = false;
  for (const UndeterminedStretch& stretch : stretches) {
    for (int f = stretch.first; f < stretch.first + stretch.count; ++f) frames_seen.insert(f);
    coordinates.insert(stretch.coordinates.begin(), stretch.coordinates.end());
    times.push_back(times_of(stretch, markers));
    nothing = nothing || stretch.measured_markers == 0;
  }
  std::vector<std::string> names;
  for (const int c : coordinates) {
    names.push_back(model.coordinates[static_cast<std::size_t>(c)].name);
  }
  const double share = double(frames_seen.size()) / frames;
  VerdictReason reason =
      of("gap",
         fmt::format("too few markers are seen to tell {} from {}{}: there nothing is measured, "
                     "the values go on from what is known beside it",
                     nothing ? "the pose" : list_names(names), list_names(times, 4),
                     nothing ? ", and none at all in part of it" : ""),
         100.0 * share, 100.0 * kMostUndetermined,
         "Use no angles and torques of these times, or solve a part with --from and --to.");
  if (share > kMostUndetermined) reason.weight = VerdictReason::Weight::kUnusable;
  reason.angles = names;
  reason.torques = names;
  reasons.push_back(std::move(reason));
}

}  // namespace

std::vector<VerdictReason> gap_reasons(const MusculoskeletalModel& model,
                                       const TrackingProblem& tracking,
                                       const MarkerTrajectories& markers, int first, int end,
                                       const std::vector<UndeterminedStretch>& stretches) {
  std::vector<VerdictReason> reasons;
  if (end <= first) return reasons;
  add_shares(missing_of(tracking, markers, first, end), end - first, markers.rate, reasons);
  add_undetermined(model, markers, end - first, stretches, reasons);
  return reasons;
}

}  // namespace sinew
