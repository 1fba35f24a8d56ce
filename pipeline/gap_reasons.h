#pragma once

#include <functional>
#include <string>
#include <vector>

#include "data/marker_trajectories.h"
#include "data/verdict_reason.h"
#include "ik/tracking.h"
#include "ik/undetermined_stretches.h"

namespace sinew {

/// What gaps take from a result, over frames `first` … `end` − 1 that were solved:
///
/// `filled-share`: the tracked markers that are not measured in more than a quarter of the frames,
///   whether they were filled or stay missing (the share of all samples is judged with the fit).
/// `gap`: stretches that leave coordinates undetermined, with their times and these coordinates,
///   of which neither angles nor torques can be used there. The figure is the largest share of the
///   frames that a coordinate is undetermined in. Those that are so in more than a quarter cannot
///   be used at all, and nothing can if one of them moves the whole body. And markers that are
///   measured in fewer frames than a tenth of a second has, which say nothing. Times are `reach`
///   frames longer on both sides, as far as filters carry what is filled in.
///
/// `shown`: what a marker of the model is called before its user.
std::vector<VerdictReason> gap_reasons(const MusculoskeletalModel& model,
                                       const TrackingProblem& tracking,
                                       const MarkerTrajectories& markers, int first, int end,
                                       const std::vector<UndeterminedStretch>& stretches, int reach,
                                       const std::function<std::string(const std::string&)>& shown);

}  // namespace sinew
