#pragma once

#include <Eigen/Core>

#include "model/musculoskeletal_model.h"

namespace sinew {

/// Evaluation 1 of Ayusawa & Nakamura 2012: a chain of `links` spherical joints, 3·links degrees of
/// freedom, straight along Z. Every link but the last is 1.5/(3·links − 2) m long, the last, which
/// is the end-effector, 0.5/(3·links − 2) m; together 0.5 m. Joints are ball joints; the
/// end-effector's tip is the marker `tip`. Throws std::invalid_argument for fewer than 1 link.
MusculoskeletalModel make_manipulator(int links);

/// Length of all links but the last [m].
double manipulator_link_length(int links);

}  // namespace sinew
