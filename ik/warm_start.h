#pragma once

#include <vector>

#include "ik/residuals.h"
#include "model/kinematic_tree.h"

namespace sinew {

/// Where a frame starts: where the solutions of the two before it lead to if the body goes on as it
/// went, q + (q − q_before), if that leaves less than a tenth of the cost at the last solution, or
/// else there. Quaternions stay. Allocates at construction only.
class WarmStart {
 public:
  explicit WarmStart(const KinematicTree& tree);

  /// Forgets the frames so far.
  void reset() { known_ = false; }

  /// `q`: the solution of the last frame, or any start after reset(); becomes the start of the next
  /// frame, which asks for `targets`.
  void advance(const KinematicTree& tree, const IkProblem& problem, const IkTargets& targets,
               std::vector<double>& q);

 private:
  KinematicWorkspace workspace_;
  std::vector<double> before_;
  bool known_ = false;
};

}  // namespace sinew
