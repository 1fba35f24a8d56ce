#pragma once

#include <Eigen/Core>
#include <vector>

#include "ik/internal_rows.h"
#include "ik/residuals.h"

namespace sinew {

/// Gauss-Newton curvature JᵀΣJ of the cost without Jacobians: the stiffness of every residual
/// between a link and the world is added to its link, (N3), and accumulated inward like a composite
/// inertia; residuals between links add their own sparse rows, see InternalRows.
class GaussNewtonCurvature {
 public:
  GaussNewtonCurvature(const KinematicTree& tree, const IkProblem& problem);

  /// Collects the stiffness of all residuals and accumulates it inward. Needs update_kinematics().
  /// O(links + residuals).
  void update(const KinematicTree& tree, const IkProblem& problem, const IkTargets& targets,
              const KinematicWorkspace& workspace);

  /// Diagonal of JᵀΣJ over the unknowns: exact but for an unknown that drives others through
  /// couplings, where it is the upper bound of their working together.
  void diagonal(const KinematicTree& tree, const IkProblem& problem, const IkTargets& targets,
                const KinematicWorkspace& workspace, Eigen::Ref<Eigen::VectorXd> diagonal);

  /// All of JᵀΣJ, exactly.
  void matrix(const KinematicTree& tree, const IkProblem& problem, const IkTargets& targets,
              const KinematicWorkspace& workspace, Eigen::MatrixXd& H);

  /// Adds JᵀΣJ to the lower triangle of R, whose rows and columns are the unknowns in reverse
  /// order, from the leaves to the root: R(n−1−x, n−1−y). Touches nothing beside its pattern.
  /// O(unknowns · depth) and the square of its support for each row between links.
  void add_reversed(const KinematicTree& tree, const IkProblem& problem, const IkTargets& targets,
                    const KinematicWorkspace& workspace, Eigen::MatrixXd& R);

  /// Sets of unknowns, in reverse order as above, that JᵀΣJ can couple with each other.
  std::vector<std::vector<int>> reversed_cliques(const KinematicTree& tree,
                                                 const IkProblem& problem) const;

 private:
  void add_composite(const KinematicTree& tree, Eigen::MatrixXd& R) const;

  std::vector<Matrix6d> K_;  // links: composite stiffness at rows_.origin(), world axes
  InternalRows rows_;
  Eigen::VectorXd diagonal_v_;
};

}  // namespace sinew
