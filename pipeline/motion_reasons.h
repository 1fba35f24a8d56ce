#pragma once

#include <vector>

#include "data/verdict_reason.h"
#include "dynamics/coordinate_table.h"
#include "model/musculoskeletal_model.h"

namespace sinew {

/// What a given motion says against itself, of a model that stands for a person:
/// - `angles-unit`, not usable: it travels by 0.3 m or more while joints turn but no angle exceeds
///   2π degrees, as radians do that a header calls degrees;
/// - `beyond-range`: coordinates that are more than 20 degrees, or 5 cm, beyond what the model
///   allows in more than half of the frames, as knees are that bend the other way in the model that
///   the motion was made with; not usable for two or more.
/// Columns that the motion lacks say nothing. O(frames · coordinates).
std::vector<VerdictReason> motion_reasons(const MusculoskeletalModel& model,
                                          const CoordinateTable& motion);

}  // namespace sinew
