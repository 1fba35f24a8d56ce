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

  /// Diagonal of JᵀΣJ over the unknowns: exact but for an unknown that drives others through
  /// couplings, where it is the upper bound of their working together. O(v) and a row operation for
  /// every residual between two links.
  void diagonal(const KinematicTree& tree, const IkProblem& problem, const IkTargets& targets,
                const KinematicWorkspace& workspace, Eigen::Ref<Eigen::VectorXd> diagonal);

  /// All of JᵀΣJ, exactly. O(v · depth) and a row operation for every residual between two links.
  void matrix(const KinematicTree& tree, const IkProblem& problem, const IkTargets& targets,
              const KinematicWorkspace& workspace, Eigen::MatrixXd& H);

 private:
  // Calls use(weight) for every residual between two links, with its row of J in row_.
  template <typename Use>
  void for_each_pair_row(const KinematicTree& tree, const IkProblem& problem,
                         const IkTargets& targets, const KinematicWorkspace& workspace,
                         const Use& use);
  // Add `direction` · (the derivative of the point's position, or of the link's rotation) to row_.
  void add_point_row(const KinematicTree& tree, const KinematicWorkspace& workspace, int link,
                     const Eigen::Vector3d& p_W, const Eigen::Vector3d& direction);
  void add_turn_row(const KinematicTree& tree, const KinematicWorkspace& workspace, int link,
                    const Eigen::Vector3d& direction);

  std::vector<Matrix6d> K_;  // links: composite stiffness at the link's origin, world axes
  Eigen::MatrixXd H_v_;      // v × v, before couplings are folded
  Eigen::VectorXd diagonal_v_;
  Eigen::VectorXd row_;  // one row of J over the unknowns
};

}  // namespace sinew
