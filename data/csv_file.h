#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "data/input_error.h"
#include "data/time_table.h"

namespace sinew {

/// Reads a table of comma-separated values (RFC 4180; semicolons and tabs are told from the first
/// line, and a comma is then taken as the decimal point). The first line holds the labels; one
/// column is the time in seconds: `time`, `t`, `time_s` or `time [s]`, in any case. Blank cells are
/// NaN. A UTF-8 byte order mark is skipped. Warns where cells are blank, labels repeat or the last
/// row has no line end. Throws InputError, naming line and column, for no,
/// empty or binary file, no or two time columns, a row that does not fit the labels, a value that
/// is no number, decreasing time, an open quote. O(bytes).
TimeTableFile read_csv(const std::filesystem::path& path);

/// Writes `time` and the columns, numbers so that they round-trip exactly, NaN as blank cells.
/// Labels with commas, quotes or blanks at their ends are quoted. Atomic like write_storage.
/// Throws InputError if the file cannot be written or if sizes or labels make no table.
void write_csv(const std::filesystem::path& path, const TimeTable& table);

/// A cell as RFC 4180 has it: quoted if need be.
std::string csv_cell(const std::string& text);

/// The cells of a line, without their quotes and the blanks around them. A record ends with its
/// line: cells hold no line breaks. Throws InputError at `at` for an open quote.
std::vector<std::string> csv_cells(const SourceLocation& at, std::string_view line,
                                   char separator = ',');

}  // namespace sinew
