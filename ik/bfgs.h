#pragma once

#include <vector>

#include "ik/direction.h"

namespace sinew {

/// BFGS with the dense inverse H, eqs. (33)-(35): d = −H g, H₁ = E,
///   H ← (E − y sᵀ/yᵀs)ᵀ H (E − y sᵀ/yᵀs) + s sᵀ/yᵀs.
/// A pair without positive curvature is passed over, which keeps H positive definite. An unknown
/// that comes to its bound is eliminated from H, so that the rest stays the inverse of the free
/// unknowns' curvature; one that leaves its bound starts from its own curvature alone. O(unknowns²)
/// in time and memory. Allocates at construction only.
class Bfgs : public Direction {
 public:
  explicit Bfgs(const KinematicTree& tree);

  void start() override;
  bool compute(const Iterate& at, Eigen::Ref<Eigen::VectorXd> d) override;
  bool scales_its_step() const override { return true; }

 private:
  void eliminate(Eigen::Index x);
  void update(const Iterate& at);

  Eigen::MatrixXd H_;  // lower triangle
  Eigen::VectorXd Hy_, column_;
  std::vector<char> held_;  // eliminated from H
};

}  // namespace sinew
