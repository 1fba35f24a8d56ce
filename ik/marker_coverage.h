#pragma once

#include <string>
#include <vector>

#include "data/verdict_reason.h"
#include "ik/tracking.h"
#include "model/segment_words.h"

namespace sinew {

/// The segment of each body. One that cannot move against the body that carries it belongs to that
/// one's segment.
std::vector<Segment> segments_of(const MusculoskeletalModel& model, const KinematicTree& tree);

/// Coordinates that can move of the joints at both ends of segments without markers, ascending;
/// those of virtual links not. A joint turns by what markers on both of its segments tell: a chain
/// that has markers on its far end only is closed by its joints' few freedoms, not by measurement.
std::vector<int> coordinates_beside(const MusculoskeletalModel& model, const KinematicTree& tree,
                                    const std::vector<Segment>& segments,
                                    const std::vector<Segment>& bare);

/// What the tracked markers do not tell about a body, whatever tasks draw it somewhere.
struct MarkerCoverage {
  // Coordinates that they leave open, dependent ones included, those of virtual links not.
  std::vector<int> undetermined;
  // That move by themselves and have no tracked marker that is measured for a tenth of a second …
  std::vector<Segment> bare_segments;
  std::vector<int> bare_coordinates;  // … and the coordinates of the joints at both of their ends
};

/// Looks at the frame in which most tracked markers are measured, at its pose `q`, or at the
/// default pose where `solved` is null, by the rank of the markers' Jacobian
/// (undetermined_coordinates()). Time: one eigenvalue problem of the size of the unknowns.
MarkerCoverage marker_coverage(const MusculoskeletalModel& model, const KinematicTree& tree,
                               const TrackingProblem& tracking, const MarkerTrajectories& markers,
                               int first_frame, const TrackingResult* solved);

/// The tracking problem of the markers alone, without tasks, wires and virtual links' targets.
TrackingProblem markers_alone(const TrackingProblem& tracking);

/// Codes "segment-without-marker" and "undetermined-coordinates": in words, with the coordinates
/// whose angles and torques cannot be used. Nothing where the markers tell everything.
std::vector<VerdictReason> coverage_reasons(const MusculoskeletalModel& model,
                                            const MarkerCoverage& coverage);

/// Residuals of a person's own markers on a model that is not scaled reach 50 mm; a limb is longer.
constexpr double kNoPerson = 0.1;  // [m]

/// Why markers may lie this far from the model, where their RMS [m] exceeds kNoPerson; with the
/// command that tells. Empty below.
std::string misfit_causes(const MusculoskeletalModel& model, const KinematicTree& tree,
                          const TrackingProblem& tracking, double marker_rms);

}  // namespace sinew
