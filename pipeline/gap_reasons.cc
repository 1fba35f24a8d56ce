#include "pipeline/gap_reasons.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
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
                         "label them, or leave them out with --drop"));
  }
  if (!hardly.empty()) {
    VerdictReason reason =
        of("gap",
           fmt::format("marker{} that {} hardly ever seen and say{} nothing: {}",
                       hardly.size() == 1 ? "" : "s", hardly.size() == 1 ? "is" : "are",
                       hardly.size() == 1 ? "s" : "", list_names(hardly)),
           std::nan(""), std::nan(""), "label them, or leave them out with --drop");
    reason.unit.clear();
    reasons.push_back(reason);
  }
}

// `0.1 s to 0.2 s, 0.5 s to 0.6 s and 3 others` of frames in ascending order.
std::string times_of(const std::set<int>& frames, const MarkerTrajectories& markers) {
  std::vector<std::string> times;
  for (auto f = frames.begin(); f != frames.end();) {
    const int first = *f;
    int last = first;
    while (++f != frames.end() && *f == last + 1) ++last;
    times.push_back(
        fmt::format("{} s to {} s", time_text(markers.time[first]), time_text(markers.time[last])));
  }
  return list_names(times, 4);
}

void add_undetermined(const MusculoskeletalModel& model, const MarkerTrajectories& markers,
                      int begin, int end, const std::vector<UndeterminedStretch>& stretches,
                      int reach, std::vector<VerdictReason>& reasons) {
  if (stretches.empty()) return;
  std::set<int> frames_seen;
  std::map<int, int> frames_of;  // by coordinate
  bool nothing = false;
  for (const UndeterminedStretch& stretch : stretches) {
    const int from = std::max(begin, stretch.first - reach);
    const int to = std::min(end, stretch.first + stretch.count + reach);
    for (int f = from; f < to; ++f) frames_seen.insert(f);
    for (const int c : stretch.coordinates) frames_of[c] += stretch.count;
    nothing = nothing || stretch.measured_markers == 0;
  }
  std::vector<std::string> names, spoiled;
  double most = 0.0;
  bool root = false;
  for (const auto& [c, count] : frames_of) {
    const Coordinate& coordinate = model.coordinates[static_cast<std::size_t>(c)];
    const double share = double(count) / (end - begin);
    names.push_back(coordinate.name);
    most = std::max(most, share);
    if (share <= kMostUndetermined) continue;
    spoiled.push_back(coordinate.name);
    root = root || model.joints[static_cast<std::size_t>(coordinate.joint)].parent == 0;
  }
  VerdictReason reason = of(
      "gap",
      fmt::format(
          "too few markers are seen to tell {}{}: there the values go on from what is known "
          "beside it; angles and torques of {} hang on them",
          nothing ? "the pose" : list_names(names), nothing ? ", and none at all in a part" : "",
          times_of(frames_seen, markers)),
      100.0 * most, std::nan(""),
      "use nothing where a column NAME_determined of id.sto is 0, or solve a part with --from and "
      "--to");
  reason.unit = "% of the frames";
  if (!spoiled.empty()) reason.limit = 100.0 * kMostUndetermined;
  if (root) reason.weight = VerdictReason::Weight::kUnusable;
  reason.angles = spoiled;
  reason.torques = spoiled;
  reasons.push_back(std::move(reason));
}

}  // namespace

std::vector<VerdictReason> gap_reasons(
    const MusculoskeletalModel& model, const TrackingProblem& tracking,
    const MarkerTrajectories& markers, int first, int end,
    const std::vector<UndeterminedStretch>& stretches, int reach,
    const std::function<std::string(const std::string&)>& shown) {
  std::vector<VerdictReason> reasons;
  if (end <= first) return reasons;
  std::vector<Missing> missing = missing_of(tracking, markers, first, end);
  for (Missing& each : missing) each.name = shown(each.name);
  add_shares(missing, end - first, markers.rate, reasons);
  add_undetermined(model, markers, first, end, stretches, reach, reasons);
  return reasons;
}

}  // namespace sinew
