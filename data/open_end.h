#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "data/input_error.h"

namespace sinew {

/// Warns of a table of numbers as text that ends in a number instead of a line's end or a blank. If
/// the file was cut there, the number lacks digits, and nothing else tells. O(1).
void warn_of_open_end(const std::string& path, std::string_view content,
                      std::vector<Warning>& warnings);

}  // namespace sinew
