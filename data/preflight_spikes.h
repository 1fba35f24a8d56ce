#pragma once

#include <vector>

#include "data/c3d_file.h"
#include "data/finding.h"
#include "data/force_platform.h"
#include "data/marker_spikes.h"
#include "data/preflight_swaps.h"
#include "data/recording_edits.h"
#include "data/sample_spikes.h"

namespace sinew {

/// Kind `spike`: one finding for each marker that is for a moment where it cannot be (see
/// find_marker_spikes()): `--drop NAME@FROM-TO`. What is an exchange of names is left to
/// find_swap_faults().
std::vector<Finding> find_spike_faults(const MarkerTrajectories& markers,
                                       const std::vector<MarkerSwap>& swaps,
                                       const MarkerSpikeOptions& options = {});

/// Kind `spike`: one finding for each channel of a usable platform, or for each column of forces,
/// with samples that cannot be (find_sample_spikes()): `--drop-samples NAME@FROM-TO`.
std::vector<Finding> find_force_spike_faults(const C3dFile& file,
                                             const std::vector<ForcePlatform>& platforms);
std::vector<Finding> find_force_spike_faults(const TimeTable& table);

/// The same as the edits that leave them out.
std::vector<MarkerDrop> drops_of(const MarkerTrajectories& markers,
                                 const std::vector<MarkerSpike>& spikes);
std::vector<SampleDrop> force_spikes(const C3dFile& file,
                                     const std::vector<ForcePlatform>& platforms);
std::vector<SampleDrop> force_spikes(const TimeTable& table);

}  // namespace sinew
