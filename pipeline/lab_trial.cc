#include "pipeline/lab_trial.h"

#include <fmt/format.h>

#include <utility>

#include "data/force_table.h"
#include "pipeline/command.h"
#include "pipeline/ground_reaction.h"

namespace sinew {

C3dFile read_edited_c3d(const std::string& path, const PrepareOptions& options,
                        std::vector<Warning>& warnings) {
  C3dFile file = read_c3d(path);
  report(warnings, file.warnings);
  edit_recording(file, options.edit.edits());
  return file;
}

LabTrial read_lab_trial(const std::string& path, const PrepareOptions& options,
                        std::vector<Warning>& warnings) {
  LabTrial trial;
  trial.edits = options.edit.edits();
  trial.file = read_edited_c3d(path, options, warnings);
  ForcePlatforms platforms = compute_forces(trial.file, {.threshold = options.threshold});
  report(warnings, platforms.warnings);
  trial.plates = std::move(platforms.recordings);
  trial.turn = announce_turn(trial.file, trial.plates, options, warnings);
  rotate_vectors(trial.turn.R_MW, trial.file.markers.p_WM);
  for (ForcePlatformRecording& plate : trial.plates) rotate(plate, trial.turn.R_MW);
  return trial;
}

void condition_plates(std::vector<ForcePlatformRecording>& plates, const PrepareOptions& options) {
  for (ForcePlatformRecording& plate : plates) {
    condition(plate, {options.force_cutoff, options.rate, options.threshold});
  }
}

Turn announce_turn(const C3dFile& file, const std::vector<ForcePlatformRecording>& plates,
                   const PrepareOptions& options, std::vector<Warning>& warnings) {
  const Turn turn = find_turn(file.markers, file.path, file.screen, plates, options, warnings);
  fmt::print("{}: {}\n", file.path, describe(turn));
  return turn;
}

void require_c3d_part(const C3dFile& file, bool present, const std::string& part) {
  if (present) return;
  throw InputError({file.path}, {fmt::format("has no {}", part), "", "",
                                 "Choose another part with --what, or another file."});
}

FootAssignment assign_trial(const LabTrial& trial, const MusculoskeletalModel* model,
                            double threshold, const std::vector<AssignmentOverride>& overrides) {
  const MarkerTrajectories& markers = trial.file.markers;
  const FootAssignment assignment = assign_feet(markers, feet_of(markers, trial.file.path, model),
                                                trial.plates, threshold, overrides);
  for (const PlateContact& contact : assignment.contacts) {
    fmt::print("{}: {}\n", trial.file.path, describe(contact, assignment, trial.plates));
  }
  return assignment;
}

}  // namespace sinew
