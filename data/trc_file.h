#pragma once

#include <filesystem>

#include "data/marker_trajectories.h"

namespace sinew {

/// Reads a TRC file (marker trajectories, cells separated by tabs, or by blanks where no cell is
/// blank) and converts mm, cm or m to metres with one rounding: 617.2 mm is the double nearest to
/// 0.6172. The rate is the header's DataRate; frame numbers are kept as they are. A marker is not
/// measured, NaN, where a coordinate is blank or NaN in any case, and at exactly 0, 0, 0.
/// Warns where: NumFrames, NumMarkers or DataRate disagree with the file, markers have no name
/// (unnamed_1, ...) or an earlier one's (NAME_2, ...), names have no coordinates, samples are
/// at 0, 0, 0 or incomplete, rows end early at a whole marker.
/// Throws InputError for what cannot be used: no, empty, binary or cut file, a header without
/// DataRate, NumFrames, NumMarkers or known Units, names that fit no coordinates, no frames, a torn
/// row, a value that is no number, time that does not increase.
/// O(bytes) in time and memory, whatever the header promises.
MarkerFile read_trc(const std::filesystem::path& path);

/// Writes markers as TRC in millimetres, missing samples blank; atomic like write_storage. Reading
/// the file again gives the same bits. Throws InputError if the file cannot be written or if sizes
/// or names make no table.
void write_trc(const std::filesystem::path& path, const MarkerTrajectories& markers);

}  // namespace sinew
