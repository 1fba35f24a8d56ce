#pragma once

#include <Eigen/Core>

#include "ik/curvature.h"
#include "ik/direction.h"

namespace sinew {

/// Limited-memory BFGS by the two-loop recursion (Nocedal & Wright 2006, alg. 7.4), started from a
/// diagonal: the Gauss-Newton curvature of every unknown at the frame's first iterate, which makes
/// metres and radians comparable at O(links). Allocates at construction only.
class Lbfgs : public Direction {
 public:
  struct Options {
    int memory = 20;  // pairs kept; measured on the gait trials: 5 needs twice the iterations
  };

  Lbfgs(const KinematicTree& tree, const Options& options);

  void start() override;
  bool compute(const Iterate& at, Eigen::Ref<Eigen::VectorXd> d) override;
  bool scales_its_step() const override { return true; }

 private:
  void remember(const Iterate& at);
  void precondition(const Iterate& at);

  GaussNewtonCurvature curvature_;
  int stored_ = 0, next_ = 0;
  Eigen::MatrixXd S_, Y_;        // unknowns × memory
  Eigen::VectorXd rho_, alpha_;  // memory
  Eigen::VectorXd inverse_diagonal_;
};

}  // namespace sinew
