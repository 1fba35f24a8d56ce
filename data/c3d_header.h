#pragma once

#include <string>
#include <vector>

#include "data/c3d_file.h"

namespace sinew::c3d {

/// Where the parameters begin and in which byte order they are.
struct ParameterStart {
  int block = 2;
  C3dProcessor processor = C3dProcessor::kIntel;
};

/// Finds the parameter section from the header's first byte, or, where that is wrong, from the
/// pattern that a section begins with. `first` holds the file's first bytes. Throws InputError if
/// the file is empty, too short or no C3D file.
ParameterStart find_parameters(const std::string& path, const std::string& first,
                               std::vector<Warning>& warnings);

/// Reads the first block of a file, whose byte order find_parameters tells.
C3dHeader parse_header(const std::string& first, C3dProcessor processor);

/// The block as Intel systems store it: 512 bytes.
std::string format_header(const C3dHeader& header);

}  // namespace sinew::c3d
