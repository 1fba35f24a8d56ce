#include "data/frame_continuity.h"

#include <fmt/format.h>

#include <algorithm>

#include "data/statistics.h"

namespace sinew {
namespace {

constexpr int kFrozen = 3;         // one frame twice is what resampling leaves
constexpr double kMoves = 0.5;     // part of the frames that differ from those before
constexpr double kLongStep = 2.5;  // of the usual time between frames: two were dropped

// Whether any marker is measured in both frames, and all of these stand still.
bool equal_frames(const MarkerTrajectories& markers, int a, int b) {
  bool any = false;
  for (int m = 0; m < markers.marker_count(); ++m) {
    const Eigen::Vector3d p = markers.position(a, m), q = markers.position(b, m);
    if (!p.allFinite() || !q.allFinite()) continue;
    if (p != q) return false;
    any = true;
  }
  return any;
}

void find_frozen(const MarkerTrajectories& markers, std::vector<VerdictReason>& reasons) {
  int equal = 0, longest = 0, from = 0, count = 0;
  for (int f = 1; f < markers.frame_count(); ++f) {
    count = equal_frames(markers, f - 1, f) ? count + 1 : 0;
    equal += count > 0;
    if (count <= longest) continue;
    longest = count;
    from = f - count;
  }
  const int compared = markers.frame_count() - 1;
  if (longest < kFrozen || equal > (1.0 - kMoves) * compared) return;
  VerdictReason& r = reasons.emplace_back();
  r.code = "frozen-frames";
  r.weight = VerdictReason::Weight::kUnusable;
  r.figure = longest;
  r.limit = kFrozen - 1;
  r.unit = "frames";
  r.text = fmt::format("all markers stand still from {:.3f} s to {:.3f} s and jump then",
                       markers.time[from], markers.time[from + longest]);
  r.source = "Sinew";
  r.remedy = "export the recording anew, or leave them out by --from and --to";
}

void find_hole(const MarkerTrajectories& markers, std::vector<VerdictReason>& reasons) {
  const Eigen::Index n = markers.time.size();
  if (n < 3) return;
  const Eigen::VectorXd steps = markers.time.tail(n - 1) - markers.time.head(n - 1);
  const double usual = median(std::vector<double>(steps.begin(), steps.end()));
  Eigen::Index at = 0;
  const double longest = steps.maxCoeff(&at);
  if (!(longest > kLongStep * usual)) return;
  VerdictReason& r = reasons.emplace_back();
  r.code = "time-hole";
  r.figure = longest;
  r.limit = kLongStep * usual;
  r.unit = "s";
  r.text =
      fmt::format("no frames between {:.3f} s and {:.3f} s: torques there are another motion's",
                  markers.time[at], markers.time[at + 1]);
  r.source = "Sinew";
  r.remedy = "--from and --to solve the parts before and after it by themselves";
}

}  // namespace

std::vector<VerdictReason> frame_reasons(const MarkerTrajectories& markers) {
  std::vector<VerdictReason> reasons;
  find_frozen(markers, reasons);
  find_hole(markers, reasons);
  return reasons;
}

}  // namespace sinew
