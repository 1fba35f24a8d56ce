#pragma once

#include <Eigen/Core>
#include <vector>

#include "data/c3d_file.h"
#include "data/reference_walk.h"
#include "data/time_table.h"

namespace sinew {

/// One stance of a foot of the reference walk and where it steps.
struct ReferenceStep {
  int foot = 0;          // index into ReferenceWalk::feet
  double strike = 0.0;   // [s]; may lie before the recording's beginning
  double toe_off = 0.0;  // [s]; may lie behind its end
  Eigen::Vector3d p_MC;  // middle of the footprint's extent along x and z, on the floor,
                         // in the walk's axes M: x forward, y up, z to the right [m]
};

/// The steps whose stance reaches into 0 s to `duration`, by the time of strike.
std::vector<ReferenceStep> steps_of(const ReferenceWalk& walk, double duration);

/// How many force platforms one file may describe: what a dimension of a parameter counts to.
inline constexpr int kMaxPlatforms = 255;

/// The walk as a laboratory's C3D file has it, for write_c3d:
///  - axes W of a laboratory, x to the right, y forward, z up: p_W = (p_M.z, p_M.x, p_M.y), from
///    the same origin; lengths in mm, moments in N mm; POINT:X_SCREEN and Y_SCREEN say the axes;
///  - a force platform of type 2 of 508 mm along the walk by 464 mm under each step, x forward, y
///    to the right, z down, its transducers' origin 38 mm under the surface; six channels each,
///    Fx1, Fy1, Fz1, Mx1, My1, Mz1, ..., which hold the floor's reaction on the foot:
///      M_O = (p_WQ - p_WO) × F + T,  Q the centre of pressure, T the free moment;
///  - events "Foot Strike" and "Foot Off", context "Right" or "Left", which lie in the recording.
/// `forces`: columns of ReferenceRecording::forces, nine a foot, at a whole multiple of the
/// markers' rate, at least as many rows as the frames have samples. Throws std::invalid_argument if
/// they are not, or for more than kMaxPlatforms steps. O(samples · platforms).
C3dFile reference_laboratory(const ReferenceWalk& walk, const MarkerTrajectories& markers,
                             const TimeTable& forces);

/// A static trial in the same laboratory: markers only.
C3dFile reference_laboratory(const MarkerTrajectories& markers);

}  // namespace sinew
