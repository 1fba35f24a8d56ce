#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "data/recording_edits.h"
#include "pipeline/recording.h"

namespace sinew {

/// The command-line options that put a recording right, as `sinew check` names them.
struct EditOptions {
  std::string unit;
  std::vector<std::string> swaps, drops, renames, unloaded, samples;
  bool swap_sides = false;
  double shift_forces = 0.0;  // [s]

  void add_to(CLI::App& command);
  /// Throws std::invalid_argument, naming option and form, for a text that is none.
  RecordingEdits edits() const;
};

/// Edits markers or a table that is no C3D file's; a table's times are shifted. Throws
/// std::invalid_argument for options that do not apply to it.
void apply(const RecordingEdits& edits, Recording& recording);

}  // namespace sinew
