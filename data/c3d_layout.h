#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "data/c3d_file.h"

namespace sinew::c3d {

/// Weighs header, parameters and the size of the file against each other, for they often disagree:
///  - data begin where the header says, else POINT:DATA_START, else behind the parameters;
///  - a frame holds POINT:USED points and ANALOG:USED × ratio samples, unless the header's numbers
///    fill the file exactly and these do not;
///  - of the frame counts of the header, POINT:FRAMES, POINT:LONG_FRAMES and TRIAL:ACTUAL_START and
///    _END the largest that the file can hold counts; if it can hold none, what it holds;
///  - POINT:RATE goes before the header's rate, the header's scale before POINT:SCALE.
/// Warns of each disagreement. Throws InputError where data cannot be found or the rate is unknown.
/// `parameters_end` is the byte behind the parameter section by its own count of blocks.
C3dLayout find_layout(const std::string& path, const C3dHeader& header, const C3dGroups& groups,
                      std::uint64_t parameters_end, std::uint64_t file_bytes,
                      std::vector<Warning>& warnings);

}  // namespace sinew::c3d
