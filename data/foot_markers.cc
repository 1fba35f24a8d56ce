#include "data/foot_markers.h"

#include <algorithm>
#include <string>
#include <utility>

#include "data/numbers.h"

namespace sinew {
namespace {

using Eigen::Vector3d;

bool contains_one(const std::string& text, std::initializer_list<const char*> words) {
  return std::any_of(words.begin(), words.end(),
                     [&](const char* word) { return text.find(word) != text.npos; });
}

bool is_measured(const MarkerTrajectories& markers, int marker) {
  for (int f = 0; f < markers.frame_count(); ++f) {
    if (markers.position(f, marker).allFinite()) return true;
  }
  return false;
}

Vector3d seen_along(const Vector3d& up, const Vector3d& v) { return v - up * up.dot(v); }

}  // namespace

FeetMarkers find_foot_markers(const MarkerTrajectories& markers) {
  FeetMarkers feet;
  std::vector<int> left_ankle, right_ankle;
  for (int i = 0; i < markers.marker_count(); ++i) {
    const MarkerName name = parse_marker_name(markers.names[static_cast<std::size_t>(i)]);
    if (name.side == Side::kNone || name.place != MarkerPlace::kFoot) continue;
    if (!is_measured(markers, i)) continue;
    FootMarkers& foot = name.side == Side::kLeft ? feet.left : feet.right;
    foot.all.push_back(i);
    if (contains_one(name.without_side, {"hee", "cal"})) {
      foot.heel.push_back(i);
    } else if (contains_one(name.without_side, {"ank", "mal"})) {
      (name.side == Side::kLeft ? left_ankle : right_ankle).push_back(i);
    } else if (contains_one(name.without_side, {"to", "mt", "met", "hlx"})) {
      foot.toe.push_back(i);
    }
  }
  if (feet.left.heel.empty()) feet.left.heel = std::move(left_ankle);
  if (feet.right.heel.empty()) feet.right.heel = std::move(right_ankle);
  return feet;
}

std::vector<int> find_pelvis_markers(const MarkerTrajectories& markers) {
  std::vector<int> pelvis;
  for (int i = 0; i < markers.marker_count(); ++i) {
    const MarkerName name = parse_marker_name(markers.names[static_cast<std::size_t>(i)]);
    if (name.place == MarkerPlace::kPelvis) pelvis.push_back(i);
  }
  return pelvis;
}

Vector3d mean_position(const MarkerTrajectories& markers, int frame,
                       const std::vector<int>& which) {
  Vector3d sum = Vector3d::Zero();
  int count = 0;
  for (const int marker : which) {
    const Vector3d p = markers.position(frame, marker);
    if (!p.allFinite()) continue;
    sum += p;
    ++count;
  }
  return sum / (count > 0 ? count : kNaN);
}

Vector3d facing_in(const MarkerTrajectories& markers, int frame, const FeetMarkers& feet,
                   const Vector3d& up) {
  Vector3d sum = Vector3d::Zero();
  for (const FootMarkers* foot : {&feet.left, &feet.right}) {
    if (!foot->has_ends()) continue;
    const Vector3d d =
        mean_position(markers, frame, foot->toe) - mean_position(markers, frame, foot->heel);
    if (d.allFinite()) sum += seen_along(up, d);
  }
  return sum.isZero() ? sum : Vector3d(sum.normalized());
}

Vector3d mean_facing(const MarkerTrajectories& markers, const FeetMarkers& feet,
                     const Vector3d& up) {
  Vector3d sum = Vector3d::Zero();
  int count = 0;
  for (int frame = 0; frame < markers.frame_count(); ++frame) {
    const Vector3d facing = facing_in(markers, frame, feet, up);
    if (facing.isZero()) continue;
    sum += facing;
    ++count;
  }
  return sum / std::max(count, 1);
}

Vector3d way_travelled(const MarkerTrajectories& markers, const Vector3d& up) {
  Vector3d sum = Vector3d::Zero();
  int count = 0;
  for (int i = 0; i < markers.marker_count(); ++i) {
    int first = -1, last = -1;
    for (int frame = 0; frame < markers.frame_count(); ++frame) {
      if (!markers.position(frame, i).allFinite()) continue;
      if (first < 0) first = frame;
      last = frame;
    }
    if (first < 0 || 2 * (last - first) < markers.frame_count()) continue;
    sum += markers.position(last, i) - markers.position(first, i);
    ++count;
  }
  return seen_along(up, sum / std::max(count, 1));
}

}  // namespace sinew
