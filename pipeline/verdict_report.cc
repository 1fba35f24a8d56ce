#include "pipeline/verdict_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "data/output_file.h"
#include "pipeline/command.h"
#include "pipeline/verdict_limits.h"
#include "pipeline/verdict_reasons.h"

namespace sinew {
namespace {

using Json = nlohmann::ordered_json;
using Use = JointVerdict::Use;

Json number(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

// Three digits, and no exponent below a million.
std::string text_of(double x) {
  return std::abs(x) >= 100.0 && std::abs(x) < 1e6 ? fmt::format("{:.0f}", x)
                                                   : fmt::format("{:.3g}", x);
}

Json reason_json(const VerdictReason& r) {
  return {{"code", r.code},
          {"weight", r.weight == VerdictReason::Weight::kUnusable ? "unusable" : "remark"},
          {"text", r.text},
          {"figure", number(r.figure)},
          {"limit", number(r.limit)},
          {"unit", r.unit},
          {"source", r.source},
          {"remedy", r.remedy},
          {"angles", r.angles},
          {"torques", r.torques}};
}

// `at most 20 mm` of a reason with a limit.
std::string normal_text(const VerdictReason& r) {
  if (r.limit == 0.0 && r.figure > 0.0) return "none";
  // `% of the frames`, whose first word is enough.
  const std::string unit = r.unit.starts_with('%') ? "%" : r.unit;
  const std::string limit = fmt::format("{}{}{}", text_of(r.limit), unit.empty() ? "" : " ", unit);
  if (unit == "%" && r.limit == 100.0) return limit;
  return (r.figure < r.limit ? "at least " : "at most ") + limit;
}

std::string figure_text(const VerdictReason& r) {
  if (!std::isfinite(r.figure)) return "";
  std::string text = fmt::format(": {}{}{}", text_of(r.figure), r.unit.empty() ? "" : " ", r.unit);
  if (!std::isfinite(r.limit)) return text;
  text += " (normal: " + normal_text(r);
  if (!r.source.empty() && r.source != limits::kOwn) text += ", " + r.source;
  return text + ")";
}

// `more`: how many others of its kind there are.
std::string reason_text(const VerdictReason& r, std::size_t more) {
  return fmt::format("  - {}{}{}{}{}\n", r.text, figure_text(r),
                     more == 0 ? "" : fmt::format(", and {} more like it", more),
                     r.remedy.empty() ? "" : "; ", r.remedy);
}

// The first of each kind, with what helps, and how many follow.
std::vector<std::pair<const VerdictReason*, std::size_t>> kinds_of(
    const std::vector<VerdictReason>& reasons) {
  std::vector<std::pair<const VerdictReason*, std::size_t>> kinds;
  for (const VerdictReason& r : reasons) {
    const auto same = std::find_if(kinds.begin(), kinds.end(), [&](const auto& kind) {
      return kind.first->code == r.code && kind.first->weight == r.weight &&
             kind.first->remedy == r.remedy;
    });
    if (same != kinds.end()) {
      ++same->second;
    } else {
      kinds.push_back({&r, 0});
    }
  }
  return kinds;
}

// `angles: hip_r, knee_r`; empty if none of the joints is used so.
std::string joints_text(const Verdict& verdict, Use JointVerdict::*what, Use use,
                        const char* word) {
  std::vector<std::string> names;
  std::size_t computed = 0;
  for (const JointVerdict& j : verdict.joints) {
    computed += j.*what != Use::kNone ? 1 : 0;
    if (j.*what == use) names.push_back(j.joint);
  }
  if (names.empty()) return "";
  return fmt::format("{} of {}", word, names.size() == computed ? "all joints" : some_names(names));
}

std::string use_text(const Verdict& verdict) {
  const std::string never[] = {
      joints_text(verdict, &JointVerdict::angles, Use::kUnusable, "angles"),
      joints_text(verdict, &JointVerdict::torques, Use::kUnusable, "torques")};
  const std::string partly = joints_text(verdict, &JointVerdict::torques, Use::kPartly, "torques");
  std::string text;
  for (const std::string& part : never) {
    if (!part.empty()) text += (text.empty() ? "  not to be used: " : "; ") + part;
  }
  if (!partly.empty()) {
    text += (text.empty() ? "  to be used" : "; to be used") +
            std::string(" only where all ground forces are known: ") + partly;
  }
  return text.empty() ? text : text + "\n";
}

}  // namespace

const char* const kAcceptHelp =
    "Exit with 0 though the verdict is `not usable`; verdict.json says so all the same";

const char* to_string(Verdict::Level level) {
  static constexpr const char* kNames[] = {"good", "remarks", "unusable"};
  return kNames[static_cast<int>(level)];
}

const char* to_string(JointVerdict::Use use) {
  static constexpr const char* kNames[] = {"none", "usable", "partly", "unusable"};
  return kNames[static_cast<int>(use)];
}

Json verdict_json(const Verdict& verdict) {
  Json reasons = Json::array(), joints = Json::object();
  for (const VerdictReason& r : verdict.reasons) reasons.push_back(reason_json(r));
  for (const JointVerdict& j : verdict.joints) {
    joints[j.joint] = {{"angles", to_string(j.angles)}, {"torques", to_string(j.torques)}};
  }
  return {{"verdict", to_string(verdict.level)}, {"reasons", reasons}, {"joints", joints}};
}

Json root_json(const DynamicsEvidence& d) {
  const double moment = d.peak_load * d.height;
  return {{"frames", d.known > 0 ? d.known : d.frames},
          {"force_rms_n", number(d.root.force_rms)},
          {"force_max_n", number(d.root.force_max)},
          {"moment_rms_nm", number(d.root.moment_rms)},
          {"moment_max_nm", number(d.root.moment_max)},
          {"peak_ground_force_n", number(d.peak_load)},
          {"height_m", number(d.height)},
          {"force_share", number(d.root.force_rms / d.peak_load)},
          {"moment_share", number(d.root.moment_rms / moment)},
          {"force_limit", limits::kResidualForce},
          {"moment_limit", limits::kResidualMoment},
          {"carried_mass_kg", number(d.carried_mass)}};
}

std::string root_text(const DynamicsEvidence& d) {
  if (!d.floating || !d.loads_given || !(d.peak_load > 0.0)) return "";
  const std::string where =
      d.known > 0 && d.known < d.frames
          ? fmt::format(" in the {} of {} frames in which {}", d.known, d.frames,
                        d.by_platforms ? "all loads are known" : "loads carry the body")
          : "";
  return fmt::format(
      "left at the root{}: {} N RMS, {} % of the largest ground force (normal: at most {:.0f} %), "
      "and {} N m RMS, {} % of height times that (normal: at most {:.0f} %)",
      where, text_of(d.root.force_rms), text_of(100.0 * d.root.force_rms / d.peak_load),
      100.0 * limits::kResidualForce, text_of(d.root.moment_rms),
      text_of(100.0 * d.root.moment_rms / (d.peak_load * d.height)),
      100.0 * limits::kResidualMoment);
}

std::string verdict_text(const Verdict& verdict, int lines) {
  static constexpr const char* kWords[] = {"good", "usable with remarks", "not usable"};
  std::string text = fmt::format("verdict: {}\n", kWords[static_cast<int>(verdict.level)]);
  const std::string use = use_text(verdict);
  const auto room = static_cast<std::size_t>(std::max(0, lines - 1 - (use.empty() ? 0 : 1)));
  const auto kinds = kinds_of(verdict.reasons);
  std::size_t shown = std::min(kinds.size(), room);
  if (shown < kinds.size() && shown > 0) --shown;
  for (std::size_t i = 0; i < shown; ++i) text += reason_text(*kinds[i].first, kinds[i].second);
  if (shown < kinds.size() && room > 0) {
    text += fmt::format("  - and {} more: see the verdict's file\n", kinds.size() - shown);
  }
  return text + use;
}

std::filesystem::path verdict_path(const std::filesystem::path& output) {
  return output.parent_path() / (output.stem().string() + "_verdict.json");
}

void write_verdict(const std::filesystem::path& file, const Verdict& verdict) {
  write_file_atomically(
      file, verdict_json(verdict).dump(2, ' ', false, Json::error_handler_t::replace) + "\n");
}

int exit_code(const Verdict& verdict, bool accepted) {
  return verdict.level == Verdict::Level::kUnusable && !accepted ? kExitFailed : kExitOk;
}

}  // namespace sinew
