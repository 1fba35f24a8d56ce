#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "ik/direction.h"
#include "ik/internal_rows.h"

namespace sinew {

/// Damped Gauss-Newton by preconditioned conjugate gradients: (JᵀΣJ + μE) d = −g without the
/// matrix, for wires across several joints, which do not fit the articulated sweep, see
/// Articulated.
///
/// The product y = (JᵀΣJ + μE) d is exact: with the twists v of (N1) about a common origin, the
/// stiffness K of every link, (N3), and the row jᵢ and weight wᵢ of every taut wire,
///   outward v_k = v_p(k) + S_k d_k, f_k = K_k v_k; inward y_k = S_kᵀ f_k, f_p(k) += f_k;
///   y += Σ wᵢ jᵢ jᵢᵀd + μd.
/// The preconditioner is what the articulated sweep can eliminate, (N6)(N7): K of the links, and of
/// the wires the blocks wᵢ jᵢjᵢᵀ of each joint with itself. Dependent coordinates of couplings stay
/// fixed in it. O(links + taut wires) an iteration; allocates at construction only.
///
/// Only benchmarks use it: on the whole body GaussNewton's factorization is faster, see
/// tests/bench/results.md.
class ArticulatedCg : public Direction {
 public:
  struct Options {
    double damping = 1e-4;    // μ, times the mean diagonal of JᵀΣJ, as GaussNewton's with wires
    double tolerance = 1e-6;  // rᵀM⁻¹r ≤ tolerance² gᵀM⁻¹g ends the iteration
    int max_iterations = 1000;
  };

  ArticulatedCg(const KinematicTree& tree, const IkProblem& problem, const Options& options);

  void start() override {}
  bool compute(const Iterate& at, Eigen::Ref<Eigen::VectorXd> d) override;
  bool scales_its_step() const override { return true; }

  /// Of the last direction.
  int iterations() const { return iterations_; }

 private:
  struct Row {
    const int* unknowns;
    std::size_t first, count;  // in row_values_
    double weight;
  };

  void collect(const Iterate& at);
  void collect_rows(const Iterate& at);
  double mean_diagonal(const KinematicTree& tree);
  bool factorize(const KinematicTree& tree);
  template <int kColumns>
  bool eliminate(std::size_t link, std::span<const int> columns);
  void precondition(const KinematicTree& tree, const Eigen::VectorXd& r, Eigen::VectorXd& z);
  void multiply(const Iterate& at, const Eigen::VectorXd& d, Eigen::VectorXd& y);

  Options options_;
  InternalRows rows_;
  std::vector<Row> active_rows_;
  std::vector<double> row_values_;
  std::vector<Matrix6d> K_, articulated_;             // links: of their own residuals; K^A
  std::vector<Matrix6d> block_, inverse_;             // links: of their joint's own rows; D⁻¹
  std::vector<Vector6d> twist_, wrench_;              // links
  std::vector<Vector6d> gain_;                        // v: column of U D⁻¹
  std::vector<double> spring_;                        // unknowns: of coordinate targets
  std::vector<double> reduced_;                       // v: z of (N6)
  std::vector<std::vector<int>> columns_;             // links: v of theirs that are eliminated now
  std::vector<std::pair<int, int>> driven_together_;  // v: one unknown drives both
  Eigen::VectorXd r_, z_, p_, y_;
  double mu_ = 0.0;
  int iterations_ = 0;
};

}  // namespace sinew
