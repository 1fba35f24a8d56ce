#include "data/statistics.h"

#include <algorithm>
#include <cstddef>

#include "data/numbers.h"

namespace sinew {

double median(std::vector<double> values) {
  if (values.empty()) return kNaN;
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

}  // namespace sinew
