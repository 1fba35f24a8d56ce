#include "data/preflight_order.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "data/marker_names.h"
#include "data/marker_synonyms.h"
#include "data/preflight_swaps.h"

namespace sinew {
namespace {

// A knee that swings keeps its markers above the ankle's; feet that are lifted do not.
constexpr double kMostFrames = 0.8;
constexpr double kLeastHeight = 0.02;  // [m] what skin and unequal placing explain

struct LegMarker {
  int index = 0;
  int level = 0;  // from the floor upwards
};

// Foot and ankle 1, for toes are lifted above ankles, shank 2, knee 3, thigh 4, pelvis 5; −1 for
// others.
int level_of(const std::string& name, const std::string& site) {
  const std::string place = site.size() > 2 && site[1] == ':' ? site.substr(2) : "";
  const std::pair<const char*, int> sites[] = {{"asi", 5}, {"psi", 5}, {"kne", 3}, {"knm", 3},
                                               {"ank", 1}, {"med", 1}, {"hee", 1}, {"toe", 1},
                                               {"mt1", 1}, {"mt5", 1}, {"ttc", 2}, {"hfb", 2}};
  for (const auto& [known, level] : sites) {
    if (place == known) return level;
  }
  const std::string& bare = parse_marker_name(name).without_side;
  for (const auto& [start, level] : {std::pair{"*thi", 4}, {"*tib", 2}, {"*shank", 2}}) {
    if (bare.starts_with(start)) return level;
  }
  return -1;
}

std::vector<LegMarker> leg_of(const MarkerTrajectories& markers, Side side) {
  const std::vector<std::string> sites = marker_sites(markers.names);
  std::vector<LegMarker> leg;
  for (int m = 0; m < markers.marker_count(); ++m) {
    const std::string& name = markers.names[static_cast<std::size_t>(m)];
    if (parse_marker_name(name).side != side) continue;
    const int level = level_of(name, sites[static_cast<std::size_t>(m)]);
    if (level >= 0) leg.push_back({m, level});
  }
  return leg;
}

// In which part of the frames marker a is below b; 0 where they are seldom seen together.
double share_below(const MarkerTrajectories& markers, int a, int b, const Eigen::Vector3d& up) {
  int frames = 0, below = 0;
  for (int f = 0; f < markers.frame_count(); ++f) {
    const double d = up.dot(markers.position(f, a) - markers.position(f, b));
    if (!std::isfinite(d)) continue;
    ++frames;
    below += d < -kLeastHeight;
  }
  return 2 * frames >= markers.frame_count() ? static_cast<double>(below) / std::max(frames, 1)
                                             : 0.0;
}

// By how much the marker of the higher name lies below the other, in the mean [m].
double mean_height(const MarkerTrajectories& markers, const LegMarker& x, const LegMarker& y,
                   const Eigen::Vector3d& up) {
  const int high = x.level > y.level ? x.index : y.index;
  const int low = x.level > y.level ? y.index : x.index;
  double sum = 0.0;
  int frames = 0;
  for (int f = 0; f < markers.frame_count(); ++f) {
    const double d = up.dot(markers.position(f, low) - markers.position(f, high));
    if (!std::isfinite(d)) continue;
    sum += d;
    ++frames;
  }
  return sum / std::max(frames, 1);
}

struct Leg {
  std::vector<LegMarker> markers;
  std::vector<std::vector<bool>> below;  // by two of the markers

  // Pairs whose levels contradict their heights, with the levels of two exchanged.
  int contradictions(std::size_t x, std::size_t y) const {
    std::vector<int> levels;
    for (const LegMarker& marker : markers) levels.push_back(marker.level);
    std::swap(levels[x], levels[y]);
    int count = 0;
    for (std::size_t i = 0; i < markers.size(); ++i) {
      for (std::size_t k = 0; k < markers.size(); ++k)
        count += levels[i] > levels[k] && below[i][k];
    }
    return count;
  }
};

Leg look_at(const MarkerTrajectories& markers, Side side, const Eigen::Vector3d& up) {
  Leg leg{leg_of(markers, side), {}};
  const std::size_t n = leg.markers.size();
  leg.below.assign(n, std::vector<bool>(n, false));
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t k = 0; k < n; ++k) {
      if (leg.markers[i].level == leg.markers[k].level) continue;
      leg.below[i][k] =
          share_below(markers, leg.markers[i].index, leg.markers[k].index, up) >= kMostFrames;
    }
  }
  return leg;
}

}  // namespace

std::vector<Finding> find_order_faults(const MarkerTrajectories& markers,
                                       const LaboratoryAxes& axes) {
  std::vector<Finding> findings;
  if (!axes.up.known()) return findings;
  const std::array<Leg, 2> legs = {look_at(markers, Side::kLeft, axes.up.axis),
                                   look_at(markers, Side::kRight, axes.up.axis)};
  for (std::size_t side = 0; side < 2; ++side) {
    const Leg& leg = legs[side];
    const Leg& other = legs[1 - side];
    if (leg.markers.empty() || other.markers.empty()) continue;
    if (leg.contradictions(0, 0) == 0 || other.contradictions(0, 0) > 0) continue;
    // Of several, that which is farthest from what the names say: markers in between are about as
    // high as one of the two.
    std::pair<std::size_t, std::size_t> explain;
    double most = 0.0, next = 0.0;
    for (std::size_t x = 0; x < leg.markers.size(); ++x) {
      for (std::size_t y = x + 1; y < leg.markers.size(); ++y) {
        if (leg.contradictions(x, y) > 0) continue;
        const double height = mean_height(markers, leg.markers[x], leg.markers[y], axes.up.axis);
        if (height > most) {
          next = most;
          most = height;
          explain = {x, y};
        } else {
          next = std::max(next, height);
        }
      }
    }
    if (!(most > next + kLeastHeight / 2.0)) continue;
    const auto [x, y] = explain;
    const bool x_is_high = leg.markers[x].level > leg.markers[y].level;
    const auto name = [&](std::size_t i) {
      return markers.names[static_cast<std::size_t>(leg.markers[i].index)];
    };
    const std::string high = name(x_is_high ? x : y), low = name(x_is_high ? y : x);
    findings.push_back(whole_exchange(
        high, low, fmt::format("{} lies below {}, and not so on the other leg", high, low)));
  }
  return findings;
}

}  // namespace sinew
