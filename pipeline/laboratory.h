#pragma once

#include <string>
#include <vector>

#include "data/c3d_file.h"
#include "data/force_platform.h"
#include "data/laboratory_axes.h"
#include "pipeline/prepare_options.h"

namespace sinew {

/// Which way a recording is turned before it is used, and why.
struct Turn {
  bool rotates = false;
  Eigen::Matrix3d R_MW = Eigen::Matrix3d::Identity();
  LaboratoryAxes axes;  // unknown where `--up keep` asked nothing
};

/// What a recording tells about its axes; `markers` must outlive it.
AxisEvidence axis_evidence(const MarkerTrajectories& markers,
                           const std::optional<C3dScreen>& screen,
                           const std::vector<ForcePlatformRecording>& plates);

/// `up is z (forces …, 98 % sure), forward is -y (…)`, of axes that are known.
std::string describe_axes(const LaboratoryAxes& axes);

/// The rotation to y up and x forward that the options and the recording ask for. Prints
/// contradictions as warnings. Throws InputError, naming --up, if nothing tells what is up.
Turn find_turn(const MarkerTrajectories& markers, const std::string& path,
               const std::optional<C3dScreen>& screen,
               const std::vector<ForcePlatformRecording>& plates, const PrepareOptions& options,
               std::vector<Warning>& warnings);

/// One line: `up is z (forces …, 98 % sure), forward is -y (…); rotated to y up, x forward`.
std::string describe(const Turn& turn);

/// Rotates markers, platforms and the parameters that give places or directions: CORNERS,
/// X_SCREEN and Y_SCREEN. Computed trajectories stay as they are.
void rotate(C3dFile& file, const Eigen::Matrix3d& R_MW);

}  // namespace sinew
