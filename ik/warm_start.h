#pragma once

#include <vector>

#include "model/kinematic_tree.h"

namespace sinew {

/// Where a frame starts: where the solutions of the frames before it lead to. Every unknown goes on
/// by itself as it stood, as it went or as it sped up, q, 2q − q₋₁ or 3q − 3q₋₁ + q₋₂, by whichever
/// would have come nearest in the frames so far: motion is smooth and noise is not, and each
/// extrapolation multiplies the noise of what markers hold weakly by √5 and √19. Quaternions stay.
/// Allocates at construction only.
class WarmStart {
 public:
  explicit WarmStart(const KinematicTree& tree);

  /// Forgets the frames so far.
  void reset() { known_ = 0; }

  /// `q`: the solution of the last frame, or any start after reset(); becomes the start of the next
  /// frame. O(unknowns).
  void advance(const KinematicTree& tree, std::vector<double>& q);

 private:
  static constexpr int kOrders = 3;
  // Of one unknown.
  struct History {
    double past[kOrders] = {};   // its values in the last frames, the newest first
    double error[kOrders] = {};  // by order: squares of what the extrapolation was off by, fading
  };
  static double extrapolate(const History& history, int order);
  int best_order(const History& history) const;

  std::vector<History> histories_;  // unknowns
  int known_ = 0;                   // frames since reset(), as far as they matter
};

}  // namespace sinew
