#pragma once

#include <Eigen/Core>

#include "ik/curvature.h"
#include "ik/direction.h"

namespace sinew {

/// Limited-memory BFGS by the two-loop recursion (Nocedal & Wright 2006, alg. 7.4). Never restarts;
/// passes over pairs without positive curvature. O(memory · unknowns). Allocates at construction
/// only.
class Lbfgs : public Direction {
 public:
  /// H₀, where the recursion starts.
  enum class Start {
    // The inverse of every unknown's Gauss-Newton curvature at the frame's first iterate, which
    // makes metres and radians comparable at O(links).
    kCurvature,
    // γE with γ = sᵀy/yᵀy of the last pair (N&W eq. 7.20), E at first: the plain method.
    kScaledIdentity,
  };
  struct Options {
    int memory = 20;  // pairs kept; measured on the gait trials: 5 needs twice the iterations
    Start start = Start::kCurvature;
  };

  Lbfgs(const KinematicTree& tree, const IkProblem& problem, const Options& options);

  void start() override;
  bool compute(const Iterate& at, Eigen::Ref<Eigen::VectorXd> d) override;
  bool scales_its_step() const override { return true; }

 private:
  void remember(const Iterate& at);
  void precondition(const Iterate& at);

  Start start_;
  CostCurvature curvature_;
  int stored_ = 0, next_ = 0;
  Eigen::MatrixXd S_, Y_;        // unknowns × memory
  Eigen::VectorXd rho_, alpha_;  // memory
  Eigen::VectorXd inverse_diagonal_;
};

}  // namespace sinew
