#pragma once

#include <CLI/CLI.hpp>

namespace sinew {

/// As the functions in command.h: adds `sinew scale`.
void add_scale_command(CLI::App& app, int& exit_code);

}  // namespace sinew
