#pragma once

#include "data/tool_setup.h"
#include "model/musculoskeletal_model.h"

namespace sinew {

/// Tasks of inverse kinematics for the embedded walk: every marker of the model with weight 1, and
/// joints between bones that the markers leave free near their neutral pose: with weight 1 those
/// that the walk keeps still, such as the fingers', with 1e-4 the spine's, which share a turn.
/// Virtual links have none: their wires hold them.
IkTaskSet walk_tasks(const MusculoskeletalModel& model);

}  // namespace sinew
