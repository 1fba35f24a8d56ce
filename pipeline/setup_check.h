#pragma once

#include <string>
#include <vector>

#include "data/finding.h"

namespace sinew {

/// What a setup of IK or ID, external loads or IK tasks says that cannot be done: files that are
/// not there or are another system's, and tasks without any weight. Kind `setup`, errors first.
/// Throws InputError as the readers do (columns of loads that no data have, times that end before
/// they begin), and for XML that is none of these.
std::vector<Finding> check_setup(const std::string& path);

}  // namespace sinew
