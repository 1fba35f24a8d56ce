#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <string>
#include <vector>

#include "data/input_error.h"

namespace sinew {

// Exit codes of every subcommand.
constexpr int kExitOk = 0;
constexpr int kExitFailed = 1;    // what was asked could not be done, or a comparison failed
constexpr int kExitBadInput = 2;  // wrong usage or unusable input

/// Low-pass of coordinates where neither option nor setup says otherwise [Hz]: what gait
/// laboratories use for walking (Winter 2009, sec. 3.4.4).
constexpr double kDefaultCutoff = 6.0;

/// Each adds one subcommand to the command line. When the user chose it, `exit_code` is set by
/// running it; errors come out as InputError or CLI::Error.
void add_run_command(CLI::App& app, int& exit_code);
void add_ik_command(CLI::App& app, int& exit_code);
void add_id_command(CLI::App& app, int& exit_code);
void add_validate_command(CLI::App& app, int& exit_code);
void add_example_command(CLI::App& app, int& exit_code);
void add_bench_command(CLI::App& app, int& exit_code);
void add_check_command(CLI::App& app, int& exit_code);
void add_convert_command(CLI::App& app, int& exit_code);
void add_model_command(CLI::App& app, int& exit_code);
void add_scale_command(CLI::App& app, int& exit_code);
void add_compare_command(CLI::App& app, int& exit_code);

/// Appends the warnings that are not in `all` yet (readers share some) and prints these to standard
/// error, one a line: files without their folders, and of several that differ in names and numbers
/// only the first, with how many more there are.
void report(std::vector<Warning>& all, const std::vector<Warning>& more);

/// The lines that report() prints of these.
std::vector<std::string> warning_lines(const std::vector<Warning>& warnings);

/// A progress bar on standard error, `what: 3 of 200 steps`, that appears only after two seconds,
/// and stops work on Ctrl-C: returns false then. Calls watch_interrupts().
std::function<bool(int done, int total)> progress_bar(std::string what,
                                                      std::string steps = "frames");

/// From here on Ctrl-C asks for a stop instead of ending the process; a second one ends it. Outputs
/// that are being written are completed.
void watch_interrupts();
bool interrupted();

}  // namespace sinew
