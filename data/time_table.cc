#include "data/time_table.h"

#include <algorithm>

namespace sinew {

int TimeTable::find_column(const std::string& label) const {
  const auto found = std::find(labels.begin(), labels.end(), label);
  return found == labels.end() ? -1 : static_cast<int>(found - labels.begin());
}

}  // namespace sinew
