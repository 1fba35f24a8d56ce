#pragma once

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "ik/minimizer_options.h"

/// What the benchmarks share.
namespace sinew {

// A run shorter than this is repeated, and the fastest repetition counts.
inline constexpr double kShortRun = 0.2;  // [s]
inline constexpr int kMostRepetitions = 20;

/// The names of a list separated by commas.
std::vector<std::string> names_in(const std::string& list);
/// The methods of such names, or every one for "all". Throws std::invalid_argument for a name that
/// is no method's.
std::vector<Method> methods_in(const std::vector<std::string>& names);
/// What a method can be run with, the Jacobian first.
std::vector<GradientKind> gradients_for(Method method);
/// `dgc` or `jacobian`.
const char* to_string(GradientKind gradient);

/// JSON has no numbers that are not finite: null.
nlohmann::ordered_json finite_or_null(double value);

/// Each adds one subcommand to `sinew bench`.
void add_bench_manipulator(CLI::App& bench, int& exit_code);
void add_bench_walk(CLI::App& bench, int& exit_code);

}  // namespace sinew
