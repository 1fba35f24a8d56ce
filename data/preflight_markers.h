#pragma once

#include <string>
#include <vector>

#include "data/finding.h"
#include "data/marker_trajectories.h"

namespace sinew {

struct MarkerCheckOptions {
  // A marker is static if it stays within this [m]: noise of 1 mm spans 6 mm, skin and breath more.
  double still = 0.01;
  // ... in frames in which the middle one of the others moves by at least this [m].
  double moving = 0.3;
  // A recording held in place: at least this long at exactly one place [s].
  double held = 0.2;
  // Gaps up to the first are a spline's to fill, up to the second those of markers that move with
  // it; longer ones are stretches without the marker [s].
  double short_gap = 0.1, long_gap = 0.5;
  // Two markers that stay this close are one [m]: no marker is smaller.
  double coincident = 1e-3;
  // Farther from the middle of the others for half of the time, it is on no person [m].
  double stray = 3.0;
  // Of the mean step, by which single steps of time may differ.
  double step_tolerance = 0.1;
  // Below this a heel strike is not resolved [Hz].
  double least_rate = 50.0;

  /// Throws std::invalid_argument naming the field that is not above 0, and gaps that do not rise.
  void validate() const;
};

/// Kind `static`: a marker that stays in its place while the others move, or that is held at
/// exactly one place for a while. `--drop NAME`, `--drop NAME@FROM-TO`. Frames in which fewer than
/// three others are measured tell nothing. O(frames · markers).
std::vector<Finding> find_static_markers(const MarkerTrajectories& markers,
                                         const MarkerCheckOptions& options = {});

/// Kind `missing`: markers that are never measured. `--drop`.
std::vector<Finding> find_missing_markers(const MarkerTrajectories& markers);

/// Kind `duplicate`: labels that the file gives more than once (`labels`, in the file's order,
/// where the recording has made them unique), and markers of different names in one place.
/// `--drop` of the one that is measured less. O(frames · markers + markers²).
std::vector<Finding> find_duplicate_markers(const MarkerTrajectories& markers,
                                            const std::vector<std::string>& labels,
                                            const MarkerCheckOptions& options = {});

/// Kind `stray`: markers that are nowhere near the others. `--drop`.
std::vector<Finding> find_stray_markers(const MarkerTrajectories& markers,
                                        const MarkerCheckOptions& options = {});

}  // namespace sinew
