#pragma once

#include <vector>

#include "data/finding.h"
#include "data/gap_filling.h"
#include "data/preflight_markers.h"

namespace sinew {

/// Gaps between two measured samples of a marker, longest first: what may be filled.
std::vector<MarkerGap> find_inner_gaps(const MarkerTrajectories& markers);

/// Kind `gap`: one finding for each class of length: `--max-gap`, `--fill-rigid`, or none.
std::vector<Finding> find_gap_faults(const MarkerTrajectories& markers,
                                     const MarkerCheckOptions& options = {});

}  // namespace sinew
