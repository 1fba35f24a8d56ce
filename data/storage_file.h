#pragma once

#include <filesystem>

#include "data/time_table.h"

namespace sinew {

/// Reads an OpenSim MOT or STO file: OpenSim's old and new headers and SIMM's (`datacolumns`,
/// `datarows`, `range`), columns in any order, blanks and tabs alike. A row or column count that
/// disagrees with the header is a warning with both numbers.
/// Throws InputError for: no such file, empty or binary file, no `endheader`, no column line, no
/// `time` column, a torn row, a value that is no number, decreasing time.
TimeTableFile read_storage(const std::filesystem::path& path);

/// Writes OpenSim's current STO/MOT format (version=1, nRows, nColumns, inDegrees, endheader);
/// every number round-trips exactly. Written under a temporary name and renamed when complete.
/// Throws InputError if the file cannot be written.
void write_storage(const std::filesystem::path& path, const TimeTable& table);

}  // namespace sinew
