#pragma once

#include <string>
#include <vector>

#include "data/foot_assignment.h"

namespace sinew {

/// What a foot's loads are known to be in one frame.
enum class FootLoad {
  kMeasured,    // a platform carries it, and that is assigned to it
  kNone,        // it is in the air, or above a platform that carries nothing
  kUnmeasured,  // it stands where no platform measures, or rests on one that does not
  kUnusable,    // it stands on a platform whose force was not assigned to it
  kUnknown      // the foot is not measured itself
};
const char* to_string(FootLoad load);

/// Whether inverse dynamics knows all that acts on a foot; torques of the leg above it, and of
/// whatever hangs on both, are worth nothing where it does not.
inline bool is_complete(FootLoad load) {
  return load == FootLoad::kMeasured || load == FootLoad::kNone;
}

/// By frame of the markers and foot of the assignment. A foot stands as in data/foot_motion.h: in
/// contact with the ground or just off it, so that a step beside the platforms is left a few frames
/// late. O(frames · (contacts + platforms)).
struct LoadCoverage {
  std::vector<std::string> feet;
  std::vector<std::vector<FootLoad>> loads;  // by frame, then foot

  bool complete(std::size_t frame) const;  // of all feet
  int complete_frames(std::size_t foot) const;
};
LoadCoverage load_coverage(const MarkerTrajectories& markers, const FootAssignment& assignment,
                           const std::vector<ForcePlatformRecording>& plates);

/// Stretches of a foot's frames first … end − 1 with complete loads, `0.42 s to 1.05 s, ...`, for
/// people; `none` where there is none.
std::string complete_times(const LoadCoverage& coverage, std::size_t foot,
                           const Eigen::VectorXd& time);

}  // namespace sinew
