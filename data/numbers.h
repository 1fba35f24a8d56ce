#pragma once

#include <limits>

namespace sinew {

/// What was not measured, or nothing tells.
inline constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// The force on a platform below which nothing stands on it, unless somebody says otherwise [N]:
/// below it noise of 2 N would move a centre of pressure by a tenth of the platform.
inline constexpr double kContactForce = 20.0;

}  // namespace sinew
