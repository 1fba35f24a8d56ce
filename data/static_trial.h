#pragma once

#include <optional>
#include <vector>

#include "data/finding.h"
#include "data/marker_trajectories.h"
#include "data/numbers.h"
#include "data/verdict_reason.h"

namespace sinew {

/// How much a subject moves in a trial.
struct TrialMovement {
  // RMS over the markers of how far they are from where each is in the middle of the trial, which
  // 95 % of the frames stay below [m].
  double sway = kNaN;
  // The stretch of a quarter of a second with the least sway, made as long as its sway stays below
  // the limit of standing [s]; NaN where there is none.
  double still_from = kNaN, still_to = kNaN;
};

/// At most 400 frames are looked at. O(frames · markers).
TrialMovement trial_movement(const MarkerTrajectories& markers);

/// Whether the sway is one of standing or sitting still: at most 30 mm. Markers sway by 3 to 12 mm
/// in the static trials of seven laboratories, by 70 mm and more when something is done.
bool stands_still(const TrialMovement& movement);

/// How far two trials of a subject agree in the distances that stay the same in the second, which
/// moves: those of markers on one segment, and some across joints that are held.
struct SegmentAgreement {
  int pairs = 0;
  // A quarter of the pairs differ by less [m]; NaN without pairs. Trunks that lean and heads that
  // turn in one trial only are in the other three quarters.
  double difference = kNaN;
};

/// Of markers with the same name that are 0.15 m or more apart and keep their distance to 10 mm
/// (standard deviation). O(markers² · frames), with 200 frames at most.
SegmentAgreement compare_segments(const MarkerTrajectories& standing,
                                  const MarkerTrajectories& moving);

/// What is wrong with the trial that a model is scaled by, seen beside the trial that is analysed:
/// - `trials-exchanged`: the subject moves in the first and stands in the second;
/// - `static-moves`: it moves in the first, which is no static trial;
/// - `other-person`: segments differ by more than 10 mm. Those of one subject agree to 4 mm in four
///   recordings of published data, those of two differ by 14 to 67 mm.
/// Names must be the same in both; O() as the above.
std::vector<VerdictReason> static_trial_reasons(const MarkerTrajectories& standing,
                                                const MarkerTrajectories& moving);

/// What is known of a marker of the static trial by a model.
struct StaticMarker {
  int segment = -1;  // that it is on; -1 if unknown
  // By how much its mean place on the segment in this trial differs from that in the other, in a
  // fit of the model to both [m]; NaN without one.
  double change = kNaN;
};

/// `static-marker`: a marker that sat elsewhere on its segment in the static trial. Where a segment
/// has four, by where the others carry its place to, over frames of the second trial in which they
/// fit to 10 mm RMS; where it has two or three, by the change of a fit, the largest of the segment
/// and more than 30 mm; else by distances that the second trial keeps to 10 mm (standard
/// deviation), which name both markers. More than 25 mm count: skin slides by 10 to 15 mm over most
/// segments (Leardini et al. 2005, Gait Posture 21:212-225). `known`: of each marker of `standing`.
/// O(markers² within segments · frames).
std::vector<VerdictReason> static_marker_reasons(const MarkerTrajectories& standing,
                                                 const MarkerTrajectories& moving,
                                                 const std::vector<StaticMarker>& known);

/// `static-rms`: markers that a model meets in its static trial but not in the walk, by more
/// than 10 mm RMS: soft tissue adds 3 to 6 mm in six published pairs of trials that are fitted
/// together, a pose that was mistaken or joints that turn elsewhere add 10 mm and more. RMS in m.
std::vector<VerdictReason> static_against_walk_reasons(double static_rms, double walk_rms);

/// `static-pose`: a static trial whose pose the model cannot take, by the RMS of its markers when
/// sizes and places are fitted to it [m]: above 20 mm, the most that Hicks et al. (2015, J Biomech
/// Eng 137:020905) allow in a movement, sizes bend to the pose; above twice that nothing is left of
/// them.
std::vector<VerdictReason> static_pose_reasons(double static_rms);

/// What one of these is to `sinew check`; its kind is the code, in words.
Finding finding_of(const VerdictReason& reason);

}  // namespace sinew
