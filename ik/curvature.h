#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "ik/internal_rows.h"
#include "ik/residuals.h"

namespace sinew {

/// Adds to K (links) the stiffness of every residual between a link and the world, (N3), at
/// `origin` in world axes.
void add_link_stiffness(const IkProblem& problem, const IkTargets& targets,
                        const KinematicWorkspace& workspace, const Eigen::Vector3d& origin,
                        std::vector<Matrix6d>& K);

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
  void matrix(const IkProblem& problem, const IkTargets& targets,
              const KinematicWorkspace& workspace, Eigen::MatrixXd& H);

  /// An entry of JᵀΣJ's lower triangle with the unknowns in reverse order, from the leaves to the
  /// root: unknown x stands at n−1−x. row ≥ column.
  struct Entry {
    int row, column;
  };
  /// What add_reversed() adds to, in its order; an entry may come several times.
  std::span<const Entry> entries() const { return entries_; }

  /// Adds JᵀΣJ: what belongs to entries()[k] to values[offsets[k]]. O(unknowns · depth) and the
  /// square of its support for each row between links.
  void add_reversed(const IkProblem& problem, const IkTargets& targets,
                    const KinematicWorkspace& workspace, std::span<const int> offsets,
                    std::span<double> values);

  /// Sets of unknowns, in reverse order as above, that JᵀΣJ can couple with each other.
  std::vector<std::vector<int>> reversed_cliques(const KinematicTree& tree,
                                                 const IkProblem& problem) const;

 private:
  // A column of S, and those of its own and earlier joints on the way to the root.
  struct Column {
    int v, link;
    int first_partner, partner_count;  // in partners_
  };

  void list_entries(const KinematicTree& tree, const IkProblem& problem);
  template <typename Place>
  void add(const IkProblem& problem, const IkTargets& targets, const KinematicWorkspace& workspace,
           const Place& place);

  std::vector<Matrix6d> K_;  // links: composite stiffness at rows_.origin(), world axes
  InternalRows rows_;
  std::vector<Entry> entries_;
  std::vector<Column> columns_;
  std::vector<int> partners_;           // v
  std::vector<std::size_t> row_entry_;  // supports: where its entries begin
  Eigen::VectorXd diagonal_v_;
};

}  // namespace sinew
