#pragma once

#include <vector>

#include "data/finding.h"
#include "data/marker_trajectories.h"

namespace sinew {

struct SwapCheckOptions {
  // A marker jumps where it lands farther than this from where its last two samples send it [m].
  // Impacts of 100 m/s² move a marker 10 mm off within 10 ms.
  double least_jump = 0.02;
  // ... and farther than this times what it usually is off.
  double times_usual = 8.0;
  // Two markers have exchanged names if exchanging them back leaves at most this part of both
  // jumps.
  double most_left = 0.25;
  // Longest gap over which markers are followed [s]: beyond it, a foot may have gone anywhere.
  double longest_gap = 0.06;

  /// Throws std::invalid_argument naming field, value and bound.
  void validate() const;
};

/// Frames first … last in which two markers bear each other's names.
struct MarkerSwap {
  int a = 0, b = 0;  // indices of markers, a < b
  int first = 0, last = 0;
  double jump = 0.0;  // mean distance that the two jump [m]
  double left = 0.0;  // part of it that is left when they are exchanged

  bool operator==(const MarkerSwap&) const = default;
};

/// Follows every marker from frame to frame by its last two samples, and exchanges two where both
/// jump to where the other was about to be. An exchange that is not undone goes to the nearer end
/// of the record. O(frames · markers) and the square of those that jump at once.
std::vector<MarkerSwap> find_marker_swaps(const MarkerTrajectories& markers,
                                          const SwapCheckOptions& options = {});

/// Kind `swap`, errors: `--swap A,B@FROM-TO`.
std::vector<Finding> find_swap_faults(const MarkerTrajectories& markers,
                                      const SwapCheckOptions& options = {});

}  // namespace sinew
