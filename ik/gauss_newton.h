#pragma once

#include <Eigen/Core>

#include "ik/curvature.h"
#include "ik/direction.h"
#include "ik/supernodal_cholesky.h"
#include "ik/wire_prediction.h"
#include "ik/wire_tensions.h"

namespace sinew {

/// Damped Gauss-Newton: the minimum of the model
///   m(d) = g_sᵀd + ½dᵀ(H_s + μE)d + ½ Σ w max(0, ε + jᵀd)² over lower ≤ q + d ≤ upper,
/// H_s and g_s the curvature JᵀΣJ and the gradient without wires, ε and j a wire's excess length
/// and its row. H_s comes from composite stiffnesses and the rows of loops; a sparse Cholesky
/// factorization eliminates its joints from the leaves to the root, so that the joints of one limb
/// do not fill those of another. Wires enter by their tensions, see WireTensions, with those that
/// the step pulls taut and without those that it lets go; what crosses a bound stops there. Without
/// this foresight, a step runs into wires that were slack and is cut down to nothing.
///
/// μ follows the ratio of actual to expected decrease (Nielsen's rule, Madsen, Nielsen & Tingleff
/// 2004, sec. 3.2), more boldly: wires are nearly rigid beside what holds virtual links to their
/// places, and while a step along a taut wire is short for μ's sake it gains next to nothing. The
/// correction after a step takes the tensions anew with the wires' lengths there: a wire that
/// becomes longer in the second order only would otherwise spoil all but short steps.
///
/// `kNearMinimum` takes all second derivatives but the wires' where they are positive definite and
/// lead to a small step, kSmallStep, and JᵀΣJ after a step that was not small: where residuals
/// stay, as they do in every recording, JᵀΣJ comes nearer by the same factor at every iteration,
/// about 10, and Newton squares it. Where the gradient shrinks so fast that the last factorization
/// is good enough for the last step, it serves again.
///
/// `kNewton` takes all second derivatives but the wires', see CostCurvature; `kAutomatic` as well
/// where they are positive definite, and Gauss-Newton's elsewhere. Of a wire's tension all models
/// take what holds links that only wires hold, CostCurvature::add_tension(). Allocates at
/// construction only.
class GaussNewton : public Direction {
 public:
  struct Options {
    // μ at the start of a frame, times the mean diagonal of H_s: large enough to factorize when
    // markers leave a coordinate undetermined, small enough to cost no iterations. Problems with
    // wires start with 1e-4 at least.
    double damping = 1e-9;
  };

  GaussNewton(const KinematicTree& tree, const IkProblem& problem, const Options& options,
              NewtonModel model = NewtonModel::kGaussNewton);

  void start() override;
  bool compute(const Iterate& at, Eigen::Ref<Eigen::VectorXd> d) override;
  bool scales_its_step() const override { return true; }
  double expected_decrease() const override { return expected_; }
  void learn(double accepted_length, double actual_decrease) override;
  bool wants_retry() const override { return true; }
  bool correct(const Iterate& at, const KinematicWorkspace& trial,
               Eigen::Ref<Eigen::VectorXd> d) override;

  /// Of the last direction: what the sparsity of the problem leaves to do.
  const SupernodalCholesky& factor() const { return factor_; }

 private:
  void assemble(const Iterate& at, bool newton);
  bool factorize(bool may_fail);
  double take_row(const Iterate& at, std::size_t wire);
  void add_wire(const Iterate& at, std::size_t wire);
  bool minimize_with_wires(const Iterate& at);
  bool add_taut_wires(const Iterate& at);
  bool stop_at_bounds(const Iterate& at);
  bool tries_newton() const;
  bool holds_same(const Iterate& at) const;
  bool may_repeat(const Iterate& at);
  bool repeat(const Iterate& at, Eigen::Ref<Eigen::VectorXd> d);
  bool minimize_newton(const Iterate& at, Eigen::Ref<Eigen::VectorXd> d);
  bool minimize_model(const Iterate& at, bool newton, Eigen::Ref<Eigen::VectorXd> d);

  Options options_;
  NewtonModel model_;
  CostCurvature curvature_;
  SupernodalCholesky factor_;  // of H_s, unknowns in reverse order
  std::vector<int> offsets_;   // of the curvature's entries in the factor's values
  std::vector<char> held_;     // unknowns in reverse order
  WirePrediction prediction_;
  WireTensions tensions_;
  std::vector<double> force_;  // wires: tensions of the last model
  std::vector<double> bend_;   // wires: length beyond the first order where the step led
  bool first_ = true;          // of a frame
  bool near_ = true;           // the last step was small, kSmallStep, or is still to come
  bool stops_ = false;         // stop_ is not zero
  bool repeatable_ = false;    // the factor is that of the last step, with nothing else in its way
  double last_norm_ = kNaN;    // largest entry of the gradient that the last step is from
  // Unknowns in reverse order. rhs_: −g_s; stop_: steps of the held.
  Eigen::VectorXd gradient_, rhs_, stop_, solution_;
  Eigen::VectorXd d_;         // unknowns
  std::vector<int> indices_;  // of one wire's row
  std::vector<double> row_;
  double stored_ = 0.0;  // ½Σwε² of the wires that are taut now
  double mu_ = 0.0, scale_ = 1.0;
  double relative_mu_ = 0.0, growth_ = 1.0;
  double expected_ = kNaN;
};

}  // namespace sinew
