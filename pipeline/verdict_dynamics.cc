#include "pipeline/verdict_dynamics.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "pipeline/verdict_limits.h"
#include "pipeline/verdict_reasons.h"

namespace sinew {
namespace {

using namespace limits;
using Weight = VerdictReason::Weight;

constexpr double kGravity = 9.80665;  // standard [m/s²]
constexpr const char* kCheckLoads =
    "look at unit, axes, sign and feet of the loads: `sinew check LOADS.mot RECORDING`";

VerdictReason own(const char* code, std::string text, std::string remedy) {
  VerdictReason r;
  r.code = code;
  r.text = std::move(text);
  r.source = kOwn;
  r.remedy = std::move(remedy);
  return r;
}

// Whether, and where, what carries the body is known.
void judge_coverage(const DynamicsEvidence& d, std::vector<VerdictReason>& reasons) {
  if (!d.loads_given) {
    VerdictReason r =
        own("no-loads", "no ground forces: torques of what carries the body lack them",
            "give them: --loads, or --c3d with force platforms");
    r.torques = d.supporting;
    reasons.push_back(r);
    return;
  }
  const double share = d.frames > 0 ? static_cast<double>(d.known) / d.frames : 0.0;
  auto* r =
      judge_figure(reasons, {share, 1.0, 1e-12}, 100.0, "% of the frames", "loads-missing", kOwn);
  if (r == nullptr) return;
  if (d.known == 0) {
    r->weight = Weight::kUnusable;
    r->torques = d.supporting;
    r->text = d.by_platforms
                  ? "in no frame all ground forces are known"
                  : "the loads carry the body (more than half of its weight) in no frame";
    r->remedy = d.by_platforms ? "load_coverage.csv says why; --assign says which foot stands where"
                               : kCheckLoads;
    return;
  }
  for (const FootEvidence& foot : d.feet) {
    if (foot.complete == 0)
      r->torques.insert(r->torques.end(), foot.torques.begin(), foot.torques.end());
  }
  r->text =
      d.by_platforms
          ? "all ground forces are known in a part of the trial only; elsewhere the torques of a "
            "leg "
            "lack them"
          : "the loads carry the body (more than half of its weight) in a part of the trial only";
  r->remedy = d.by_platforms
                  ? "load_coverage.csv says when which foot's are known; in id.sto the columns "
                    "right_loads_complete and left_loads_complete are 1 then"
                  : "elsewhere a step was not measured: --from and --to leave it out";
}

void judge_direction(const DynamicsEvidence& d, std::vector<VerdictReason>& reasons) {
  // A twentieth of the weight is more than any offset of a platform.
  if (d.mean_vertical_load < -0.05 * d.weight) {
    VerdictReason r = own("loads-pull-down", "the loads pull the body down", kCheckLoads);
    r.weight = Weight::kUnusable;
    r.figure = d.mean_vertical_load;
    r.limit = 0.0;
    r.unit = "N";
    r.torques = d.supporting;
    reasons.push_back(r);
  }
  // Nobody stands on what pushes sideways more than up.
  if (auto* r = judge_figure(reasons, {d.horizontal_load_rms, d.vertical_load_rms, NAN}, 1.0, "N",
                             "loads-sideways", kOwn)) {
    r->text = "the loads push sideways more than up";
    r->remedy = kCheckLoads;
  }
}

// Sums are the mass times its acceleration, whatever the inner movement: a cosine of -1 is a turned
// sign, of 0 an exchanged axis or another trial. Of one turned load of several the others suffer
// less: the worst along each axis is it.
void judge_pushes(const DynamicsEvidence& d, std::vector<VerdictReason>& reasons) {
  std::map<std::string, const PushEvidence*> worst;
  for (const PushEvidence& p : d.pushes) {
    if (!(std::min(p.load_rms, p.need_rms) > kLeastPush * d.weight)) continue;
    const PushEvidence*& so_far = worst[p.axis];
    if (so_far == nullptr || p.cosine < so_far->cosine) so_far = &p;
  }
  for (const auto& [axis, p] : worst) {
    auto* r = judge_figure(reasons, {-p->cosine, kTurnedPush, kTurnedPush}, 1.0, "", "loads-turned",
                           kOwn);
    if (r == nullptr) continue;
    r->text = fmt::format(
        "{} against the acceleration of the body's mass along {} (minus the cosine of both)",
        p->body.empty() ? std::string("the loads push")
                        : fmt::format("the force on {} pushes", p->body),
        axis);
    r->remedy = fmt::format(
        "turn the sign of {} {}: in the file of the loads, or by the platform's corners in the "
        "C3D file",
        p->body.empty() ? "their" : "its", axis);
    r->torques = d.supporting;
  }
}

void judge_mass(const DynamicsEvidence& d, std::vector<VerdictReason>& reasons) {
  const double mass = d.weight / kGravity;
  const double off = std::abs(mass - d.carried_mass) / d.carried_mass;
  const double limit = d.mass_of_some_frames ? kMassOfTable : kMass;
  // A part of a stride on platforms tells too little to reject anything.
  const double worst = d.mass_of_some_frames && d.by_platforms ? NAN : kWorstMass;
  auto* r = judge_figure(reasons, {off, limit, worst}, 100.0, "%", "mass-carried", kOwn);
  if (r == nullptr) return;
  r->text =
      fmt::format("the ground carries {:.1f} kg, the model has {:.1f} kg", d.carried_mass, mass);
  r->remedy = fmt::format("--mass {:.1f}", d.carried_mass);
  if (r->weight == Weight::kUnusable) r->torques = d.coordinates;
}

void judge_root(const DynamicsEvidence& d, std::vector<VerdictReason>& reasons) {
  if (d.known == 0 || !(d.peak_load > 0.0)) return;
  const double force = d.root.force_rms / d.peak_load;
  if (auto* r = judge_figure(reasons, {force, kResidualForce, kWorstResidualForce}, 100.0,
                             "% of the largest ground force", "residual-force", kHicks)) {
    r->text = "a force at the pelvis that nothing exerts (RMS)";
    r->remedy = r->weight == Weight::kUnusable ? kCheckLoads
                                               : "--mass, and the same --cutoff as the forces had";
    if (r->weight == Weight::kUnusable) r->torques = d.coordinates;
  }
  const double moment = d.root.moment_rms / (d.peak_load * d.height);
  if (auto* r = judge_figure(reasons, {moment, kResidualMoment, kWorstResidualMoment}, 100.0,
                             "% of height times that", "residual-moment", kHicks)) {
    r->text = "a moment at the pelvis that nothing exerts (RMS)";
    r->remedy = r->weight == Weight::kUnusable
                    ? kCheckLoads
                    : "do centres of pressure and feet fit? `sinew check` (clock, place)";
    if (r->weight == Weight::kUnusable) r->torques = d.coordinates;
  }
}

}  // namespace

std::vector<VerdictReason> judge_dynamics(const DynamicsEvidence& dynamics) {
  std::vector<VerdictReason> reasons;
  if (dynamics.floating) {
    judge_coverage(dynamics, reasons);
    if (dynamics.loads_given) {
      judge_direction(dynamics, reasons);
      judge_pushes(dynamics, reasons);
      judge_mass(dynamics, reasons);
      judge_root(dynamics, reasons);
    }
  }
  if (!dynamics.not_given.empty()) {
    VerdictReason r =
        own("not-in-motion", "no angles are given for " + some_names(dynamics.not_given),
            "they stay at the model's defaults; give a motion that has them");
    r.torques = dynamics.not_given;
    reasons.push_back(r);
  }
  return reasons;
}

std::vector<std::string> partly_known_torques(const DynamicsEvidence& dynamics) {
  if (!dynamics.floating || !dynamics.loads_given) return {};
  std::vector<std::string> partly;
  if (dynamics.by_platforms) {
    for (const FootEvidence& foot : dynamics.feet) {
      if (foot.complete == dynamics.frames) continue;
      partly.insert(partly.end(), foot.torques.begin(), foot.torques.end());
    }
  } else if (dynamics.known < dynamics.frames) {
    partly = dynamics.supporting;
  }
  return partly;
}

}  // namespace sinew
