#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "data/c3d_parameters.h"
#include "data/input_error.h"

namespace sinew::c3d {

/// Reads the groups and parameters of a C3D file from `bytes`, which begin at the first record,
/// byte `offset` of the file, and end where data begin at the latest. Neither the declared number
/// of blocks nor a terminator is needed; groups may follow their parameters. Groups of one name
/// become one; of parameters of one name the first is kept. Behind the first `declared` bytes,
/// which the section says it has, data may stand where parameters are looked for: the list ends
/// there in a name that is not of ASCII's characters. Warns of groups and parameters that are given
/// twice, of parameters without a group or of unknown type, and where the list ends in something
/// that is no record. O(bytes) in time and memory.
C3dGroups parse_parameters(const std::string& path, std::string_view bytes, std::size_t offset,
                           std::size_t declared, C3dProcessor processor,
                           std::vector<Warning>& warnings);

/// The section as Intel systems store it, padded to whole blocks of 512 bytes. Throws InputError,
/// naming `path`, if a group or parameter is too large for the format.
std::string format_parameters(const std::string& path, const C3dGroups& groups);

}  // namespace sinew::c3d
