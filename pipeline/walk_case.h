#pragma once

#include <vector>

#include "dynamics/marker_artifacts.h"
#include "ik/tracking.h"
#include "model/whole_body.h"

namespace sinew {

/// Evaluation 2 of Ayusawa & Nakamura 2012 on our own body and walk: the whole body in one of its
/// levels, its wires as eq. (38) has them, and the embedded walk of two strides at 100 Hz. Tasks
/// are those of `sinew example`.
struct WalkCase {
  MusculoskeletalModel model;
  KinematicTree tree;
  MarkerFile recording;
  TrackingProblem tracking;
};
WalkCase make_walk_case(WholeBodyOptions::Level level, const MarkerArtifacts& artifacts);

/// Frames that the paper solved: every 0.2 s, the first ten.
std::vector<int> paper_frames(const WalkCase& walk);

}  // namespace sinew
