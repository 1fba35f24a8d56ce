#pragma once

#include <string>
#include <vector>

#include "data/finding.h"
#include "data/laboratory_axes.h"
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
  // False where they do not change back: that may be before the jump or from it on, and frames up
  // to the nearer end of the record are given.
  bool undone = true;

  bool operator==(const MarkerSwap&) const = default;
};

/// Follows every marker from frame to frame by its last two samples, and exchanges two where both
/// jump to where the other was about to be. O(frames · markers) and the square of those that jump
/// at once.
std::vector<MarkerSwap> find_marker_swaps(const MarkerTrajectories& markers,
                                          const SwapCheckOptions& options = {});

/// Kind `swap`, an error of confidence 0.95: two markers that bear each other's names in the whole
/// record, mended by `--swap A,B`. `why`: what tells it, a sentence's beginning.
Finding whole_exchange(const std::string& a, const std::string& b, const std::string& why);

/// Kind `swap`, errors: `--swap A,B@FROM-TO`. Of an exchange that is not undone the names tell
/// which part is wrong: left and right must lie as the other pairs do, heads above trunks, pelvis,
/// legs and feet. Where they tell nothing it is the shorter part if that is less than a quarter of
/// the record; else the finding has no flags, and its advice names both. Needs axes.up to use
/// names.
std::vector<Finding> find_swap_faults(const MarkerTrajectories& markers,
                                      const LaboratoryAxes& axes = {},
                                      const SwapCheckOptions& options = {});

}  // namespace sinew
