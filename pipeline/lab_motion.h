#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "data/gap_filling.h"
#include "data/marker_trajectories.h"
#include "data/time_table.h"
#include "data/tool_setup.h"
#include "model/musculoskeletal_model.h"
#include "pipeline/decisions.h"

namespace sinew {

/// The low-pass that markers and forces share, so that neither is smoother than what it is weighed
/// against (Kristianslund, Krosshaug, van den Bogert 2012, J Biomech 45:666-671): 6 Hz for walking
/// (Winter 2009, sec. 3.4.4), 15 Hz where the pelvis, or the mean of all markers, goes faster than
/// 2.2 m/s, which is beyond where people break into a run.
Decision matched_cutoff(const MarkerTrajectories& markers);

/// Fills gaps in place, settling how; `model_file` tells which markers sit on one body. Writes the
/// list of gaps.
GapFillResult fill_lab_markers(MarkerTrajectories& markers, const std::string& path,
                               const std::filesystem::path& model_file,
                               const std::filesystem::path& filled_file, DecisionLog& log,
                               std::vector<Warning>& warnings);

/// The markers without samples that were not filled well enough for sizes to be fitted to them.
MarkerTrajectories well_filled(const MarkerTrajectories& markers, const GapFillResult& filled);

/// Filters in place, settling how: the cutoff [Hz], negative where nothing is filtered.
double filter_lab_markers(MarkerTrajectories& markers, const std::string& path, DecisionLog& log,
                          std::vector<Warning>& warnings);

/// Settles from and to: from the first frame to the last in which at least half of the model's
/// recorded markers are measured, and of those on the segment that all others hang from three, if
/// it ever has as many: before that and after it the whole body would turn with what little is
/// seen.
std::pair<double, double> settle_range(const MarkerTrajectories& markers,
                                       const MusculoskeletalModel& model, DecisionLog& log);

/// A task with weight 1 for every marker that model and recording share.
std::vector<IkTask> marker_tasks(const MarkerTrajectories& markers,
                                 const MusculoskeletalModel& model);

/// A task for every coordinate that these markers leave undetermined, which draws it to its
/// default. `weight` [1/rad²] stands beside a marker's, a task's beside the mean of the markers, so
/// that it is divided by the sum of their weights: files of tasks mean the same to OpenSim.
std::vector<IkTask> posture_tasks(const MarkerTrajectories& markers,
                                  const MusculoskeletalModel& model, double weight);
double default_posture_weight();

/// What inverse kinematics tracks: a task for every marker that model and recording share, with
/// weight 1, and one for every coordinate that these leave undetermined. That draws it to its
/// default, or in a trunk and a head without markers to where they are upright
/// (ik/upright_posture.h), as is settled.
struct LabTasks {
  std::vector<IkTask> tasks;
  std::optional<TimeTable> posture;  // for the tasks that take their values from a file [degrees]
};
LabTasks lab_tasks(const MarkerTrajectories& markers, const MusculoskeletalModel& model,
                   int threads, DecisionLog& log);

}  // namespace sinew
