#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "data/time_table.h"

namespace sinew {

/// Reads an OpenSim MOT or STO file: OpenSim's headers without a version, of versions 1 to 3 and
/// SIMM's (`datacolumns`, `datarows`, `range`), columns in any order, separated by tabs or blanks.
/// Tables of vectors (DataType=Vec3, SpatialVec, ...) come out flat, with OpenSim's suffixes.
/// Blank cells between tabs are NaN.
/// Warns where: a row or column count disagrees with the header, labels or time stamps repeat,
/// cells are blank, the last row has no end. Throws InputError for: no such file, empty or binary
/// file, a header count or inDegrees that says nothing, an unknown DataType, no `endheader`, no
/// column line, no `time` column or two of them, a torn row, a value that is no number, decreasing
/// time. O(bytes) in time and memory, whatever the header promises.
TimeTableFile read_storage(const std::filesystem::path& path);

/// Only the column labels that read_storage would give. Throws as read_storage does for the header
/// and the label line.
std::vector<std::string> read_storage_labels(const std::filesystem::path& path);

/// Writes the format that OpenSim 4 writes for motions (version=1, nRows, nColumns, inDegrees if
/// the table says, endheader, tabs); every number round-trips exactly. Written under a temporary
/// name and renamed when complete. Throws InputError if the file cannot be written or if sizes,
/// labels or names make no table.
void write_storage(const std::filesystem::path& path, const TimeTable& table);

}  // namespace sinew
