#pragma once

#include <Eigen/Core>

#include "ik/curvature.h"
#include "ik/direction.h"
#include "ik/residual_rows.h"

namespace sinew {

/// Levenberg-Marquardt with the cost itself as damping, eqs. (31)(32), after Sugihara (2011):
///   d = −(B + (f + λ)E)⁻¹ g,  B = JᵀΣJ.
/// With fewer residual rows than unknowns the same d comes from the smaller system in constraint
/// space, with A = Σ^½ J and g = Aᵀb:
///   d = −Aᵀ(AAᵀ + (f + λ)E)⁻¹ b.
/// Never restarts; has no memory. Near a minimum with f → 0 it converges linearly at the rate
/// λ/(λ + curvature), so weak directions take thousands of iterations: GaussNewton's damping is the
/// better rule. O(min(rows, unknowns)³). Allocates at construction only.
class LevenbergMarquardt : public Direction {
 public:
  enum class Form { kSmaller, kPrimal, kDual };
  struct Options {
    double lambda = 0.001;  // the paper's
    Form form = Form::kSmaller;
  };

  LevenbergMarquardt(const KinematicTree& tree, const IkProblem& problem, const Options& options);

  void start() override {}
  bool compute(const Iterate& at, Eigen::Ref<Eigen::VectorXd> d) override;
  bool scales_its_step() const override { return true; }

 private:
  bool primal(const Iterate& at, Eigen::Ref<Eigen::VectorXd> d);
  bool dual(const Iterate& at, Eigen::Ref<Eigen::VectorXd> d);

  Options options_;
  bool dual_;
  CostCurvature curvature_;
  ResidualRows rows_;         // of the dual form
  Eigen::MatrixXd matrix_;    // unknowns × unknowns, or rows × rows
  Eigen::VectorXd solution_;  // rows
};

}  // namespace sinew
