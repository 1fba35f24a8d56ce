#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "ik/internal_rows.h"
#include "ik/residuals.h"

namespace sinew {

/// Adds to K (links) the stiffness of every residual between a link and the world, (N3), at
/// `origin` in world axes. With `newton`, a load f at r adds what turning it does, see
/// CostCurvature; K is not symmetric then.
void add_link_stiffness(const IkProblem& problem, const IkTargets& targets,
                        const KinematicWorkspace& workspace, const Eigen::Vector3d& origin,
                        bool newton, std::vector<Matrix6d>& K);

/// Links that a residual between a link and the world can see, by itself or by one further out.
std::vector<char> seen_from_the_world(const KinematicTree& tree, const IkProblem& problem);

/// Curvature of the cost without Jacobians. Gauss-Newton's, JᵀΣJ: the stiffness of every residual
/// between a link and the world is added to its link, (N3), and accumulated inward like a composite
/// inertia; residuals between links add their own sparse rows, see InternalRows.
///
/// Newton's adds what the residuals' own curvature contributes. g_u = S_uᵀ Σ wrenches beyond u, and
/// for u before v on the way from the root S_u does not depend on q_v, so that ∂g_u/∂q_v = S_uᵀ K
/// S_v with K the sum, over the points beyond v, of (N3) and
///   [ [f×][r×]  −[f×] ]
///   [    0         0  ],
/// f = −ΣΔp the gradient's force on a point at r: (N4) and (N5) in one. Orientations add their own
/// second derivative and half of what turning their moment does; distances theirs in
/// InternalRows::for_each_second(). Exact but for wires (their tensions are next to nothing where
/// they only hold virtual links), curved couplings, coincidences and alignments (whose forces are
/// small), anisotropic orientation weights, ellipsoid joints, and joints whose
/// coordinates drive several or curved steps.
class CostCurvature {
 public:
  enum class Wires {
    kIncluded,
    // The rows of wires are left to the caller. Of their tension's stiffness there is what holds
    // links that nothing but wires holds, see add_tension().
    kApart,
  };
  CostCurvature(const KinematicTree& tree, const IkProblem& problem,
                Wires wires = Wires::kIncluded);

  /// Collects the stiffness of all residuals and accumulates it inward: Gauss-Newton's, or with
  /// `newton` all of it. Needs update_kinematics(). O(links + residuals).
  void update(const KinematicTree& tree, const IkProblem& problem, const IkTargets& targets,
              const KinematicWorkspace& workspace, bool newton = false);

  /// Gauss-Newton's diagonal over the unknowns: exact but for an unknown that drives others through
  /// couplings, where it is the upper bound of their working together.
  void diagonal(const KinematicTree& tree, const IkProblem& problem, const IkTargets& targets,
                const KinematicWorkspace& workspace, Eigen::Ref<Eigen::VectorXd> diagonal);

  /// All of it, as update() collected it.
  void matrix(const IkProblem& problem, const IkTargets& targets,
              const KinematicWorkspace& workspace, Eigen::MatrixXd& H);

  /// An entry of the lower triangle with the unknowns in reverse order, from the leaves to the
  /// root: unknown x stands at n−1−x. row ≥ column.
  struct Entry {
    int row, column;
  };
  /// What add_reversed() adds to, in its order; an entry may come several times.
  std::span<const Entry> entries() const { return entries_; }

  /// Adds the curvature: what belongs to entries()[k] to values[offsets[k]]. O(unknowns · depth)
  /// and the square of its support for each row between links.
  void add_reversed(const IkProblem& problem, const IkTargets& targets,
                    const KinematicWorkspace& workspace, std::span<const int> offsets,
                    std::span<double> values);

  /// Adds likewise, if wires are apart, the stiffness across a wire that `force` stretches, between
  /// the unknowns of links that no other residual sees: without it, such a link would go far
  /// astray across a wire that markers pull taut. Never makes the matrix indefinite.
  void add_tension(const IkProblem& problem, std::size_t wire, const KinematicWorkspace& workspace,
                   double force, std::span<const int> offsets, std::span<double> values);

  InternalRows& rows() { return rows_; }

  /// Sets of unknowns, in reverse order as above, that the curvature can couple with each other.
  std::vector<std::vector<int>> reversed_cliques(const KinematicTree& tree,
                                                 const IkProblem& problem) const;

 private:
  // A column of S, and those of its own and earlier joints on the way to the root.
  struct Column {
    int v, link;
    int first_partner, partner_count;  // in partners_; of its own joint first
    int own_count;
  };

  void list_entries(const KinematicTree& tree, const IkProblem& problem);
  void find_loose_slots(const KinematicTree& tree, const IkProblem& problem);
  std::span<const int> loose_slots(int support) const {
    const auto s = static_cast<std::size_t>(support);
    return {loose_slots_.data() + first_loose_[s], first_loose_[s + 1] - first_loose_[s]};
  }
  double within_joint(int v, int u, const Matrix6d& K, double forward) const;
  template <typename Place>
  void add(const IkProblem& problem, const IkTargets& targets, const KinematicWorkspace& workspace,
           const Place& place);

  Wires wires_;
  std::vector<Matrix6d> K_;  // links: composite stiffness at rows_.origin(), world axes
  InternalRows rows_;
  std::vector<Entry> entries_;
  std::vector<Column> columns_;
  std::vector<int> partners_;           // v
  std::vector<std::size_t> row_entry_;  // supports: where its entries begin
  // Supports of wires that are apart: which of their unknowns no other residual sees.
  std::vector<int> loose_slots_;
  std::vector<std::size_t> first_loose_;  // supports, in loose_slots_, and its end
  Eigen::VectorXd diagonal_v_;
  bool newton_ = false;
};

}  // namespace sinew
