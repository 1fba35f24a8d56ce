#pragma once

#include <string>
#include <vector>

#include "pipeline/decisions.h"
#include "pipeline/lab_trial.h"

namespace sinew {

/// Reads a laboratory's trial, settles its unit, what else the options put right in it, its spikes
/// and its axes: `trial` names decisions, empty for the walk and `static ` for the static trial, of
/// which only unit, spikes and axes are settled. `walk`: markers [m] that tell a static trial's
/// unit by their distances; null for the walk itself. A TRC file is a trial without platforms.
/// Throws InputError as read_c3d, read_trc and find_turn do, for a file without markers or with all
/// of them in one place, and for distances that no unit makes the walk's; std::invalid_argument as
/// edit_recording().
LabTrial read_lab_recording(const std::string& path, const std::string& trial, double threshold,
                            const MarkerTrajectories* walk, DecisionLog& log,
                            std::vector<Warning>& warnings);

}  // namespace sinew
