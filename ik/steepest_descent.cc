#include "ik/steepest_descent.h"

namespace sinew {

bool SteepestDescent::compute(const Iterate& at, Eigen::Ref<Eigen::VectorXd> d) {
  d = -at.g;
  return true;
}

}  // namespace sinew
