#pragma once

#include <Eigen/Core>
#include <vector>

#include "ik/residuals.h"

namespace sinew {

/// Gauss-Newton curvature JᵀΣJ of the cost without Jacobians: the stiffness of every residual is
/// added to its link, (N3), and accumulated inward like a composite inertia.
class GaussNewtonCurvature {
 public:
  explicit GaussNewtonCurvature(const KinematicTree& tree);

  /// Collects the stiffness of all residuals and accumulates it inward. Needs update_kinematics().
  /// O(links + residuals).
  void update(const KinematicTree& tree, const IkProblem& problem, const IkTargets& targets,
              const KinematicWorkspace& workspace);

  /// Diagonal of JᵀΣJ over the unknowns. Residuals between two links (distances, cut loops) count
  /// as if each end moved alone. O(unknowns).
  void diagonal(const KinematicTree& tree, const KinematicWorkspace& workspace,
                Eigen::Ref<Eigen::VectorXd> diagonal) const;

  /// All of JᵀΣJ, exactly. O(v · depth) and a row operation for every residual between two links.
  void matrix(const KinematicTree& tree, const IkProblem& problem, const IkTargets& targets,
              const KinematicWorkspace& workspace, Eigen::MatrixXd& H);

 private:
  void add_pairs(const KinematicTree& tree, const IkProblem& problem, const IkTargets& targets,
                 const KinematicWorkspace& workspace, Eigen::MatrixXd& H);

  std::vector<Matrix6d> K_;  // links: composite stiffness at the link's origin, world axes
  Eigen::MatrixXd H_v_;      // v × v, before couplings are folded
  Eigen::VectorXd row_;      // one row of J over the unknowns
};

}  // namespace sinew
