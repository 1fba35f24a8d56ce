#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "data/carried_mass.h"
#include "data/load_coverage.h"
#include "data/verdict_reason.h"
#include "ik/auto_scale.h"
#include "pipeline/decisions.h"
#include "pipeline/id_options.h"
#include "pipeline/ik_options.h"
#include "pipeline/lab_options.h"

namespace sinew {

/// A laboratory's files made ready: what `sinew run` does with a model, markers and loads follows.
struct LabJob {
  IkOptions ik;  // name the files that were written
  IdOptions dynamics;
  InputFiles inputs;                     // the laboratory's own
  std::optional<LoadCoverage> coverage;  // by frame of the markers; none where nothing tells
  std::optional<StrideMass> carried;     // by the platforms over whole strides
  std::optional<double> standing_mass;   // that they carry in the static trial [kg]
  std::vector<VerdictReason> reasons;    // of the static trial, the mass and the fit of sizes
  double marker_cutoff = -1.0;           // [Hz]; negative: not filtered
  std::optional<AutoScaleResult> fit;    // of the model to static trial and walk
};

/// Files that prepare_lab() writes into the results' folder, for check_outputs().
std::vector<std::filesystem::path> lab_outputs(const std::filesystem::path& folder);

/// Reads a trial, settles everything that has to be chosen, prints each decision, and writes
/// model, markers, forces, tasks and setups into `folder`, from which `sinew ik` and `sinew id`,
/// or OpenSim's tools, repeat the steps. Throws InputError for unusable input and
/// std::invalid_argument naming options that do not fit.
LabJob prepare_lab(const LabOptions& options, IkOptions ik, IdOptions dynamics,
                   const std::filesystem::path& folder, DecisionLog& log,
                   std::vector<Warning>& warnings);

/// Writes decisions.json: the log, inputs with their SHA-256 and paths relative to the folder where
/// they can be, and the options given.
void write_decisions(const std::filesystem::path& file, const DecisionLog& log,
                     const InputFiles& inputs, const nlohmann::ordered_json& options);

}  // namespace sinew
