#pragma once

#include <optional>
#include <vector>

#include "data/force_platform.h"

namespace sinew {

/// Mass of who stands on the platforms [kg]: the mean vertical force, y up, that all carry together
/// in the longest stretch of at least 0.5 s in which it stays within 5 % of its middle, over g.
/// Nothing where there is no such stretch or less than 50 N. O(samples).
std::optional<double> standing_mass(const std::vector<ForcePlatformRecording>& plates);

}  // namespace sinew
