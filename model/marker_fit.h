#pragma once

#include <string>
#include <vector>

#include "data/finding.h"
#include "data/marker_trajectories.h"
#include "model/musculoskeletal_model.h"

namespace sinew {

struct MarkerFitOptions {
  // Sizes that differ by less are the same body's: markers are placed to a centimetre, on segments
  // of 0.2 to 0.5 m, and several agree to a few per cent.
  double size_tolerance = 0.05;
  // Pairs of markers closer than this on a body tell little of its size [m].
  double least_distance = 0.05;
  // By which distances may be off between markers that keep to the model [m]: soft tissue.
  double misplaced = 0.04;

  /// Throws std::invalid_argument naming the field that is not above 0.
  void validate() const;
};

/// Two markers that sit on one body of the model and were recorded together.
struct MarkerDistance {
  int body = 0;           // of the model
  int a = 0, b = 0;       // indices into the recording
  double model = 0.0;     // distance in the model [m]
  double recorded = 0.0;  // middle one of all frames [m]
};

/// Of all pairs by exact names, at most 200 frames each. O(frames · pairs).
std::vector<MarkerDistance> marker_distances(const MarkerTrajectories& markers,
                                             const MusculoskeletalModel& model,
                                             const MarkerFitOptions& options = {});

/// Kind `match`: markers of the recording that the model has not, with `--rename` where one of the
/// model's has nearly the same name (other case, separators, a subject's name before a colon), and
/// markers of the model that were not recorded. Fewer than three common names are an error.
std::vector<Finding> find_unmatched_markers(const MarkerTrajectories& markers,
                                            const MusculoskeletalModel& model);

/// Kind `size`: a model whose segments are larger or smaller than the markers say, by the middle
/// ratio of distances over all bodies, and the bodies that are off by themselves. Kind `place`: two
/// markers of one body that fit it better under each other's names (`--swap`), and markers whose
/// distances to all others on their body are off.
std::vector<Finding> find_size_faults(const MarkerTrajectories& markers,
                                      const MusculoskeletalModel& model,
                                      const MarkerFitOptions& options = {});

}  // namespace sinew
