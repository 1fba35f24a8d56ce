#pragma once

#include <filesystem>
#include <string>

#include "model/musculoskeletal_model.h"

namespace sinew {

/// Reads an OpenSim model of any document version from 1.x to 4.x (10901 … 40600).
/// Elements that Sinew does not treat are listed in `unsupported`, with a warning where they would
/// change a result. Throws InputError naming file, line and element for everything that cannot be
/// used; see the tests of malformed models for the complete list.
MusculoskeletalModel read_osim(const std::filesystem::path& path);

/// As read_osim, from a document in memory; errors call it `name`.
MusculoskeletalModel parse_osim(std::string name, std::string content);

}  // namespace sinew
