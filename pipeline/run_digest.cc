#include "pipeline/run_digest.h"

#include <fmt/format.h>

#include <algorithm>

#include "pipeline/id_options.h"
#include "pipeline/verdict_limits.h"
#include "pipeline/verdict_report.h"

namespace sinew {
namespace {

std::string kinematics_line(const nlohmann::ordered_json& summary) {
  const auto& kinematics = summary["inverse_kinematics"];
  std::string line =
      fmt::format("inverse kinematics: {} frames, {:.3g} ms a frame",
                  kinematics["frames"].get<int>(), kinematics["ms_per_frame"].get<double>());
  if (kinematics["marker_rms_m"].is_number()) {
    line += fmt::format(", marker RMS {:.2f} mm (normal: at most {:.0f} mm)",
                        1e3 * kinematics["marker_rms_m"].get<double>(), 1e3 * limits::kMarkerRms);
  }
  if (kinematics.contains("worst_marker")) {
    line += fmt::format(", worst marker {} ({:.1f} mm)",
                        kinematics["worst_marker"]["name"].get<std::string>(),
                        1e3 * kinematics["worst_marker"]["rms_m"].get<double>());
  }
  return line + "\n";
}

std::string wires_line(const nlohmann::ordered_json& summary) {
  if (!summary.contains("wires")) return "";
  const auto& wires = summary["wires"];
  std::string line = fmt::format("wires: {}, of which {} become taut", wires["wires"].get<int>(),
                                 wires["ever_taut"].get<int>());
  if (wires.contains("most_strained")) {
    line += fmt::format("; the most strained by {:.2g} %: {}",
                        100.0 * wires["most_strained"]["strain"].get<double>(),
                        wires["most_strained"]["wire"].get<std::string>());
  }
  return line + "\n";
}

std::string dynamics_lines(const RunDigest& digest) {
  const DynamicsEvidence& dynamics = *digest.evidence.dynamics;
  const std::string root = root_text(dynamics);
  std::string lines = fmt::format("inverse dynamics: coordinates {}{}{}\n",
                                  filter_text(digest.cutoff), root.empty() ? "" : "; ", root);
  for (const FootEvidence& foot : dynamics.feet) {
    lines += fmt::format("loads of the {} foot are known in {} of {} frames: {}\n", foot.name,
                         foot.complete, dynamics.frames, foot.times);
  }
  return lines;
}

}  // namespace

std::string run_digest(const RunDigest& digest) {
  const std::string before =
      kinematics_line(digest.summary) + wires_line(digest.summary) + dynamics_lines(digest);
  const auto used = static_cast<int>(std::count(before.begin(), before.end(), '\n'));
  return before + verdict_text(digest.verdict, kMostLines - used - 1) +
         fmt::format("results: {}/ik.mot, id.sto, summary.json, verdict.json, ...\n",
                     digest.folder.string());
}

}  // namespace sinew
