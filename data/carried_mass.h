#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "data/force_platform.h"
#include "data/load_coverage.h"

namespace sinew {

/// Mass of who stands on the platforms [kg]: the mean vertical force, y up, that all carry together
/// in the longest stretch of at least 0.5 s in which it stays within 5 % of its middle, over g.
/// Nothing where there is no such stretch or less than 50 N. O(samples).
std::optional<double> standing_mass(const std::vector<ForcePlatformRecording>& plates);

/// Mass of who walks over the platforms [kg]: the mean vertical force, y up, from each strike of a
/// foot to its next one in whose frames all loads are complete, over g. Who walks steadily rises as
/// fast at both; 0.1 m/s less makes 1 %. `time` is the markers' [s]. Nothing without such a stride
/// of 0.4 to 2.5 s. O(contacts² + samples).
struct StrideMass {
  double mass = 0.0;  // [kg]
  int strides = 0;
};
std::optional<StrideMass> stride_mass(const FootAssignment& assignment,
                                      const LoadCoverage& coverage, const Eigen::VectorXd& time,
                                      const std::vector<ForcePlatformRecording>& plates);

}  // namespace sinew
