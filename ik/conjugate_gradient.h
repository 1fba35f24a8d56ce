#pragma once

#include <vector>

#include "ik/direction.h"

namespace sinew {

/// Nonlinear conjugate gradients of Dai & Liao (2001), eqs. (36)(37) of Ayusawa & Nakamura 2012:
///   d_{k+1} = −g_{k+1} + β d_k,  β = max(g_{k+1}ᵀy / d_kᵀy, 0) − t g_{k+1}ᵀs / d_kᵀy.
/// Starts again from −g where an unknown comes to its bound or leaves it, where the cost curves
/// downward along the last direction (d_kᵀy ≤ 0), and where d would not descend. O(unknowns).
class ConjugateGradient : public Direction {
 public:
  struct Options {
    double t = 1.0;  // the paper's; 0 is Hestenes & Stiefel's method, truncated
  };

  ConjugateGradient(const KinematicTree& tree, const Options& options);

  void start() override {}
  bool compute(const Iterate& at, Eigen::Ref<Eigen::VectorXd> d) override;
  bool scales_its_step() const override { return false; }

 private:
  double t_;
  std::vector<char> held_;  // at the last iterate
};

}  // namespace sinew
