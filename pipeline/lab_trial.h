#pragma once

#include <string>
#include <vector>

#include "data/c3d_file.h"
#include "data/foot_assignment.h"
#include "data/force_platform.h"
#include "data/recording_edits.h"
#include "model/musculoskeletal_model.h"
#include "pipeline/laboratory.h"
#include "pipeline/prepare_options.h"

namespace sinew {

/// A C3D file and what its force platforms measured, both in a model's axes: y up, x forward.
struct LabTrial {
  C3dFile file;  // markers are turned, parameters and computed trajectories are not
  std::vector<ForcePlatformRecording> plates;  // turned; not filtered yet
  Turn turn;
  RecordingEdits edits;  // what was put right in the file before
};

/// Reads a C3D file whole and puts it right as the options say (pipeline/edit_options.h).
C3dFile read_edited_c3d(const std::string& path, const PrepareOptions& options,
                        std::vector<Warning>& warnings);

/// Reads the file so, computes forces, turns both and reports warnings. Throws InputError as
/// read_c3d and find_turn do.
LabTrial read_lab_trial(const std::string& path, const PrepareOptions& options,
                        std::vector<Warning>& warnings);

/// Filters and resamples forces and moments as the options say (data/force_table.h).
void condition_plates(std::vector<ForcePlatformRecording>& plates, const PrepareOptions& options);

/// Finds the turn of a file and prints it in a line.
Turn announce_turn(const C3dFile& file, const std::vector<ForcePlatformRecording>& plates,
                   const PrepareOptions& options, std::vector<Warning>& warnings);

/// Throws InputError if the file lacks a part that was asked for: `markers`, ...
void require_c3d_part(const C3dFile& file, bool present, const std::string& part);

/// Which foot of the model, or by names of markers where it is null, stands on the trial's
/// platforms, with conditioned plates; a line a contact is printed.
FootAssignment assign_trial(const LabTrial& trial, const MusculoskeletalModel* model,
                            double threshold, const std::vector<AssignmentOverride>& overrides);

}  // namespace sinew
