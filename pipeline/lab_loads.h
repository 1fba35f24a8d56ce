#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "data/load_coverage.h"
#include "model/musculoskeletal_model.h"
#include "pipeline/decisions.h"
#include "pipeline/lab_options.h"
#include "pipeline/lab_trial.h"

namespace sinew {

/// Whether any of the platforms measures forces and moments.
bool has_platforms(const std::vector<ForcePlatformRecording>& plates);

/// Filters the platforms' forces and settles which foot stands on which and when, one decision a
/// contact. `markers` have the model's names. Throws as feet_of does.
FootAssignment settle_contacts(std::vector<ForcePlatformRecording>& plates,
                               const MarkerTrajectories& markers, const std::string& path,
                               const MusculoskeletalModel& model, double threshold,
                               double marker_cutoff, const LabOptions& options, DecisionLog& log);

/// load_coverage.csv: a row a frame: what is known of each foot's loads.
std::string load_coverage_csv(const LoadCoverage& coverage, const Eigen::VectorXd& time);

/// Adds a column FOOT_loads_complete, 1 or 0, for each foot to a table whose rows are the frames
/// from `first` on.
void mark_coverage(const LoadCoverage& coverage, int first, TimeTable& table);

/// The part of summary.json: complete frames and times of each foot, and the residuals at the root
/// apart for frames in which all loads are known and the others.
nlohmann::ordered_json coverage_summary(const LoadCoverage& coverage, int first,
                                        const MusculoskeletalModel& model,
                                        const TimeTable& torques);

}  // namespace sinew
