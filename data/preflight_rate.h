#pragma once

#include <vector>

#include "data/finding.h"
#include "data/preflight_markers.h"

namespace sinew {

/// Kind `rate`: steps of time that differ, missing frames, a rate that the times contradict or that
/// is low; kind `first frame`: numbers that do not begin at 1.
std::vector<Finding> find_timing_faults(const MarkerTrajectories& markers,
                                        const MarkerCheckOptions& options = {});

}  // namespace sinew
