#pragma once

#include <Eigen/Core>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "data/input_error.h"

namespace sinew {

/// Frames in rows, so that one frame lies together in memory.
using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// Named columns sampled at common times: what a MOT or STO file holds. Values keep the file's
/// units, because only a model knows which columns are angles; see dynamics/coordinate_table.h.
struct TimeTable {
  std::string name;                           // first header line
  std::vector<std::string> labels;            // one a column, without `time`
  Eigen::VectorXd time;                       // rows [s], non-decreasing
  RowMatrix values;                           // rows × labels; NaN where nothing was measured
  std::optional<bool> in_degrees;             // the header's inDegrees; empty where it is silent
  std::map<std::string, std::string> header;  // every other key=value line of the header

  /// Index of a column, or -1. Exact match.
  int find_column(const std::string& label) const;
};

/// A TimeTable as read, with where it came from and what was odd about it.
struct TimeTableFile {
  std::string path;
  TimeTable table;
  std::vector<Warning> warnings;
};

}  // namespace sinew
