#pragma once

#include <vector>

#include "data/finding.h"
#include "data/marker_trajectories.h"

namespace sinew {

struct UnitCheckOptions {
  // From the feet's markers to those of pelvis, trunk or head [m]: an infant's pelvis stands 0.25 m
  // high, and no head 2.3 m above the feet.
  double least_height = 0.25, largest_height = 2.3;
  // Twice the middle distance of markers from their middle, where names say nothing [m]: a hand is
  // 0.1 m, whole bodies 0.6 to 1.2 m.
  double least_size = 0.04, largest_size = 4.0;

  /// Throws std::invalid_argument naming field, value and bound.
  void validate() const;
};

/// How large what the markers are on is, in metres if the file's unit is right.
struct BodySize {
  double value = 0.0;     // [m]; NaN if nothing is measured
  bool by_names = false;  // from feet to pelvis, trunk or head, else by how far markers scatter
};

/// The middle over at most 200 frames. O(markers) a frame.
BodySize body_size(const MarkerTrajectories& markers);

/// Kind `unit`: a body that is too large or too small to be a person's in the unit that the file
/// names, of `metres_per_unit`, and the unit that makes it one: `--unit mm`. An error.
std::vector<Finding> find_unit_faults(const MarkerTrajectories& markers, double metres_per_unit,
                                      const UnitCheckOptions& options = {});

}  // namespace sinew
