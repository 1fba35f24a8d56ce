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

// What makes the torques of whatever carries the body wrong, in the figure's unit.
struct Spoilt {
  double figure, limit;
  const char* unit;
};

void spoil(const DynamicsEvidence& d, const char* code, const Spoilt& by, std::string text,
           std::string remedy, std::vector<VerdictReason>& reasons) {
  VerdictReason& r = reasons.emplace_back(own_reason(code, std::move(text), std::move(remedy)));
  r.weight = Weight::kUnusable;
  r.figure = by.figure;
  r.limit = by.limit;
  r.unit = by.unit;
  r.torques = d.supporting;
}

// Whether, and where, what carries the body is known.
void judge_coverage(const DynamicsEvidence& d, std::vector<VerdictReason>& reasons) {
  if (!d.loads_given) {
    VerdictReason r =
        own_reason("no-loads", "no ground forces: torques of what carries the body lack them",
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
  const double least = -0.05 * d.weight;
  const auto down = [&](const PullEvidence& pull) { return pull.mean < least; };
  const bool all = std::all_of(d.pulls.begin(), d.pulls.end(), down);
  if (d.mean_vertical_load < least && all) {
    spoil(d, "loads-pull-down", {d.mean_vertical_load, 0.0, "N"}, "the loads pull the body down",
          kCheckLoads, reasons);
  }
  for (const PullEvidence& pull : d.pulls) {
    if (all || !down(pull)) continue;
    spoil(d, "loads-pull-down", {pull.mean, 0.0, "N"},
          fmt::format("the force on {} pulls down", pull.body),
          "turn the sign of its forces in the file of the loads", reasons);
  }
  // Nobody stands on what pushes sideways more than up.
  if (auto* r = judge_figure(reasons, {d.horizontal_load_rms, d.vertical_load_rms, NAN}, 1.0, "N",
                             "loads-sideways", kOwn)) {
    r->text = "the loads push sideways more than up";
    r->remedy = kCheckLoads;
  }
}

// `the force on calcn_r pushes`.
std::string pushing(const std::string& body, const std::string& times) {
  if (body.empty()) return "the loads push";
  return fmt::format("the force on {} pushes{}{}", body, times.empty() ? "" : " ", times);
}

// Of the weight: as much as makes a contact of load_placements() a loaded one.
constexpr double kActs = 0.1;
constexpr const char* kTurnWhere =
    "in the file of the loads, or by the platform's corners or channels in the C3D file";

// Sums are the mass times its acceleration, whatever the inner movement: a cosine of -1 is a turned
// sign, of 0 an exchanged axis or another trial. Of one turned load of several the others suffer
// less: the worst along each axis is it. Of contacts nothing more is said where a whole load is.
void judge_pushes(const DynamicsEvidence& d, std::vector<VerdictReason>& reasons) {
  std::map<std::string, const PushEvidence*> whole, contacts;  // the worst along each axis
  for (const PushEvidence& p : d.pushes) {
    if (!(std::min(p.load_rms, p.need_rms) > kLeastPush * d.weight)) continue;
    const PushEvidence*& so_far = (p.times.empty() ? whole : contacts)[p.axis];
    if (so_far == nullptr || p.cosine < so_far->cosine) so_far = &p;
  }
  for (const auto& [axis, p] : contacts) {
    const PushEvidence*& load = whole[axis];
    if (load == nullptr || !(-load->cosine > kTurnedPush)) load = p;
  }
  for (const auto& [axis, p] : whole) {
    auto* r = judge_figure(reasons, {-p->cosine, kTurnedPush, kTurnedPush}, 1.0, "", "loads-turned",
                           kOwn);
    if (r == nullptr) continue;
    r->text = fmt::format(
        "{} against the acceleration of the body's mass along {} (minus the cosine of both)",
        pushing(p->body, p->times), axis);
    r->remedy = fmt::format("turn the sign of {} {}: {}", p->body.empty() ? "their" : "its", axis,
                            kTurnWhere);
    r->torques = d.supporting;
  }
}

// Platforms of which a channel is dead, or that measure upwards only.
void judge_lack_of_push(const DynamicsEvidence& d, std::vector<VerdictReason>& reasons) {
  const PushEvidence* most = nullptr;
  for (const PushEvidence& p : d.pushes) {
    // Something carries the body then.
    if (!(p.acts_rms > kActs * d.weight) || !(p.need_rms > 3.0 * kLeastPush * d.weight)) continue;
    if (!(p.load_rms < kDeadPush * p.need_rms)) continue;
    if (most == nullptr || p.need_rms > most->need_rms) most = &p;
  }
  if (most == nullptr) return;
  spoil(d, "loads-no-push", {most->load_rms, kDeadPush * most->need_rms, "N"},
        fmt::format("{} hardly along {}, while the body's mass accelerates (RMS; needed: {:.1f} N)",
                    pushing(most->body, most->times), most->axis, most->need_rms),
        "is a channel of the platform dead, or does it measure upwards only?", reasons);
}

// Exchanged axes and rotated platforms.
void judge_turns(const DynamicsEvidence& d, std::vector<VerdictReason>& reasons) {
  const TurnEvidence *whole = nullptr, *contact = nullptr;  // that a turn mends best
  for (const TurnEvidence& t : d.turns) {
    if (!(t.left < kTurnLeaves) || !(t.load_rms > kLeastPush * d.weight)) continue;
    const TurnEvidence*& best = t.times.empty() ? whole : contact;
    if (best == nullptr || t.left < best->left) best = &t;
  }
  const TurnEvidence* t = whole != nullptr ? whole : contact;
  if (t == nullptr) return;
  spoil(d, "loads-turned", {100.0 * t->left, 100.0 * kTurnLeaves, "% of it"},
        fmt::format("{} along other axes than the body's mass accelerates: with {} a part of the "
                    "horizontal force at the pelvis would be left",
                    pushing(t->body, t->times), t->axes),
        fmt::format("turn them: {}", kTurnWhere), reasons);
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
  r->remedy = fmt::format("{} {:.1f}, or look at the forces' scale: `sinew check`",
                          d.by_platforms ? "--mass" : "`sinew scale --mass`", d.carried_mass);
  if (r->weight == Weight::kUnusable) r->torques = d.coordinates;
}

void judge_root(const DynamicsEvidence& d, std::vector<VerdictReason>& reasons) {
  if (d.known == 0 || !(d.peak_load > 0.0)) return;
  const double force = d.root.force_rms / d.peak_load;
  if (auto* r = judge_figure(reasons, {force, kResidualForce, kWorstResidualForce}, 100.0,
                             "% of the largest ground force", "residual-force", kHicks)) {
    r->text = "a force at the pelvis that nothing exerts (RMS)";
    r->remedy = r->weight == Weight::kUnusable ? kCheckLoads
                : d.by_platforms
                    ? "--mass, and the same --cutoff as the forces had"
                    : "the model's mass (`sinew scale --mass`), and the same --cutoff as the "
                      "forces had";
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
      judge_turns(dynamics, reasons);
      judge_lack_of_push(dynamics, reasons);
      judge_mass(dynamics, reasons);
      judge_root(dynamics, reasons);
    }
  }
  if (!dynamics.not_given.empty()) {
    VerdictReason r =
        own_reason("not-in-motion", "no angles are given for " + some_names(dynamics.not_given),
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
