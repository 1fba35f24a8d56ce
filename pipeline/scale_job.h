#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "data/marker_trajectories.h"
#include "data/scale_setup.h"
#include "data/verdict_reason.h"
#include "ik/auto_scale.h"
#include "ik/marker_placement.h"
#include "model/osim_document.h"
#include "model/scale_measurements.h"
#include "pipeline/output_check.h"

namespace sinew {

/// What `sinew scale` does by measurements and given factors: an OpenSim setup, or the same said on
/// the command line or by another command.
struct ScaleJob {
  ScaleSetup setup;
  // In place of the files that the setup names, e.g. out of a C3D file.
  std::optional<MarkerFile> static_trial;
  MarkerPlacementOptions placement;  // its range and movement come from the setup
};

/// What `sinew scale --auto` does.
struct AutoScaleJob {
  std::filesystem::path model_file;       // or the name of a built-in body
  std::filesystem::path marker_set_file;  // may be empty
  std::string name;                       // of the scaled model; empty: the model's own
  std::optional<double> mass;             // [kg]
  bool preserve_mass_distribution = false;
  std::vector<MarkerFile> trials;  // static and moving, in any order
  std::optional<double> from, to;  // of all trials [s]
  // Names of markers; without, those that are called so (data/marker_synonyms.h).
  std::optional<std::vector<std::string>> technical;
  AutoScaleOptions options;  // its technical_markers come from `technical`
};

/// A model fitted to a subject, and how.
struct ScaledModel {
  OsimDocument document;    // scaled, its markers placed
  std::string scaled_only;  // the document before markers were placed
  double mass_before = kNaN;
  std::vector<std::string> bodies;  // names, as factors.of_body
  ScaleFactors factors;
  std::vector<MeasuredScale> measurements;
  std::optional<MarkerPlacementResult> placement;
  std::optional<AutoScaleResult> automatic;
  std::vector<Warning> warnings;
  std::vector<VerdictReason> reasons;  // sizes and markers at or beyond SizeLimits
};

/// Whether a measurement applies, so that the scaler needs its marker_file.
bool needs_recording(const ModelScalerSetup& scaler);

/// Files that come from elsewhere than the setup.
struct ScaleJobFiles {
  bool model = false, marker_set = false, static_trial = false, coordinates = false;
};

/// Throws InputError at the setup's own line for a file that is needed and missing, unless it is
/// given otherwise; the message names the option that gives it.
void require_files(const ScaleSetup& setup, const ScaleJobFiles& given);

/// The files among the inputs, for check_outputs().
InputFiles input_files(const ScaleSetup& setup);

/// Reads, scales and places markers. Nothing is written. Throws InputError for unusable input.
ScaledModel run_scale(const ScaleJob& job);

/// Fits factors and marker offsets and applies them to the document. Check automatic->stopped.
/// Throws as read_osim() and auto_scale() do, and std::invalid_argument naming --technical for a
/// marker that the model does not have.
ScaledModel run_auto_scale(const AutoScaleJob& job);

/// The model of a file, or a built-in body by name, as a document.
OsimDocument open_model(const std::filesystem::path& file_or_name);

/// The factors of all bodies, ground too, as OpenSim's scale set has them.
ScaleSet applied_scales(const ScaledModel& scaled);

/// The static pose as a motion of one row, angles in degrees.
TimeTable static_motion(const MusculoskeletalModel& model, const MarkerPlacementResult& placement);

/// Tables for the terminal, and the same as JSON in SI units.
std::string scale_text(const ScaledModel& scaled);
nlohmann::ordered_json scale_json(const ScaledModel& scaled);

}  // namespace sinew
