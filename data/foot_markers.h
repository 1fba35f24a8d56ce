#pragma once

#include <array>
#include <vector>

#include "data/marker_names.h"
#include "data/marker_trajectories.h"

namespace sinew {

/// Markers of one side's foot by their names, as indices; those that are measured at all.
struct FootMarkers {
  std::vector<int> heel;  // or, without one, the ankle
  std::vector<int> toe;   // tips and metatarsal heads
  std::vector<int> all;   // those two, ankle and whatever else sits on the foot

  bool has_ends() const { return !heel.empty() && !toe.empty(); }
};

/// Left and right.
struct FeetMarkers {
  FootMarkers left, right;
  const FootMarkers& of(Side side) const { return side == Side::kLeft ? left : right; }
};

FeetMarkers find_foot_markers(const MarkerTrajectories& markers);

/// Markers of the pelvis, of either side.
std::vector<int> find_pelvis_markers(const MarkerTrajectories& markers);

/// Mean of the positions of those of `which` that are measured in a frame; NaN if none is.
Eigen::Vector3d mean_position(const MarkerTrajectories& markers, int frame,
                              const std::vector<int>& which);

/// From heel to toe in a frame, mean of both feet, seen along `up`, of length 1: where the subject
/// faces, whatever the names say about left and right. Zero if no foot has both.
Eigen::Vector3d facing_in(const MarkerTrajectories& markers, int frame, const FeetMarkers& feet,
                          const Eigen::Vector3d& up);
/// The mean of that over all frames; shorter the more it turns.
Eigen::Vector3d mean_facing(const MarkerTrajectories& markers, const FeetMarkers& feet,
                            const Eigen::Vector3d& up);

/// The mean way over the record of the markers that span at least half of it, seen along `up` [m].
Eigen::Vector3d way_travelled(const MarkerTrajectories& markers, const Eigen::Vector3d& up);

}  // namespace sinew
