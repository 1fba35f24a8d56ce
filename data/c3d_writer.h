#pragma once

#include <filesystem>

#include "data/c3d_file.h"

namespace sinew {

struct C3dWriteOptions {
  // Numbers as 16-bit integers instead of reals. Scales of the file are kept where its values fit
  // them, else the largest value sets them.
  bool integers = false;
};

/// Writes a C3D file in Intel's byte order: the file's own groups, with those parameters brought up
/// to date that describe markers, computed trajectories, channels and events; a group that is
/// missing is made; descriptions are cut to 127 characters. Markers come first among the points,
/// computed trajectories follow. What is not measured has -1 as its residual. What is read and
/// written again keeps its bytes from the second time on. Atomic like write_storage. Throws
/// InputError if sizes disagree, counts or names do not fit the format, or the file cannot be
/// written. O(values) in time and memory.
void write_c3d(const std::filesystem::path& path, const C3dFile& file,
               const C3dWriteOptions& options = {});

}  // namespace sinew
