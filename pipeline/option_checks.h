#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace sinew {

// Checks of an option's value while the command line is read, so that nothing is computed first.
// Messages read `--name: <value> is not <what was expected>`.

CLI::Validator a_time();          // finite [s]
CLI::Validator more_than_zero();  // finite
CLI::Validator zero_or_more();    // finite
CLI::Validator a_thread_count();  // 0 to 1024
CLI::Validator a_stride();        // an integer, 1 or more
CLI::Validator a_start_count();   // 1 to 1000
CLI::Validator a_cutoff();        // positive [Hz], or negative for none

/// Names separated by commas; `none` is no name.
std::vector<std::string> split_names(std::string_view text);

}  // namespace sinew
