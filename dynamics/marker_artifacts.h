#pragma once

#include <cstdint>

#include "data/marker_trajectories.h"
#include "model/musculoskeletal_model.h"
#include "model/spatial.h"

namespace sinew {

/// What spoils recorded markers. All of it is repeatable: the same seed, the same bytes, on every
/// platform.
struct MarkerArtifacts {
  /// Standard deviation of normal noise on each coordinate of each marker [m]. Some 0.5 mm is what
  /// optical systems have.
  double noise = 0.0;
  /// How far skin carries a marker over its bone, root mean square over markers of the shank [m];
  /// over the thigh twice as far, elsewhere half (after Leardini A et al. (2005) Gait Posture
  /// 21:212-225). It follows the stride, with its first two harmonics.
  double soft_tissue = 0.0;
  /// Part of each marker's samples that is lost, in gaps of 0.1 s; below 1.
  double occlusion = 0.0;
  /// Times that two markers exchange their names for 0.2 s.
  int mislabels = 0;
  std::uint64_t seed = 1;

  /// Throws std::invalid_argument naming field, value and bound.
  void validate() const;
};

/// The place of a marker on its bone while skin moves it, at a phase of the stride. `marker`: index
/// into the model's markers. Returns p_BM [m].
Eigen::Vector3d moved_marker(const MarkerArtifacts& artifacts, const MusculoskeletalModel& model,
                             int marker, double phase);

/// Adds noise, exchanges names and makes gaps; soft tissue is moved_marker()'s part.
void spoil_markers(const MarkerArtifacts& artifacts, MarkerTrajectories& markers);

}  // namespace sinew
