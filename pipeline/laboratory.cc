#include "pipeline/laboratory.h"

#include <fmt/format.h>

#include <cmath>

#include "pipeline/command.h"

namespace sinew {
namespace {

// The sum of forces on the subject over all plates [N].
Eigen::Vector3d total_reaction(const std::vector<ForcePlatformRecording>& plates) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double loaded = 0.0;
  for (const ForcePlatformRecording& plate : plates) {
    for (Eigen::Index i = 0; i < plate.force.rows(); ++i) {
      const Eigen::Vector3d force = plate.force.row(i);
      // Less than a child's weight may be noise or an offset.
      if (!force.allFinite() || force.norm() < 100.0) continue;
      sum += force;
      loaded += 1.0;
    }
  }
  return loaded > 0.0 ? Eigen::Vector3d(sum / loaded) : Eigen::Vector3d::Zero();
}

std::string text_of(const AxisDecision& decision) {
  if (decision.confidence <= 0.0) {
    return fmt::format("{} ({})", axis_name(decision.axis), decision.reason);
  }
  return fmt::format("{} ({}, {:.0f} % sure)", axis_name(decision.axis), decision.reason,
                     100.0 * decision.confidence);
}

}  // namespace

AxisEvidence axis_evidence(const MarkerTrajectories& markers,
                           const std::optional<C3dScreen>& screen,
                           const std::vector<ForcePlatformRecording>& plates) {
  AxisEvidence evidence;
  evidence.markers = &markers;
  evidence.screen = screen;
  evidence.reaction = total_reaction(plates);
  return evidence;
}

std::string describe_axes(const LaboratoryAxes& axes) {
  return fmt::format("up is {}, forward is {}", text_of(axes.up), text_of(axes.forward));
}

Turn find_turn(const MarkerTrajectories& markers, const std::string& path,
               const std::optional<C3dScreen>& screen,
               const std::vector<ForcePlatformRecording>& plates, const PrepareOptions& options,
               std::vector<Warning>& warnings) {
  Turn turn;
  if (options.up == "keep") return turn;
  AxisEvidence evidence = axis_evidence(markers, screen, plates);
  evidence.up = options.up_axis();
  evidence.forward = options.forward_axis();
  turn.axes = find_axes(evidence);
  if (!turn.axes.up.known()) {
    throw InputError({path}, {"nothing tells which axis points up", "", "",
                              "Say it with --up z (or x, y, -x, -y, -z), or --up keep to rotate "
                              "nothing."});
  }
  for (const std::string& sentence : turn.axes.contradictions) {
    report(warnings, {{{path}, sentence + "; --up and --forward settle it"}});
  }
  // Below this it is a guess: extents of markers, or names and screen against each other.
  constexpr double kGuess = 0.5;
  if (turn.axes.up.confidence < kGuess) {
    report(warnings, {{{path},
                       fmt::format("that {} points up is a guess; --up settles it",
                                   axis_name(turn.axes.up.axis))}});
  }
  turn.R_MW = turn.axes.rotation();
  turn.rotates = !turn.R_MW.isIdentity();
  return turn;
}

std::string describe(const Turn& turn) {
  if (!turn.axes.up.known()) return "not rotated (--up keep)";
  return fmt::format("{}; {}", describe_axes(turn.axes),
                     turn.rotates ? "rotated to y up, x forward" : "that is how it stays");
}

void rotate(C3dFile& file, const Eigen::Matrix3d& R_MW) {
  rotate_vectors(R_MW, file.markers.p_WM);
  if (const C3dParameter* corners = find_parameter(file.groups, "FORCE_PLATFORM", "CORNERS")) {
    std::vector<float> values;
    for (const double value : corners->numbers()) values.push_back(static_cast<float>(value));
    const std::size_t stride =
        corners->dimensions.empty() ? 3 : static_cast<std::size_t>(corners->dimensions[0]);
    for (std::size_t i = 0; stride >= 3 && i + 3 <= values.size(); i += stride) {
      Eigen::Map<Eigen::Vector3f> corner(&values[i]);
      corner = (R_MW * corner.cast<double>()).cast<float>().eval();
    }
    set_parameter(file.groups, "FORCE_PLATFORM",
                  C3dParameter::of_reals("CORNERS", corners->dimensions, std::move(values)));
  }
  file.screen = C3dScreen{Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitY()};
  set_parameter(file.groups, "POINT", C3dParameter::of_text("X_SCREEN", "+X"));
  set_parameter(file.groups, "POINT", C3dParameter::of_text("Y_SCREEN", "+Y"));
}

}  // namespace sinew
