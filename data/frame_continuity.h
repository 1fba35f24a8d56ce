#pragma once

#include <vector>

#include "data/marker_trajectories.h"
#include "data/verdict_reason.h"

namespace sinew {

/// What is wrong with the course of a recording's frames, as cameras or exports leave them:
/// - `frozen-frames`, not usable: three or more frames in a row in which every marker that is
///   measured stands exactly where it stood before, in a trial most of whose frames move;
/// - `time-hole`: the time between two frames is more than 2.5 times the usual one, so that
///   velocities and accelerations there are another motion's.
/// O(frames · markers).
std::vector<VerdictReason> frame_reasons(const MarkerTrajectories& markers);

}  // namespace sinew
