#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "pipeline/decisions.h"
#include "pipeline/edit_options.h"
#include "pipeline/id_options.h"
#include "pipeline/ik_options.h"
#include "pipeline/output_check.h"

namespace sinew {

/// The options of `sinew run` about a laboratory's own files; IkOptions and IdOptions beside them
/// hold the model, tasks, time range, loads and the coordinates' filter.
struct LabOptions {
  std::string c3d, static_trial, marker_set, map, scale_setup, decisions;
  std::string scale, subject, technical, up, forward, sex, posture;
  std::optional<double> height, mass;                 // [m, kg]
  std::optional<double> max_gap, threshold;           // [s, N]
  std::optional<double> marker_cutoff, force_cutoff;  // [Hz]; negative: none
  std::optional<double> posture_weight;               // [1/rad²]
  std::optional<bool> fill_rigid;
  bool no_scale = false;
  EditOptions edit;  // of the walk; the unit of both trials
  std::vector<std::string> assign, attach;
  bool no_attach = false;
  std::set<std::string> given_now;  // options of this command line, not of the run it repeats

  void add_to(CLI::App& command);
  /// Throws std::invalid_argument naming options that do not go together.
  void validate() const;
  /// Throws std::invalid_argument naming options of add_to() that were given, where there is no
  /// trial that they could be for.
  static void require_none(const CLI::App& command);
};

/// Makes options of the run that is repeated those of this one, unless they are given anew: sets
/// them on the command line as if they had been typed, and inputs with them. Returns the names of
/// the options that were given now.
std::set<std::string> take_replayed_options(CLI::App& command, const DecisionLog& log);

/// Tells the log what the options say.
void say_options(const CLI::App& command, const std::set<std::string>& now, DecisionLog& log);

/// The options as they stand on the command line, without files, output and what no result depends
/// on: for decisions.json.
nlohmann::ordered_json given_options(const CLI::App& command);

}  // namespace sinew
