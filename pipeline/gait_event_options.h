#pragma once

#include <string>
#include <vector>

#include "data/c3d_file.h"
#include "data/force_platform.h"
#include "data/gait_events.h"

namespace sinew {

/// Heel strikes and toe offs of a C3D file by its platforms, its own events and its markers, in the
/// file's axes, or by `sources`: `forces` alone, `kinematics` alone, or `all`. Of events of forces
/// and kinematics there are none where nothing tells which axis is up.
std::vector<GaitEvent> find_gait_events(const C3dFile& file,
                                        const std::vector<ForcePlatformRecording>& plates,
                                        const std::string& sources = "all");

/// Of markers alone.
std::vector<GaitEvent> find_gait_events(const MarkerTrajectories& markers);

/// Puts events in place of the file's own heel strikes and toe offs; its other events stay.
void replace_gait_events(C3dFile& file, const std::vector<GaitEvent>& events);

}  // namespace sinew
