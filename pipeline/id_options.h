#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <optional>
#include <string>

#include "dynamics/inverse_dynamics.h"

namespace sinew {

/// The command-line options that every subcommand with inverse dynamics shares.
struct IdOptions {
  std::string loads, load_data;
  std::optional<double> cutoff;  // [Hz]
  std::string force_spikes = "auto";
  bool project_couplers = false, exact_custom_joints = false;

  void add_to(CLI::App& command);
  /// The cutoff given, else that of a setup, else kDefaultCutoff.
  InverseDynamicsOptions dynamics(std::optional<double> setup_cutoff, int threads) const;
};

/// `low-passed at 6 Hz` or `not filtered`.
std::string filter_text(double cutoff);

}  // namespace sinew
