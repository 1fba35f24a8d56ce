#pragma once

#include <vector>

#include "data/finding.h"
#include "data/laboratory_axes.h"
#include "data/marker_trajectories.h"

namespace sinew {

/// Kind `swap`, an error: two markers of one leg of which the lower by its name (pelvis, thigh,
/// knee, shank, ankle or foot) lies above the other in most frames, which no order of the leg's
/// markers but the exchange of these two explains, and not so on the other leg, as in somebody who
/// kneels: `--swap A,B`. Needs axes.up. O(frames · pairs of markers of a leg).
std::vector<Finding> find_order_faults(const MarkerTrajectories& markers,
                                       const LaboratoryAxes& axes);

}  // namespace sinew
