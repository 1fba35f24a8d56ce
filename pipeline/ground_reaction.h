#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "data/foot_assignment.h"
#include "model/musculoskeletal_model.h"

namespace sinew {

/// Feet as a model has them: the markers on bodies calcn, toes, foot or talus of a side that the
/// recording has too; loads act on the calcaneus, or the first of these. By names of markers where
/// the model has none. Throws InputError naming the recording if that gives no foot.
std::vector<Foot> feet_of(const MarkerTrajectories& markers, const std::string& path,
                          const MusculoskeletalModel* model);

/// Reads `--assign` options; throws std::invalid_argument for what is none and for two that give
/// one platform and time to different feet. Of those that overlap otherwise the later goes first.
std::vector<AssignmentOverride> parse_overrides(const std::vector<std::string>& texts);

/// Writes the feet's loads (.mot), the ExternalLoads that name them (.xml) and the list of contacts
/// (.csv, beside the loads: NAME_contacts.csv).
void write_ground_reactions(const FootAssignment& assignment,
                            const std::vector<ForcePlatformRecording>& plates,
                            const TimeTable& loads, const std::filesystem::path& data_file,
                            const std::filesystem::path& setup_file);

/// NAME_contacts.csv beside the loads.
std::filesystem::path contacts_path(const std::filesystem::path& data_file);

}  // namespace sinew
