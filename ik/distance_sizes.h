#pragma once

#include <Eigen/Core>
#include <vector>

#include "ik/auto_scale_parameters.h"
#include "ik/auto_scale_samples.h"

namespace sinew {

/// Sizes that distances between markers tell before any pose is known: θ of auto_scale(), its
/// offsets zero, within the limits.
///
/// For each pair of markers, y is the logarithm of its distance in the recordings (the middle of
/// the frames) less that in the model, the mean over 24 poses drawn from the ranges of the joints,
/// and J how y depends on the factors there. Of a pair on one body neither depends on the pose; of
/// others the spread over the poses adds to what misplaced markers make of it:
///
///     s² = 20 var(y over the poses) + 2 (marker_offset_sd / distance)²
///
/// twenty because all pairs across one joint err together. The answer is the minimum of
/// Σ w (y − J θ)²/s² + θᵀ P⁻¹ θ with the priors of auto_scale(), solved three times with Huber's
/// weights w, so that a marker that is not what its name says has little to say, and with Σ w
/// scaled as if there were three pairs a marker: more are not independent. Deterministic; zero if
/// no distance is measured. O(poses · factors · (bodies + pairs)), with 4000 pairs at most.
Eigen::VectorXd sizes_from_distances(const MusculoskeletalModel& model,
                                     const AutoScaleParameters& parameters,
                                     const std::vector<FrameSample>& samples,
                                     const AutoScaleOptions& options);

}  // namespace sinew
