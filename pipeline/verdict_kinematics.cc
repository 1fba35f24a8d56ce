#include "pipeline/verdict_kinematics.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "pipeline/verdict_limits.h"
#include "pipeline/verdict_reasons.h"

namespace sinew {
namespace {

using namespace limits;
using Weight = VerdictReason::Weight;

// Beyond it no marker set, calibration or movement explains the distance [m].
constexpr double kAnotherWorld = 0.1;

// For a reason that spoils all of a result.
void blame_all(const KinematicsEvidence& k, VerdictReason* r) {
  if (r == nullptr || r->weight != Weight::kUnusable) return;
  for (const CoordinateEvidence& c : k.coordinates) r->angles.push_back(c.name);
  r->torques = r->angles;
}

void judge_frames(const KinematicsEvidence& k, std::vector<VerdictReason>& reasons) {
  const double frames = std::max(k.frames, 1);
  // One is enough: nobody looks at a frame among thousands.
  if (auto* r = judge_figure(reasons, {k.unconverged / frames, 0.0, 0.0}, 100.0, "%", "unconverged",
                             kOwn)) {
    r->text = fmt::format("in {} of {} frames no pose was found", k.unconverged, k.frames);
    r->remedy = "another --method, or --from and --to; frame_errors.csv of `sinew run` names them";
    blame_all(k, r);
  }
  if (auto* r = judge_figure(reasons, {k.unmeasured / frames, kUnmeasured, kWorstUnmeasured}, 100.0,
                             "%", "unmeasured-frames", kOwn)) {
    r->text = fmt::format(
        "in {} of {} frames no marker was measured: the angles there go on from what is known "
        "beside them",
        k.unmeasured, k.frames);
    r->remedy = "leave them out: --from and --to";
    blame_all(k, r);
  }
  if (auto* r = judge_figure(reasons, {k.filled, kFilled, NAN}, 100.0, "%", "filled-share", kOwn)) {
    r->text = "marker positions were filled in";
    r->remedy = "--max-gap fills less; filled.csv lists them";
  }
  // A handstand or a recumbent bicycle is no fault, a wrong axis is.
  if (auto* r = judge_figure(reasons, {k.fallen, kFallen, NAN}, 100.0, "% of the frames",
                             "not-upright", kOwn)) {
    r->text =
        "the feet are not below the pelvis: the subject lies or stands on the head, or the "
        "recording's up is not the model's";
    r->remedy =
        "`sinew check RECORDING` tells its axes; `sinew convert --up`, or `sinew run --c3d`";
  }
}

void judge_markers(const KinematicsEvidence& k, std::vector<VerdictReason>& reasons) {
  if (auto* r = judge_figure(reasons, {k.marker_rms, kMarkerRms, kWorstMarkerRms}, 1e3, "mm",
                             "marker-rms", kHicks)) {
    r->text = "the model's markers are beside the measured ones (RMS of all)";
    r->remedy =
        k.marker_rms > kAnotherWorld
            ? "wrong unit, axes, model or names: `sinew check RECORDING --model MODEL` tells"
            : "fit the model to the person: `sinew scale --auto`, or --static";
    blame_all(k, r);
  }
  if (auto* r = judge_figure(reasons, {k.marker_rms, k.static_rms + kMoreThanStatic, NAN}, 1e3,
                             "mm", "static-rms", kOwn)) {
    r->text = fmt::format(
        "markers are farther off in the movement than standing ({:.1f} mm): an axis of a joint, or "
        "a marker that was moved between the trials",
        1e3 * k.static_rms);
    r->remedy = "--scale walk fits to the movement";
  }
  std::vector<const MarkerEvidence*> far, lost;
  for (const MarkerEvidence& m : k.markers) {
    if (m.max > kMarkerMax) far.push_back(&m);
    if (m.rms > kLostMarker) lost.push_back(&m);
  }
  const auto names_of = [](std::vector<const MarkerEvidence*>& markers, auto by) {
    std::stable_sort(markers.begin(), markers.end(),
                     [&](const auto* a, const auto* b) { return a->*by > b->*by; });
    std::vector<std::string> names;
    for (const MarkerEvidence* m : markers) names.push_back(m->name);
    return some_names(names, 4);
  };
  if (!lost.empty()) {
    const std::string names = names_of(lost, &MarkerEvidence::rms);
    auto* r = judge_figure(reasons, {lost.front()->rms, kLostMarker, NAN}, 1e3, "mm", "lost-marker",
                           kOwn);
    r->text = fmt::format("{} {} not where the model has {} (RMS)", names,
                          lost.size() == 1 ? "is" : "are", lost.size() == 1 ? "it" : "them");
    r->remedy = "misplaced, exchanged or of another name: `sinew check`, --drop, --swap, --map";
    for (const MarkerEvidence* m : lost) {
      r->angles.insert(r->angles.end(), m->angles.begin(), m->angles.end());
    }
    r->torques = r->angles;
  }
  if (!far.empty()) {
    const std::string names = names_of(far, &MarkerEvidence::max);
    auto* r =
        judge_figure(reasons, {far.front()->max, kMarkerMax, NAN}, 1e3, "mm", "marker-max", kHicks);
    r->text = fmt::format("farthest off in a frame: {}", names);
    r->remedy = "marker_errors.csv of `sinew run` says where and when";
  }
}

void judge_coordinates(const KinematicsEvidence& k, std::vector<VerdictReason>& reasons) {
  std::vector<std::string> bound, held;
  double most = 0.0;
  for (const CoordinateEvidence& c : k.coordinates) {
    if (c.on_bound > kOnBound && !c.undetermined) {
      bound.insert(c.on_bound > most ? bound.begin() : bound.end(), c.name);
      if (c.on_bound > kWorstOnBound) held.push_back(c.name);
      most = std::max(most, c.on_bound);
    }
  }
  if (auto* r = judge_figure(reasons, {most, kOnBound, NAN}, 100.0, "% of the frames", "on-bound",
                             kOwn)) {
    r->text = "at the end of the range that the model allows: " + some_names(bound, 4);
    r->remedy = "does the model fit the person (`sinew scale`), or is its range too narrow?";
    r->angles = r->torques = held;
  }
}

void judge_sides(const KinematicsEvidence& k, std::vector<VerdictReason>& reasons) {
  double sum[2] = {0.0, 0.0};
  long count[2] = {0, 0};
  for (const MarkerEvidence& m : k.markers) {
    if (m.side == 0 || m.measured == 0) continue;
    const int s = m.side > 0 ? 1 : 0;
    sum[s] += m.rms * m.rms * m.measured;
    count[s] += m.measured;
  }
  if (count[0] > 0 && count[1] > 0) {
    const double left = std::sqrt(sum[0] / static_cast<double>(count[0]));
    const double right = std::sqrt(sum[1] / static_cast<double>(count[1]));
    const double worse = std::max(left, right), better = std::min(left, right);
    if (auto* r = judge_figure(reasons, {worse, std::max(kMarkerRms, kSideRatio * better), NAN},
                               1e3, "mm", "side-rms", kOwn)) {
      r->text = fmt::format("markers of the {} side are farther off than the other's ({:.1f} mm)",
                            left > right ? "left" : "right", 1e3 * better);
      r->remedy = "look for a misplaced or exchanged marker on that side: `sinew check`";
    }
  }
  const CoordinateEvidence* still = nullptr;
  const CoordinateEvidence* moving = nullptr;
  double most = 0.0;
  for (const CoordinateEvidence& a : k.coordinates) {
    if (a.partner.empty() || !a.rotational || a.undetermined) continue;
    for (const CoordinateEvidence& b : k.coordinates) {
      if (b.name != a.partner || b.undetermined) continue;
      const auto& [less, more] = a.range < b.range ? std::pair{&a, &b} : std::pair{&b, &a};
      if (more->range < kSideRangeRatio * less->range || more->range - less->range <= most)
        continue;
      most = more->range - less->range;
      still = less;
      moving = more;
    }
  }
  if (auto* r = judge_figure(reasons, {most, kSideRange, NAN}, 180.0 / std::numbers::pi, "degrees",
                             "side-range", kOwn)) {
    r->text = fmt::format("{} moves less than {}", still->name, moving->name);
    r->remedy = "a stiff joint, a part of a stride, or a wrong marker: look at both curves";
  }
}

}  // namespace

std::vector<VerdictReason> judge_kinematics(const KinematicsEvidence& kinematics) {
  std::vector<VerdictReason> reasons;
  judge_markers(kinematics, reasons);
  judge_frames(kinematics, reasons);
  judge_coordinates(kinematics, reasons);
  judge_sides(kinematics, reasons);
  return reasons;
}

}  // namespace sinew
