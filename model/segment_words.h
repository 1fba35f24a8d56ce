#pragma once

#include <string>
#include <vector>

#include "data/marker_names.h"

namespace sinew {

/// The part of a person that a body of a model belongs to, by the habits of published models:
/// femur_r is the right thigh, calcn_l and toes_l are the left foot, L3 and torso the trunk.
struct Segment {
  std::string part;  // "thigh", "trunk", …; of a name that tells nothing, the name itself
  Side side = Side::kNone;
  bool known = false;  // the name tells

  bool operator==(const Segment&) const = default;
};
Segment segment_of_body(const std::string& body);

/// Segments in words: `the trunk, both thighs and the left foot`.
std::string segments_in_words(const std::vector<Segment>& segments);

}  // namespace sinew
