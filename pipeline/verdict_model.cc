#include "pipeline/verdict_model.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "pipeline/verdict_limits.h"
#include "pipeline/verdict_reasons.h"

namespace sinew {
namespace {

using namespace limits;
using Weight = VerdictReason::Weight;

constexpr const char* kFit = "fit the model to the person: `sinew scale --auto`, or --static";

void judge_mass(const ModelEvidence& model, std::vector<VerdictReason>& reasons) {
  if (auto* r =
          judge_figure(reasons, {model.mass, kHeaviest, kHeaviest}, 1.0, "kg", "mass", kOwn)) {
    r->text = "no person is as heavy as the model";
    r->remedy = "give --mass, and look at the sizes of the segments";
  }
  if (!model.stands) return;
  auto* r = judge_figure(reasons, {model.height, kTall, kWorstTall}, 1.0, "m", "height", kOwn);
  if (r == nullptr) {
    r = judge_figure(reasons, {model.height, kShort, kWorstShort}, 1.0, "m", "height", kOwn);
  }
  if (r != nullptr) {
    r->text = "the model is " + std::string(model.height > kTall ? "taller" : "smaller") +
              " than people are";
    r->remedy = "look at the unit of the recording that it was fitted to (--unit)";
  }
  const double index = model.mass / (model.height * model.height);
  r = judge_figure(reasons, {index, kHeavy, kWorstHeavy}, 1.0, "kg/m²", "body-mass-index", kOwn);
  if (r == nullptr) {
    r = judge_figure(reasons, {index, kThin, kWorstThin}, 1.0, "kg/m²", "body-mass-index", kOwn);
  }
  if (r == nullptr) return;
  r->text = fmt::format("{:.0f} kg are {} for somebody of {:.2f} m, which the model is", model.mass,
                        index > kHeavy ? "much" : "little", model.height);
  r->remedy = "give the person's mass in kg: --mass";
}

}  // namespace

std::vector<VerdictReason> judge_model(const ModelEvidence& model) {
  std::vector<VerdictReason> reasons;
  judge_mass(model, reasons);
  const auto difference = [](const SideLength& side) {
    const double shorter = std::min(side.length, side.partner_length);
    const double d = std::abs(side.length - side.partner_length);
    return d > kSideLengthLeast && shorter > 0.0 ? d / shorter : 0.0;
  };
  const auto worst = std::max_element(
      model.sides.begin(), model.sides.end(),
      [&](const SideLength& a, const SideLength& b) { return difference(a) < difference(b); });
  if (worst == model.sides.end()) return reasons;
  if (auto* r = judge_figure(reasons, {difference(*worst), kSideLength, NAN}, 100.0, "%",
                             "side-size", kOwn)) {
    r->text = fmt::format("{} and {} differ in length", worst->body, worst->partner);
    r->remedy = "are markers of one side misplaced? `sinew scale --auto` ties left to right";
  }
  return reasons;
}

std::vector<VerdictReason> judge_scale(const ScaleEvidence& scale) {
  std::vector<VerdictReason> reasons;
  if (!scale.converged) {
    VerdictReason r;
    r.weight = Weight::kUnusable;
    r.code = "unconverged";
    r.text = "the fit did not come to its end";
    r.source = kOwn;
    r.remedy = "look for markers that are wrong: `sinew check`";
    reasons.push_back(r);
  }
  if (auto* r = judge_figure(reasons, {scale.pose_rms, kMarkerRms, kWorstMarkerRms}, 1e3, "mm",
                             "marker-rms", kHicks)) {
    r->text = "the static pose does not meet the measured markers";
    r->remedy = "look for exchanged or misplaced markers: `sinew check`";
  }
  const ScaleEvidence::Factor* large = nullptr;
  const ScaleEvidence::Factor* small = nullptr;
  for (const ScaleEvidence::Factor& f : scale.factors) {
    if (large == nullptr || f.largest > large->largest) large = &f;
    if (small == nullptr || f.smallest < small->smallest) small = &f;
  }
  const auto judge_factor = [&](const ScaleEvidence::Factor* f, const Judged& judged,
                                const char* word) {
    if (f == nullptr) return;
    if (auto* r = judge_figure(reasons, judged, 1.0, "times the model's", "scale-factor", kOwn)) {
      r->text = fmt::format("{} becomes {} than in people", f->body, word);
      r->remedy = "look at the unit (`sinew check`), and at the markers on that segment";
    }
  };
  if (large != nullptr) {
    judge_factor(large, {large->largest, kLargeFactor, kWorstLargeFactor}, "larger");
    judge_factor(small, {small->smallest, kSmallFactor, kWorstSmallFactor}, "smaller");
  }
  double farthest = 0.0;
  std::vector<std::string> names;
  for (const ScaleEvidence::MovedMarker& m : scale.moved) {
    if (!(m.distance > kMovedMarker)) continue;
    names.insert(m.distance > farthest ? names.begin() : names.end(), m.name);
    farthest = std::max(farthest, m.distance);
  }
  if (auto* r =
          judge_figure(reasons, {farthest, kMovedMarker, NAN}, 1e3, "mm", "moved-marker", kOwn)) {
    r->text = fmt::format("{} moved from where the model has {}", some_names(names),
                          names.size() == 1 ? "it" : "them");
    r->remedy = "are they on the landmarks that the model means?";
  }
  return reasons;
}

}  // namespace sinew
