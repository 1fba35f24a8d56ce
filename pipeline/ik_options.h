#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>

#include "data/tool_setup.h"
#include "pipeline/ik_job.h"

namespace sinew {

/// The command-line options that every subcommand with inverse kinematics shares.
struct IkOptions {
  std::string model, markers, tasks, coordinates, filled, trace;
  double filled_weight = kFilledWeight;
  std::string spikes = "auto";
  std::optional<double> from, to;
  std::string method = IkInputs{}.method;
  double tolerance = IkInputs{}.tolerance;
  int starts = ColdStartOptions{}.starts;
  std::string wires = "auto";
  WireOptions wire_options;
  int threads = 0;

  void add_to(CLI::App& command);
  /// Reads the task file, if one was given.
  IkInputs inputs() const;
  /// Throws std::invalid_argument naming the option if model or markers are missing.
  void require_files(const IkInputs& inputs) const;
};

/// Fills what the command line left open from a setup. Throws InputError at the setup's line for a
/// file that does not exist and was not given on the command line.
void merge(const IkSetup& setup, IkInputs& inputs);

}  // namespace sinew
