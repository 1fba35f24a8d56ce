#pragma once

#include <string>
#include <vector>

#include "data/marker_trajectories.h"

namespace sinew {

/// Why each trajectory of a recording is no marker on somebody's skin, or an empty text: what a
/// program computed from markers (joint centres, axes of segments, midpoints), a second name of a
/// marker, or a trajectory that nobody named. Told by the name, as Plug-in Gait (PELO, PELA, PELL,
/// PELP), OrthoTrak (VRHI) and others write it, and by what no skin does: keeping a distance to
/// another point to 0.02 mm, or lying between two others to 0.05 mm. The latter two only hold in
/// recordings whose markers have noise. O(markers² · frames) of up to 100 frames.
std::vector<std::string> why_no_marker(const MarkerTrajectories& markers);

}  // namespace sinew
