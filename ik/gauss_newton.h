#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include "ik/curvature.h"
#include "ik/direction.h"

namespace sinew {

/// Damped Gauss-Newton: (JᵀΣJ + μE) d = −g with JᵀΣJ from composite stiffnesses and a dense
/// Cholesky factorization over the unknowns that no bound holds. μ follows the ratio of actual to
/// expected decrease (Nielsen's rule, Madsen, Nielsen & Tingleff 2004, sec. 3.2). O(v·depth +
/// unknowns³/3), which for the 23 to 40 unknowns of a gait model is microseconds. Allocates at
/// construction only.
class GaussNewton : public Direction {
 public:
  struct Options {
    // μ at the start of a frame, times the mean diagonal of JᵀΣJ: large enough to factorize when
    // markers leave a coordinate undetermined, small enough to cost no iterations.
    double damping = 1e-9;
  };

  GaussNewton(const KinematicTree& tree, const Options& options);

  void start() override;
  bool compute(const Iterate& at, Eigen::Ref<Eigen::VectorXd> d) override;
  bool scales_its_step() const override { return true; }
  double expected_decrease() const override { return expected_; }
  void learn(double accepted_length, double actual_decrease) override;

 private:
  bool factorize(const Iterate& at, double mu);

  Options options_;
  GaussNewtonCurvature curvature_;
  Eigen::MatrixXd H_, factor_;
  Eigen::VectorXd Hd_;
  double scale_ = 1.0;  // mean diagonal of H
  double relative_mu_ = 0.0, growth_ = 2.0;
  double expected_ = kNaN;
};

}  // namespace sinew
