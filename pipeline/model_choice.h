#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>

#include "model/musculoskeletal_model.h"
#include "pipeline/output_check.h"

namespace sinew {

/// The MODEL of a command: an .osim file, or one of the built-in bodies by name.
struct ModelChoice {
  std::string name;
  std::optional<double> height, mass;  // of a built-in body [m, kg]
  std::string sex;                     // male, female; empty: not given

  /// Adds the positional MODEL and --height, --mass, --sex.
  void add_to(CLI::App& command);

  /// Reads the file or builds the body. Throws InputError for a file that cannot be used and
  /// std::invalid_argument for sizes out of bounds or sizes given for a file.
  MusculoskeletalModel load() const;

  /// The model's file, for check_outputs(); empty for a built-in body.
  InputFiles files() const;
};

}  // namespace sinew
