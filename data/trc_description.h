#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace sinew {

/// What a TRC file says before its rows.
struct TrcDescription {
  std::vector<std::string> labels;  // of the markers, repeated or blank ones as they are
  double metres_per_unit = 1.0;     // of its lengths
};

/// Reads the header alone. Throws InputError as read_trc does.
TrcDescription read_trc_description(const std::filesystem::path& path);

}  // namespace sinew
