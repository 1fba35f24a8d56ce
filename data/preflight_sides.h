#pragma once

#include <vector>

#include "data/finding.h"
#include "data/laboratory_axes.h"
#include "data/marker_names.h"
#include "data/marker_trajectories.h"

namespace sinew {

struct SideCheckOptions {
  // Left and right of a pair are exchanged if they lie the other way round than the other pairs in
  // at least this part of the frames. Feet that cross do so for less than half of a stride.
  double least_share = 0.8;
  // Pairs closer than this in the mean tell nothing [m].
  double least_width = 0.02;

  /// Throws std::invalid_argument naming field, value and bound.
  void validate() const;
};

/// From the left marker of a pair to the right one, without its part along `up`, and limited to the
/// 0.4 m beyond which width says no more; zero where one of them is not measured [m].
Eigen::Vector3d rightward(const MarkerTrajectories& markers, int frame, const MarkerPair& pair,
                          const Eigen::Vector3d& up);

/// Kind `side`:
///  - a pair whose left and right lie the other way round than those of the other pairs, an error:
///    `--swap LEFT,RIGHT`;
///  - all pairs against where the subject faces: right must be where heel-to-toe × up points, an
///    error: `--swap-sides`. Without heels and toes the way that the subject goes stands for it;
///    that may be backwards, so it is a warning;
///  - a subject that goes where the heels point, a note.
/// Kind `swap`: one foot whose toe lies behind its heel, by where left and right of the other pairs
/// say that forward is, while the other foot's does not, an error: `--swap HEEL,TOE`.
/// Needs axes.up. O(frames · pairs).
std::vector<Finding> find_side_faults(const MarkerTrajectories& markers, const LaboratoryAxes& axes,
                                      const SideCheckOptions& options = {});

}  // namespace sinew
