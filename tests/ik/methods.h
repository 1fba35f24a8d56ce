#pragma once

#include <algorithm>
#include <string>

#include "ik/minimizer.h"

namespace sinew {

/// Every method that minimizes the cost; the tests of one are the tests of all.
inline constexpr Method kEveryMethod[] = {
    Method::kSteepestDescent,
    Method::kConjugateGradient,
    Method::kBfgs,
    Method::kLbfgs,
    Method::kLevenbergMarquardt,
    Method::kGaussNewton,
    Method::kArticulatedGaussNewton,
    Method::kArticulatedNewton,
    Method::kArticulated,
};

/// For names of tests: `gauss_newton`.
inline constexpr auto test_name_of = [](const auto& info) {
  std::string name = to_string(info.param);
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
};

}  // namespace sinew
