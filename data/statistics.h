#pragma once

#include <vector>

namespace sinew {

/// The middle of the values, the upper one of two; NaN if there is none. O(n).
double median(std::vector<double> values);

}  // namespace sinew
