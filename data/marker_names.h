#pragma once

#include <string>
#include <vector>

namespace sinew {

enum class Side { kNone, kLeft, kRight };

/// Where a marker sits, as far as its name tells.
enum class MarkerPlace { kUnknown, kHead, kTrunk, kPelvis, kLeg, kFoot };

/// What a name says by the habits of the published marker sets: Plug-in Gait, Helen Hayes,
/// Cleveland Clinic, OpenSim's examples. A subject's name before a colon is left out.
struct MarkerName {
  Side side = Side::kNone;  // a leading L or R, Left or Right, or .L, _R, ... at the end
  MarkerPlace place = MarkerPlace::kUnknown;
  std::string without_side;  // in lower case, the side replaced by `*`; empty if there is none
};
MarkerName parse_marker_name(const std::string& name);

/// Markers of the feet, and those of pelvis, trunk and head, as indices.
struct LowAndHighMarkers {
  std::vector<int> low, high;
};
LowAndHighMarkers low_and_high_markers(const std::vector<std::string>& names);

/// A left marker and the right one of the same name, as indices.
struct MarkerPair {
  int left = 0, right = 0;
};
std::vector<MarkerPair> find_marker_pairs(const std::vector<std::string>& names);

}  // namespace sinew
