#pragma once

#include <vector>

#include "model/musculoskeletal_model.h"

namespace sinew {

/// A model without its virtual links and paths: what has mass, and moves the same.
struct Skeleton {
  MusculoskeletalModel model;
  std::vector<int> coordinates;  // of the skeleton → of the whole model
  std::vector<int> bodies;       // of the whole model → of the skeleton, −1 for virtual links
};

/// Leaves out virtual links, which nothing hangs from, and paths. Throws std::invalid_argument if
/// something does hang from a virtual link.
Skeleton skeleton_of(const MusculoskeletalModel& model);

}  // namespace sinew
