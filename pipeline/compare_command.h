#pragma once

#include <CLI/CLI.hpp>

namespace sinew {

/// `sinew compare`: how far the columns of a table are from those of another. See command.h.
void add_compare_command(CLI::App& app, int& exit_code);

}  // namespace sinew
