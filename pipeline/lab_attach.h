#pragma once

#include <filesystem>

#include "data/marker_trajectories.h"
#include "model/musculoskeletal_model.h"
#include "pipeline/decisions.h"
#include "pipeline/lab_options.h"

namespace sinew {

/// Files and trials of attach_lab_markers(). Both trials have the model's marker names; `standing`
/// may be null.
struct LabAttachment {
  const MarkerTrajectories* walk = nullptr;
  const MarkerTrajectories* standing = nullptr;
  std::filesystem::path model_file;   // scaled; gets the markers
  std::filesystem::path marker_file;  // for the markers alone, as OpenSim's <MarkerSet>
};

/// Gives the model markers for those of the walk that have no name in it but keep their distances
/// to one of its bodies (ik/marker_attachment.h), or, in groups of three or more, to each other,
/// with a joint that stays with its neighbour (ik/marker_clusters.h). What a program computed, and
/// what nobody named, is left out (data/computed_points.h). Places are those of the static trial
/// where the marker was measured there, else the mean of the walk. Each marker is a decision
/// `attach NAME`, whose value is a body or empty. Writes both files where there is such a marker.
/// Throws InputError for a body that the model does not have, std::invalid_argument for --attach
/// that is not NAME=BODY with a recorded name.
void attach_lab_markers(const LabAttachment& job, const LabOptions& options, int threads,
                        DecisionLog& log);

}  // namespace sinew
