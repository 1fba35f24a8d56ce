#pragma once

#include <optional>

#include "data/c3d_file.h"

namespace sinew {

/// What a laboratory entered about the subject before it recorded.
struct SubjectParameters {
  std::optional<double> mass, height;  // [kg, m]
};

/// From the group PROCESSING, where Vicon's software keeps `Bodymass` [kg] and `Height` [mm, or m].
/// Values of nobody (below 3 kg or 0.3 m, above 400 kg or 2.6 m), and those of a file with several
/// subjects, of whom it does not say which it means, are left out.
SubjectParameters subject_parameters(const C3dFile& file);

}  // namespace sinew
