#include "data/marker_trajectories.h"

#include <algorithm>

namespace sinew {

int MarkerTrajectories::find_marker(const std::string& name) const {
  const auto found = std::find(names.begin(), names.end(), name);
  return found == names.end() ? -1 : static_cast<int>(found - names.begin());
}

}  // namespace sinew
