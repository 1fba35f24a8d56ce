#pragma once

#include <string>

#include "ik/tracking.h"

namespace sinew {

/// What --trace writes: a row for every iteration of every frame, with the cost after it, the
/// gradient's largest entry, the accepted length α and the step's Euclidean norm. Frames count from
/// 1, as the recording's rows do; `first_frame`: index of the first one solved. Needs
/// MinimizerOptions::record_iterations.
std::string trace_csv(const TrackingResult& result, int first_frame);

}  // namespace sinew
