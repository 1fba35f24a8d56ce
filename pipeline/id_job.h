#pragma once

#include <filesystem>
#include <vector>

#include "dynamics/external_loads.h"
#include "dynamics/inverse_dynamics.h"
#include "model/musculoskeletal_model.h"

namespace sinew {

/// Reads an ExternalLoads setup and its data. An empty path gives no loads and a warning that the
/// root's residuals will carry the body's weight.
ExternalLoads read_loads(const MusculoskeletalModel& model, const std::filesystem::path& setup_file,
                         std::filesystem::path& data_file, std::vector<Warning>& warnings);

}  // namespace sinew
