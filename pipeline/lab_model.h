#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "data/force_platform.h"
#include "data/marker_trajectories.h"
#include "data/subject_parameters.h"
#include "data/verdict_reason.h"
#include "ik/auto_scale.h"
#include "model/musculoskeletal_model.h"
#include "pipeline/decisions.h"
#include "pipeline/lab_options.h"

namespace sinew {

/// The generic model: a file as it is, or a built-in body of the options' mass and sex and of a
/// height that is settled. What is no file as it is, a built-in body or a model to which a marker
/// set was added (the options', or that of their ScaleTool setup), is written to `folder`. Throws
/// as read_osim(), OsimDocument::merge_markers() and WholeBodyOptions::validate() do, InputError
/// for a model without markers, and std::invalid_argument for sizes given for a file.
struct GenericModel {
  std::filesystem::path file;
  bool built_in = false;
  MusculoskeletalModel model;
};
GenericModel generic_model(const std::string& name, const SubjectParameters& entered,
                           const LabOptions& options, const std::filesystem::path& folder,
                           DecisionLog& log);

/// The subject's model, and how it was made.
struct SettledModel {
  MusculoskeletalModel model;          // as it is read back from its file
  std::string by;                      // what it is scaled by: the decision `scaling`
  std::optional<double> mass;          // that was settled [kg]; none: the model's own
  std::optional<AutoScaleResult> fit;  // where markers were fitted
  std::vector<VerdictReason> reasons;  // of sizes and markers at their limits
};

/// Scales the generic model to the subject and writes `file`: by an OpenSim setup, by the static
/// trial and the walk, by one of them, by the mass alone, or not at all, as is settled. `standing`
/// may be null; both recordings have the model's marker names; `entered` is what the trial's file
/// says.
SettledModel settle_model(const GenericModel& generic, const MarkerFile& walk,
                          const MarkerFile* standing,
                          const std::vector<ForcePlatformRecording>& standing_plates,
                          const SubjectParameters& entered, const LabOptions& options, int threads,
                          const std::filesystem::path& file, DecisionLog& log,
                          std::vector<Warning>& warnings);

}  // namespace sinew
