#pragma once

#include <functional>
#include <span>

#include "ik/frame_solver.h"
#include "ik/tracking.h"

namespace sinew {

/// Goes on from frame `from` of a solved recording, with the solution q of the frame before it (or
/// after it, backward), frame by frame, as long as that ends lower than what the result has by more
/// than 1e-6 of the cost, and writes what it finds. Returns the first frame that it left as it was.
int sweep(FrameSolver& solver, int from, bool backward, std::vector<double> q,
          TrackingResult& result);

/// Searches anew, see ColdStart::look_again(), where a recording's solution is doubtful: where a
/// bound begins to hold against a large gradient, and where the cost jumps between two frames. What
/// is found is followed forward and backward by sweep(). `keep_going` is asked before each search.
void look_again(FrameSolver& solver, const KinematicTree& tree, const TrackingProblem& tracking,
                const std::function<bool()>& keep_going, TrackingResult& result);

/// Coordinates of a solved frame as a tree's q. Quaternion joints, which results do not hold, stay.
void read_solution(const KinematicTree& tree, const TrackingResult& result, int frame,
                   std::span<double> q);

}  // namespace sinew
