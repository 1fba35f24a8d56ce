#pragma once

#include <Eigen/Core>

#include "ik/curvature.h"
#include "ik/direction.h"
#include "ik/supernodal_cholesky.h"

namespace sinew {

/// Damped Gauss-Newton: (JᵀΣJ + μE) d = −g with JᵀΣJ from composite stiffnesses and the rows of
/// wires and loops, and a sparse Cholesky factorization that eliminates the joints from the leaves
/// to the root, so that the joints of one limb do not fill those of another. μ follows the ratio of
/// actual to expected decrease (Nielsen's rule, Madsen, Nielsen & Tingleff 2004, sec. 3.2). For the
/// 23 to 40 unknowns of a gait model microseconds. Allocates at construction only.
class GaussNewton : public Direction {
 public:
  struct Options {
    // μ at the start of a frame, times the mean diagonal of JᵀΣJ: large enough to factorize when
    // markers leave a coordinate undetermined, small enough to cost no iterations.
    double damping = 1e-9;
  };

  GaussNewton(const KinematicTree& tree, const IkProblem& problem, const Options& options);

  void start() override;
  bool compute(const Iterate& at, Eigen::Ref<Eigen::VectorXd> d) override;
  bool scales_its_step() const override { return true; }
  double expected_decrease() const override { return expected_; }
  void learn(double accepted_length, double actual_decrease) override;

  /// Of the last direction: what the sparsity of the problem leaves to do.
  const SupernodalCholesky& factor() const { return factor_; }

 private:
  Options options_;
  GaussNewtonCurvature curvature_;
  SupernodalCholesky factor_;  // unknowns in reverse order
  std::vector<int> offsets_;   // of the curvature's entries in the factor's values
  std::vector<char> held_;     // unknowns in reverse order
  double relative_mu_ = 0.0, growth_ = 2.0;
  double expected_ = kNaN;
};

}  // namespace sinew
