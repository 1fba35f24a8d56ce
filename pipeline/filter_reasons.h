#pragma once

#include <vector>

#include "data/marker_trajectories.h"
#include "data/verdict_reason.h"
#include "dynamics/inverse_dynamics.h"

/// What a low-pass takes from a movement beside the noise.
namespace sinew {

/// `angle-filter`: the rotational coordinate of which a cutoff below 6 Hz takes most, against the
/// same low-passed at 6 Hz, by the RMS over the frames. Above 2 degrees a remark and above 5 not
/// usable: what McGinley, Baker, Wolfe & Morris (2009, Gait Posture 29:360-369) find acceptable and
/// misleading. Torques follow accelerations, so that all of them are spoiled. O(frames ·
/// coordinates).
std::vector<VerdictReason> angle_filter_reasons(const MusculoskeletalModel& model,
                                                const CoordinateTable& motion, double cutoff);

/// `marker-filter`: the marker that a cutoff below 6 Hz moves most, against the same low-passed at
/// 6 Hz, by the RMS over the frames [m]. Above kFilteredMarker a remark and above
/// kWorstFilteredMarker not usable. `filtered`: what the cutoff made of `markers`, whose shape it
/// has. O(frames · markers).
std::vector<VerdictReason> marker_filter_reasons(const MarkerTrajectories& markers,
                                                 const MarkerTrajectories& filtered, double cutoff);

}  // namespace sinew
