#pragma once

#include "ik/direction.h"

namespace sinew {

/// Steepest descent, d = −g: the yardstick. Converges linearly, at the rate of the cost's
/// condition number.
class SteepestDescent : public Direction {
 public:
  void start() override {}
  bool compute(const Iterate& at, Eigen::Ref<Eigen::VectorXd> d) override;
  bool scales_its_step() const override { return false; }
};

}  // namespace sinew
