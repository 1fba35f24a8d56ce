#pragma once

#include <vector>

#include "ik/auto_scale.h"
#include "ik/tracking.h"
#include "model/kinematic_tree.h"

namespace sinew {

/// The frames of one trial that auto_scale() fits.
struct FrameSample {
  MarkerFile file;
  double weight = 0.0;  // w/σ² of every frame [1/m²]
  double poses = 1.0;   // that differ among them: the independent frames
  IkTaskSet tasks;  // its markers, and the posture of what they leave open; empty: markers alone
};

/// Frames of a trial, options.frames at most, evenly spread over its movement rather than over
/// time: how far the distances between its markers have changed, summed from frame to frame. Who
/// stands for a while counts there as often as he moves, and a gait cycle counts more in swing than
/// in stance. What is quicker than people are counts as if it were not: markers that exchange
/// names. Of a trial in which nothing moves beyond the noise frames are evenly spread over time.
/// O(frames · markers).
FrameSample take_frames(const AutoScaleTrial& trial, const AutoScaleOptions& options);

/// A model compiled and bound to all samples.
struct CompiledSamples {
  MusculoskeletalModel model;
  KinematicTree tree;
  std::vector<TrackingProblem> problems;  // samples

  CompiledSamples(MusculoskeletalModel scaled, const std::vector<FrameSample>& samples,
                  bool name_unmatched = false);
};

/// Markers with weight 1, and the joint angles that they do not determine at their defaults, with
/// (marker_sd / posture_sd)²; nothing if they determine all. `sample` indexes compiled.problems.
IkTaskSet posture_tasks(const CompiledSamples& compiled, std::size_t sample,
                        const MarkerTrajectories& markers, const AutoScaleOptions& options);

}  // namespace sinew
