#pragma once

#include <optional>
#include <vector>

#include "ik/cold_start.h"
#include "ik/tracking.h"
#include "ik/warm_start.h"

namespace sinew {

/// One worker's solver of single frames, with all that it needs for one. Frames are numbered from
/// TrackingOptions::first_frame. Keeps references to what it is given.
class FrameSolver {
 public:
  FrameSolver(const KinematicTree& tree, const TrackingProblem& tracking,
              const MarkerTrajectories& markers, const TrackingOptions& options);

  /// The next frame is not the one after the last.
  void begin_anew() { warm_start_.reset(); }

  /// From the solution of the frame before, q, to the frame's. The Summary stays valid until the
  /// next call.
  const Summary& solve(int frame, std::vector<double>& q);

  /// From q and from elsewhere to the lowest minimum found; see ColdStart. Allocates.
  const Summary& solve_cold(int frame, std::vector<double>& q);

  /// Searches for a minimum below `cost`, the frame's at q; nothing if none was found.
  const Summary* look_again(int frame, std::vector<double>& q, double cost);

  /// Of the last cold solve.
  const ColdStartResult& search() const { return cold_->result(); }

  /// Writes the last solution to the frame's row of the result.
  void store(int frame, const Summary& summary, const std::vector<double>& q,
             TrackingResult& result);

 private:
  void ask(int frame, std::vector<double>& q);
  ColdStart& cold();

  const KinematicTree& tree_;
  const TrackingProblem& tracking_;
  const MarkerTrajectories& markers_;
  const TrackingOptions& options_;
  Minimizer minimizer_;
  std::optional<ColdStart> cold_;         // made when first needed
  KinematicWorkspace* solved_ = nullptr;  // kinematics of the last solution
  IkTargets targets_;
  WarmStart warm_start_;
};

/// An empty result for so many frames.
TrackingResult empty_result(const MusculoskeletalModel& model, const TrackingProblem& tracking,
                            const MarkerTrajectories& markers, int first, int frames);

/// Distances of tracked markers at the poses of `ws`, their summary, and the wires, into the row of
/// `frame`; `frame_index` is the recording's.
void measure_frame(const TrackingProblem& tracking, const IkTargets& targets,
                   const KinematicWorkspace& ws, int frame_index, int frame,
                   TrackingResult& result);

}  // namespace sinew
