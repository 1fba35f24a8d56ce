#include "data/foot_motion.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "data/marker_names.h"

namespace sinew {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// A foot rolls over with 0.3 m/s at its slowest marker and swings with 2 to 5 m/s.
constexpr double kStandingSpeed = 0.7;  // [m/s]

// Seen from above: x forward, z right.
Vector2d from_above(const Vector3d& p) { return {p.x(), p.z()}; }

double distance_to_segment(const Vector2d& p, const Vector2d& a, const Vector2d& b) {
  const Vector2d ab = b - a;
  const double length = ab.squaredNorm();
  const double s = length > 0.0 ? std::clamp((p - a).dot(ab) / length, 0.0, 1.0) : 0.0;
  return (p - a - s * ab).norm();
}

}  // namespace

std::vector<Foot> find_feet(const MarkerTrajectories& markers) {
  std::vector<Foot> feet = {{"right", "calcn_r", {}}, {"left", "calcn_l", {}}};
  for (int i = 0; i < markers.marker_count(); ++i) {
    const MarkerName name = parse_marker_name(markers.names[static_cast<std::size_t>(i)]);
    if (name.place != MarkerPlace::kFoot || name.side == Side::kNone) continue;
    feet[name.side == Side::kRight ? 0 : 1].markers.push_back(i);
  }
  std::erase_if(feet, [](const Foot& foot) { return foot.markers.empty(); });
  return feet;
}

double distance_outside(const ForcePlatform& platform, const Vector3d& p) {
  const Vector3d local = platform.R_WP.transpose() * (p - platform.p_WC);
  const auto& c = platform.corners;
  const double half_x = 0.25 * ((c[0] - c[1]).norm() + (c[3] - c[2]).norm());
  const double half_y = 0.25 * ((c[0] - c[3]).norm() + (c[1] - c[2]).norm());
  return std::max(std::abs(local.x()) - half_x, std::abs(local.y()) - half_y);
}

FootMotion foot_motion(const MarkerTrajectories& markers, const Foot& foot) {
  FootMotion motion;
  const int frames = markers.frame_count();
  for (int f = 0; f < frames; ++f) {
    const int before = std::max(f - 1, 0), behind = std::min(f + 1, frames - 1);
    const double dt = markers.time[behind] - markers.time[before];
    double slowest = std::numeric_limits<double>::infinity();
    motion.markers.emplace_back();
    for (const int marker : foot.markers) {
      const Vector3d p = markers.position(f, marker);
      if (!p.allFinite()) continue;
      motion.markers.back().push_back(p);
      const Vector3d d = markers.position(behind, marker) - markers.position(before, marker);
      if (d.allFinite() && dt > 0.0) slowest = std::min(slowest, d.norm() / dt);
    }
    motion.stands.push_back(slowest < kStandingSpeed);
  }
  return motion;
}

double distance_to_foot(const std::vector<Vector3d>& markers, const Vector3d& center) {
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < markers.size(); ++i) {
    for (std::size_t k = i; k < markers.size(); ++k) {
      nearest = std::min(nearest, distance_to_segment(from_above(center), from_above(markers[i]),
                                                      from_above(markers[k])));
    }
  }
  return nearest;
}

}  // namespace sinew
