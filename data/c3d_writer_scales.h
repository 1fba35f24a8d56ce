#pragma once

#include <vector>

#include "data/c3d_file.h"

namespace sinew::c3d {

/// What turns physical values to stored ones. Singly precise, as files hold them.
struct StoredScales {
  float point = 1.0f;  // of integer coordinates, else of residuals only [the file's unit]
  std::vector<float> channel;
  std::vector<std::int16_t> offset;
};

/// The scales for `file`: its own where its values fit, else as fine as they can be.
StoredScales choose_scales(const C3dFile& file, bool integers);

}  // namespace sinew::c3d
