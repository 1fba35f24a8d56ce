#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "data/time_table.h"

namespace sinew {

/// Input files with what each is, such as `model` or `load_data`; paths may be empty.
using InputFiles = std::vector<std::pair<std::string, std::filesystem::path>>;

/// Asks before any work is done whether outputs can be written; empty paths are left out. Throws
/// InputError naming the output that is a folder, one of the inputs or another output, or whose
/// folder is a file or cannot be written. What the system refuses only later is told when the file
/// is written.
void check_outputs(const std::vector<std::filesystem::path>& outputs, const InputFiles& inputs);

/// Throws std::runtime_error naming the first column and time where `table` is not finite, so that
/// no NaN is ever written as a result. `what`: `ik.mot`, …
void require_finite_results(const TimeTable& table, const std::string& what);

}  // namespace sinew
