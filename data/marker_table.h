#pragma once

#include "data/marker_trajectories.h"

namespace sinew {

/// Markers as a table: columns NAME.x, NAME.y, NAME.z [m], NaN where not measured.
TimeTable marker_table(const MarkerTrajectories& markers);

/// The reverse. Columns come in threes of one name that end in x, y, z or 1, 2, 3 behind `.`, `_`,
/// `:`, `-` or a blank; ` [mm]`, ` [cm]` or ` [m]` behind that is their unit, metres without.
/// Frames are numbered from 1; the rate is that of all steps in the mean.
/// Throws InputError for fewer than two rows, a column that belongs to no three, times that repeat,
/// and positions of which only one or two coordinates are there.
MarkerFile markers_from_table(const TimeTableFile& file);

/// Metres in the unit that the first label names.
double metres_per_unit(const TimeTable& table);

/// Whether every column belongs to three of one name, as markers_from_table needs them.
bool holds_markers(const TimeTable& table);

}  // namespace sinew
