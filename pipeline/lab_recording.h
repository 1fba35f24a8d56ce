#pragma once

#include <string>
#include <vector>

#include "pipeline/decisions.h"
#include "pipeline/lab_options.h"
#include "pipeline/lab_trial.h"

namespace sinew {

/// Reads a laboratory's trial and settles its unit and axes: `trial` names decisions, empty for
/// the walk and `static ` for the static trial. A TRC file is a trial without platforms. Throws
/// InputError as read_c3d, read_trc and find_turn do, and for a file without markers.
LabTrial read_lab_recording(const std::string& path, const std::string& trial,
                            const LabOptions& options, double threshold, DecisionLog& log,
                            std::vector<Warning>& warnings);

/// Settles whose markers are which of the model's, and gives them its names; what is not used or
/// not recorded is reported. Throws InputError if fewer than six match, or all of a model that has
/// fewer: what two bodies need.
MarkerTrajectories name_lab_markers(const LabTrial& recording, const std::string& trial,
                                    const std::vector<std::string>& model_names,
                                    const LabOptions& options, DecisionLog& log,
                                    std::vector<Warning>& warnings);

}  // namespace sinew
