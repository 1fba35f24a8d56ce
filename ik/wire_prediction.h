#pragma once

#include <span>
#include <vector>

#include "ik/internal_rows.h"
#include "ik/residuals.h"
#include "model/kinematic_tree.h"

namespace sinew {

/// What a step makes of the lengths of all wires, to first order: ε + jᵀd, ε =
/// l − l^d the excess now and j the row of InternalRows, which is zero for no
/// slack wire either. A wire that a step pulls taut bends the cost, f = ½w
/// max(0, ε)², so that a direction has to know beforehand which ones will be.
/// Allocates at construction only.
class WirePrediction {
 public:
  WirePrediction(const KinematicTree& tree, const IkProblem& problem);

  /// Excess lengths, and the wrench of every point's unit force about the rows'
  /// origin. Needs poses. O(points).
  void update(const IkProblem& problem, const KinematicWorkspace& workspace,
              const Eigen::Vector3d& origin);

  /// Excess of every wire now [m].
  std::span<const double> excess() const { return excess_; }

  /// Excess of every wire after the step d, to first order [m]. O(unknowns +
  /// points).
  std::span<const double> predict(const KinematicTree& tree, const IkProblem& problem,
                                  const InternalRows& rows, const Eigen::VectorXd& d);
  /// What predict() found last.
  std::span<const double> predicted() const { return predicted_; }

 private:
  std::vector<double> excess_, predicted_;  // wires
  std::vector<Vector6d> wrench_;            // points of wires; zero off the path
  std::vector<Vector6d> twist_;             // links, by the step
};

}  // namespace sinew
