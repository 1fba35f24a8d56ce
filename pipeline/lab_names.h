#pragma once

#include <string>
#include <vector>

#include "pipeline/decisions.h"
#include "pipeline/lab_options.h"
#include "pipeline/lab_trial.h"

namespace sinew {

/// Settles whose markers are which of the model's, and gives them its names; what is not used or
/// not recorded is reported. `trial` names decisions as in read_lab_recording(). Throws InputError
/// if fewer than six match, or all of a model that has fewer: what two bodies need.
MarkerTrajectories name_lab_markers(const LabTrial& recording, const std::string& trial,
                                    const std::vector<std::string>& model_names,
                                    const LabOptions& options, DecisionLog& log,
                                    std::vector<Warning>& warnings);

}  // namespace sinew
