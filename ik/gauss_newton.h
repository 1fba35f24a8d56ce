#pragma once

#include <Eigen/Core>

#include "ik/curvature.h"
#include "ik/direction.h"
#include "ik/supernodal_cholesky.h"
#include "ik/wire_prediction.h"

namespace sinew {

/// Damped Gauss-Newton: (JᵀΣJ + μE) d = −g with JᵀΣJ from composite stiffnesses and the rows of
/// wires and loops, and a sparse Cholesky factorization that eliminates the joints from the leaves
/// to the root, so that the joints of one limb do not fill those of another. μ follows the ratio of
/// actual to expected decrease (Nielsen's rule, Madsen, Nielsen & Tingleff 2004, sec. 3.2). On the
/// whole body it is several times as fast as conjugate gradients preconditioned by the articulated
/// sweep, ArticulatedCg; tests/bench/results.md has both.
///
/// `kNewton` takes all second derivatives, see CostCurvature; `kAutomatic` as well where they are
/// positive definite, and Gauss-Newton's elsewhere.
///
/// What wires and bounds do along the way is part of the model: it minimizes
///   g_sᵀd + ½dᵀH_s d + ½ Σ w max(0, ε + jᵀd)² over lower ≤ q + d ≤ upper,
/// H_s and g_s without wires, by two steps of Newton's method on this piecewise quadratic: first
/// with the wires that are taut now, then with those that the first step makes so; what crosses a
/// bound stops there. Without this, a step runs into wires that were slack and is cut down to
/// nothing. Allocates at construction only.
class GaussNewton : public Direction {
 public:
  struct Options {
    // μ at the start of a frame, times the mean diagonal of JᵀΣJ: large enough to factorize when
    // markers leave a coordinate undetermined, small enough to cost no iterations. Problems with
    // wires never have less than 1e-4.
    double damping = 1e-9;
  };

  GaussNewton(const KinematicTree& tree, const IkProblem& problem, const Options& options,
              NewtonModel model = NewtonModel::kGaussNewton);

  void start() override;
  bool compute(const Iterate& at, Eigen::Ref<Eigen::VectorXd> d) override;
  bool scales_its_step() const override { return true; }
  double expected_decrease() const override { return expected_; }
  void learn(double accepted_length, double actual_decrease) override;

  /// Of the last direction: what the sparsity of the problem leaves to do.
  const SupernodalCholesky& factor() const { return factor_; }

 private:
  double least_damping() const;
  void assemble(const Iterate& at, bool newton);
  bool factorize(bool may_fail);
  bool minimize_model(const Iterate& at, bool newton, Eigen::Ref<Eigen::VectorXd> d);
  bool change_wires(const Iterate& at, const Eigen::VectorXd& d);
  bool stop_at_bounds(const Iterate& at, const Eigen::VectorXd& d);

  Options options_;
  NewtonModel model_;
  CostCurvature curvature_;
  SupernodalCholesky factor_;  // unknowns in reverse order
  std::vector<int> offsets_;   // of the curvature's entries in the factor's values
  std::vector<char> held_;     // unknowns in reverse order
  WirePrediction prediction_;
  std::vector<char> taut_;                 // wires that the model has now
  Eigen::VectorXd rhs_, stop_, solution_;  // unknowns in reverse order; stop_: steps of the held
  Eigen::VectorXd d_;                      // unknowns
  double slack_cost_ = 0.0;                // what the model has beside its quadratic part
  double mu_ = 0.0, scale_ = 1.0;
  double relative_mu_ = 0.0, growth_ = 2.0;
  double expected_ = kNaN;
};

}  // namespace sinew
