#pragma once

#include <Eigen/Core>

#include "ik/residuals.h"

namespace sinew {

/// The residuals e(q) of eq. (7) and their Jacobian J = ∂e/∂x of eqs. (13)-(16), row by row, with
/// the weights folded in: A = Σ^½ J, b = Σ^½ e, so that f = ½ bᵀb, g = Aᵀb and B = AᵀA, eq. (32).
/// For methods in constraint space; gradients and normal equations have faster ways.
struct ResidualRows {
  Eigen::MatrixXd A;  // rows × unknowns
  Eigen::VectorXd b;
  int count = 0;  // rows in use: residuals that were not measured and slack wires have none

  /// Sized for all residuals.
  ResidualRows(const KinematicTree& tree, const IkProblem& problem);

  /// Needs update_kinematics(). O(rows · unknowns), nearly all of it for zeros.
  void update(const KinematicTree& tree, const IkProblem& problem, const IkTargets& targets,
              const KinematicWorkspace& workspace);
};

/// Rows that a problem has at most.
int row_count(const IkProblem& problem);

}  // namespace sinew
