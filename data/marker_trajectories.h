#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "data/input_error.h"
#include "data/time_table.h"

namespace sinew {

/// Trajectories of skin markers in the laboratory's frame.
struct MarkerTrajectories {
  std::vector<std::string> names;  // one a marker, unique
  double rate = 0.0;               // [Hz]
  std::vector<int> frame_numbers;  // as the file numbers them
  Eigen::VectorXd time;            // frames [s], strictly increasing
  RowMatrix p_WM;  // frames × 3·markers: x, y, z of marker 0, of marker 1, ... [m];
                   // NaN = not measured (all three of a marker, or none)

  int marker_count() const { return static_cast<int>(names.size()); }
  int frame_count() const { return static_cast<int>(time.size()); }
  bool operator==(const MarkerTrajectories&) const = default;

  Eigen::Vector3d position(int frame, int marker) const {
    return p_WM.row(frame).segment<3>(3 * marker).transpose();
  }
  /// Index of a marker, or -1. Exact match.
  int find_marker(const std::string& name) const;
};

struct MarkerFile {
  std::string path;
  MarkerTrajectories markers;
  std::vector<Warning> warnings;
};

}  // namespace sinew
