#pragma once

#include <filesystem>

#include "data/tool_setup.h"

namespace sinew {

/// Writes forces and data file as an OpenSim 4 ExternalLoads document that read_external_loads and
/// OpenSim read. A data file in the same folder or below is named relative to it, so that the
/// folder can be moved. Atomic. Throws InputError if the file cannot be written.
void write_external_loads(const std::filesystem::path& path, const ExternalLoadsSetup& setup);

}  // namespace sinew
