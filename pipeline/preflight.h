#pragma once

#include <string>
#include <vector>

#include "data/c3d_file.h"
#include "data/finding.h"
#include "data/force_platform.h"
#include "data/marker_trajectories.h"
#include "data/numbers.h"
#include "data/time_table.h"
#include "model/musculoskeletal_model.h"

namespace sinew {

/// A recording to look at, as its file has it: not turned, filled or filtered. What is pointed to
/// must outlive the call.
struct PreflightRecording {
  std::string path;
  const MarkerTrajectories* markers = nullptr;  // null: it has none
  double metres_per_unit = 1.0;                 // of the lengths that the file names
  std::vector<std::string> labels;              // of the markers as the file has them
  const C3dFile* c3d = nullptr;                 // where it is one: platforms, events, screen
  const TimeTable* table = nullptr;             // forces in columns NAME_vx, ..., NAME_px, ...
  std::vector<Warning> warnings;                // of reading it
};

/// Of files that were read whole.
PreflightRecording preflight_recording(const C3dFile& file);
PreflightRecording preflight_recording(const MarkerFile& file, double metres_per_unit = 1.0,
                                       std::vector<std::string> labels = {});
PreflightRecording preflight_recording(const TimeTableFile& file);

struct PreflightInputs {
  std::vector<PreflightRecording> recordings;
  int standing = -1;  // index of the static trial that the others are scaled by; −1: none is known
  const MusculoskeletalModel* model = nullptr;
  std::string model_path;
  // Below this a platform carries nothing [N].
  double threshold = kContactForce;
};

/// What would spoil a run, found before anything is solved: findings by recording, in the order of
/// `recordings`, errors first. Tables of forces are held against the markers of the recording
/// before them, or else the first one after. Prints nothing. The checks and what mends each are
/// listed in README.md. O(frames · markers) and O(samples), a second for a minute of walking.
std::vector<Finding> run_preflight(const PreflightInputs& inputs);

}  // namespace sinew
