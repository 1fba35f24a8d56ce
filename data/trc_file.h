#pragma once

#include <filesystem>

#include "data/marker_trajectories.h"

namespace sinew {

/// Reads a TRC file (tab-separated marker trajectories) and converts mm, cm or m to metres.
/// Blank cells, NaN in any case and a marker at exactly 0,0,0 in a file that otherwise leaves that
/// cell for missing samples become NaN. Throws InputError for what cannot be used; see the tests
/// of malformed files for the complete list.
MarkerFile read_trc(const std::filesystem::path& path);

/// Writes markers as TRC in millimetres, missing samples blank; atomic like write_storage.
void write_trc(const std::filesystem::path& path, const MarkerTrajectories& markers);

}  // namespace sinew
