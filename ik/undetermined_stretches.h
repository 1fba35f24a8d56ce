#pragma once

#include <vector>

#include "ik/tracking.h"

namespace sinew {

/// Frames in which the markers that are seen leave coordinates undetermined that the markers of the
/// whole recording determine, or in which none is seen on a segment that has some: then those of
/// the joints at its ends (coordinates_beside()).
struct UndeterminedStretch {
  int first = 0, count = 0;      // frames of the recording
  std::vector<int> coordinates;  // indices into the model's, ascending
  int measured_markers = 0;      // tracked ones with a weight, the fewest of a frame

  bool operator==(const UndeterminedStretch&) const = default;
};

/// Stretches of neighbouring frames that leave the same coordinates undetermined, of frames
/// `first_frame` on for which `solved` has poses. A marker that is not measured or weighs nothing
/// does not count. Whether a frame's pose is determined depends on how many markers each body has,
/// up to three; each such case is looked at in its first frame (undetermined_coordinates()).
/// O(frames · markers + cases · unknowns³).
std::vector<UndeterminedStretch> find_undetermined_stretches(
    const MusculoskeletalModel& model, const KinematicTree& tree, const TrackingProblem& tracking,
    const MarkerTrajectories& markers, int first_frame, const RowMatrix& solved);

/// How strongly track() draws a coordinate to its course over a stretch that leaves it
/// undetermined, beside a marker's weight of 1 [1/rad² or 1/m² over 1/m²]: a marker that turns with
/// it 0.3 m from its axis overrules it to a hundredth.
constexpr double kBridgeWeight = 1e-3;

/// The tracking with a task for every coordinate of the stretches: it goes from its value in the
/// frame before the stretch to that in the frame behind by the cubic of the slopes there, limited
/// so that it does not leave the values between the two (Fritsch & Carlson 1980, SIAM J Numer Anal
/// 17:238-246), and stays where it was where only one of them is known. So nothing is carried on
/// beyond what is known, and neighbouring frames have no step to differentiate. Outside of its
/// stretches a coordinate is free as before.
TrackingProblem bridge_stretches(const MusculoskeletalModel& model, const KinematicTree& tree,
                                 const TrackingProblem& tracking,
                                 const std::vector<UndeterminedStretch>& stretches,
                                 int recorded_frames, int first_frame, const RowMatrix& solved);

}  // namespace sinew
