#pragma once

#include <optional>
#include <vector>

#include "ik/residuals.h"
#include "model/kinematic_tree.h"

namespace sinew {

/// Where a frame starts: where the solutions of the frames before it lead to. Every unknown goes on
/// by itself as it stood, as it went or as it sped up, q, 2q − q₋₁ or 3q − 3q₋₁ + q₋₂, by whichever
/// would have come nearest in the frames so far: motion is smooth and noise is not, and each
/// extrapolation multiplies the noise of what markers hold weakly by √5 and √19. Quaternions stay.
/// Beside wires all unknowns go on together as they went, or stay: joints are held so weakly there
/// that each by itself would carry them over to other taut wires. They go on if that leaves less
/// than a tenth of the cost at the last solution.
/// Where something is missing that the frame before measured, all stay: what nothing holds any more
/// would go on by itself for ever, each frame bearing out the one before.
/// Allocates at construction only.
class WarmStart {
 public:
  WarmStart(const KinematicTree& tree, const IkProblem& problem);

  /// Forgets the frames so far.
  void reset() { known_ = 0; }

  /// `q`: the solution of the last frame, or any start after reset(); becomes the start of the next
  /// frame, which asks for `targets` of `problem`, that of the constructor. O(unknowns +
  /// residuals).
  void advance(const KinematicTree& tree, const IkProblem& problem, const IkTargets& targets,
               std::vector<double>& q);

 private:
  static constexpr int kOrders = 3;
  // Of one unknown.
  struct History {
    double past[kOrders] = {};   // its values in the last frames, the newest first
    double error[kOrders] = {};  // by order: squares of what the extrapolation was off by, fading
  };
  static double extrapolate(const History& history, int order);
  int best_order(const History& history) const;

  bool misses_some(const IkTargets& targets);
  template <typename Order>
  void go_on(const KinematicTree& tree, std::vector<double>& q, const Order& order) const;
  double cost_at(const KinematicTree& tree, const IkProblem& problem, const IkTargets& targets,
                 const std::vector<double>& q);

  std::vector<History> histories_;  // unknowns
  std::vector<char> measured_;      // positions, orientations, distances in turn: in the last frame
  std::optional<KinematicWorkspace> together_;  // to compare costs; where there are wires
  std::vector<double> last_;                    // the last solution, to go back to
  int known_ = 0;                               // frames since reset(), as far as they matter
};

}  // namespace sinew
