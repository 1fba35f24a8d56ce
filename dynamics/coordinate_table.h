#pragma once

#include <numbers>
#include <string>
#include <vector>

#include "data/input_error.h"
#include "data/time_table.h"
#include "model/musculoskeletal_model.h"

namespace sinew {

/// No joint turns once around; a heading may, hardly twice [rad].
constexpr double kLargestRadians = 2.0 * std::numbers::pi;
/// Inverse kinematics without bounds may pass a range by some degrees, not by this much [rad].
constexpr double kRangeMargin = 20.0 * std::numbers::pi / 180.0;

/// A motion in the model's own terms.
struct CoordinateTable {
  std::string path;            // of the file it came from, for messages
  Eigen::VectorXd time;        // frames [s], strictly increasing
  RowMatrix q;                 // frames × the model's coordinates, in its order [rad or m]
  std::vector<bool> measured;  // per coordinate: the file had it; else q holds the default value
  std::vector<Warning> warnings;
};

/// Finds the model's coordinates among a table's columns and converts angles to radians.
///
/// A column belongs to a coordinate if its label is the coordinate's name or OpenSim 4's path to
/// its value, `.../<joint>/<coordinate>/value`. A coordinate without a column stays at its default
/// value and is named in a warning, as is every column that is no coordinate (speeds and states of
/// a states file are counted, not named).
///
/// Where the header does not say inDegrees, the values do, with a warning: degrees if any angle is
/// beyond ±2π, or if two or more columns, read as radians, leave their coordinates' ranges by more
/// than 20°; else radians. (One column may: a heading has no range that anyone keeps.) OpenSim goes
/// by the ending: a .mot without a version is in degrees, everything else in radians.
///
/// Coordinates that only drive functions are in their own unit even in a file in degrees, as
/// OpenSim 4 writes them. OpenSim before 4.0 wrote them in degrees too: where a coupler sets the
/// coordinate and the column is closer to it in degrees, it is taken so, with a warning.
///
/// Two rows at one time are dropped to one if they are identical, with a warning.
/// Throws InputError for no rows, no column that is a coordinate, two columns for one coordinate,
/// a value that is not finite (row and column), and different rows at one time.
CoordinateTable coordinate_table(const MusculoskeletalModel& model, const TimeTableFile& file);

}  // namespace sinew
