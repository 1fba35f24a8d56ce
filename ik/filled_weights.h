#pragma once

#include <string>
#include <vector>

#include "data/marker_trajectories.h"
#include "data/numbers.h"
#include "ik/tracking.h"

namespace sinew {

/// What a sample that was filled in weighs beside a measured one if nothing tells how well it was
/// filled, or if it is off by kFilledError. In two published walking trials with gaps cut into them
/// neighbours on the same body are off by 3 to 11 mm over half a second, splines by 2 to 3 mm over
/// 0.1 s and by 8 to 17 mm over 0.2 s.
constexpr double kFilledWeight = 0.1, kFilledError = 0.015;

/// Weights go over from a measured marker's to what it weighs in a gap within this time [s], on the
/// measured side. With a shift δ of the pose between the two, its acceleration is at most
/// 5.8 δ/T²: for a shift of 1 mm 0.14 m/s², a hundredth of a swinging foot's.
constexpr double kWeightTaper = 0.2;

/// A stretch of a marker that was not measured, as frames of the recording, and how far off what
/// was filled in may be [m]; NaN where nothing tells, infinite where nothing was filled in.
struct FilledStretch {
  std::string marker;
  int first = 0, count = 0;
  double error = kNaN;
};

/// The weight of a filled sample beside that of a measured one, 1,
///
///   w(e) = 1/(1 + (1/W − 1)(e/e₀)²),   W = unknown_weight, e₀ = kFilledError.
///
/// Measured samples are off from the model by some σ (soft tissue, palpation), filled ones by e
/// besides, and weights are inverse variances: w = σ²/(σ² + e²). W = 0.1 means σ = 5 mm. W = 1
/// treats filled samples as measured, W = 0 leaves them out. W where e is NaN.
double filled_weight(double error, double unknown_weight = kFilledWeight);

/// Sets marker_scales and filled. With the gaps g of a marker, the level w_g of each, 0 where
/// nothing was filled in, and the time τ_g(f) from frame f to the nearest frame of g,
///
///   scale(f) = Π_g [1 − (1 − w_g) b(τ_g(f)/T)],   b(x) = 1 − 10x³ + 15x⁴ − 6x⁵ for x < 1, else 0,
///
/// T = kWeightTaper, so that weight, and with it the pose, has no step where a gap begins or ends.
/// A frame in which all markers of a recording run out at once is scaled back to a largest scale of
/// 1, as only ratios of weights count. Throws std::invalid_argument for frames that the recording
/// does not have and unless 0 <= unknown_weight <= 1. O(frames · markers).
void weigh_filled_samples(TrackingProblem& tracking, const MarkerTrajectories& markers,
                          const std::vector<FilledStretch>& stretches,
                          double unknown_weight = kFilledWeight);

}  // namespace sinew
