#include "pipeline/output_check.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cmath>
#include <cstring>
#include <set>
#include <stdexcept>
#include <system_error>

#include "data/input_error.h"

namespace sinew {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void refuse(const fs::path& output, std::string problem, std::string remedy) {
  throw InputError({output.string()}, {std::move(problem), "", "", std::move(remedy)});
}

// The folder that exists already, in which the output or its first missing folder will be made.
void check_folder(const fs::path& output) {
  std::error_code ignored;
  fs::path folder = fs::absolute(output, ignored).lexically_normal().parent_path();
  while (!fs::exists(folder, ignored) && folder.has_relative_path()) folder = folder.parent_path();
  if (!fs::is_directory(folder, ignored)) {
    refuse(output, fmt::format("cannot be written: {} is a file, not a folder", folder.string()),
           "Choose another path.");
  }
  if (::access(folder.c_str(), W_OK | X_OK) != 0) {
    refuse(output,
           fmt::format("cannot be written: folder {}: {}", folder.string(), std::strerror(errno)),
           "Choose another path, or change the folder's permissions.");
  }
}

void check_output(const fs::path& output, const InputFiles& inputs) {
  std::error_code ignored;
  if (fs::is_directory(output, ignored)) {
    refuse(output, "is a folder, where the output file should go", "Name a file in it.");
  }
  for (const auto& [role, input] : inputs) {
    if (!input.empty() && fs::equivalent(input, output, ignored)) {
      refuse(output, fmt::format("is both the output and an input ({})", role),
             "Choose another output, so that the input is kept.");
    }
  }
  check_folder(output);
}

}  // namespace

void check_outputs(const std::vector<fs::path>& outputs, const InputFiles& inputs) {
  std::set<fs::path> places;
  for (const fs::path& output : outputs) {
    if (output.empty()) continue;
    check_output(output, inputs);
    std::error_code ignored;
    if (!places.insert(fs::weakly_canonical(fs::absolute(output), ignored)).second) {
      refuse(output, "is two outputs at once", "Choose another name for one of them.");
    }
  }
}

void require_finite_results(const TimeTable& table, const std::string& what) {
  if (table.values.allFinite()) return;
  for (Eigen::Index row = 0; row < table.values.rows(); ++row) {
    for (Eigen::Index column = 0; column < table.values.cols(); ++column) {
      if (std::isfinite(table.values(row, column))) continue;
      throw std::runtime_error(fmt::format(
          "{}: '{}' at {:.6g} s came out as {}; nothing was written. Look for an error in the "
          "model or for values without measure in the inputs near that time",
          what, table.labels[static_cast<std::size_t>(column)], table.time[row],
          table.values(row, column)));
    }
  }
}

}  // namespace sinew
