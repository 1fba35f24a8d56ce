#pragma once

#include <vector>

#include "data/load_coverage.h"
#include "pipeline/id_job.h"
#include "pipeline/ik_job.h"
#include "pipeline/scale_job.h"
#include "pipeline/verdict.h"

/// Gathers what a verdict rests on from what the commands have computed.
namespace sinew {

/// Joints that have coordinates, without those of virtual links.
std::vector<JointEvidence> joint_evidence(const MusculoskeletalModel& model);

/// Mass; height in the default pose, or, of a model without a head, what its hips' height makes
/// likely; lengths of segments with a partner on the other side. O(size of the model).
ModelEvidence model_evidence(const MusculoskeletalModel& model);

/// `static_rms`: of the trial that the model was fitted to [m], or NaN. `found`: what others found;
/// coordinates that they call undetermined are not judged by their values.
KinematicsEvidence kinematics_evidence(const IkJob& job, const TrackingResult& result,
                                       double static_rms, const std::vector<VerdictReason>& found);

/// What others find in a solved trial: angles that no marker determines, steps, gaps, and markers
/// that bear each other's names, unless that was looked for before. Time: one eigenvalue
/// decomposition, and O(frames · markers).
std::vector<VerdictReason> tracking_findings(const IkJob& job, const TrackingResult& result);

ScaleEvidence scale_evidence(const ScaledModel& scaled);

/// Where platforms tell in which frames the ground's forces are known.
struct CoverageOfFrames {
  const LoadCoverage* coverage = nullptr;  // null: nothing tells
  int first = 0;                           // frame of the coverage in which the forces begin
  double stride_mass = kNaN;               // that the platforms carry over strides [kg]
  double standing_mass = kNaN;             // that they carry in the static trial [kg]
};

/// `forces`: as inverse_dynamics() gives them. O(frames · (loads + coordinates of the root)).
DynamicsEvidence dynamics_evidence(const MusculoskeletalModel& model, const TimeTable& forces,
                                   const ExternalLoads& loads, const CoverageOfFrames& coverage);

/// Coordinates that a motion does not have and that no coupler sets or lock holds.
std::vector<std::string> coordinates_not_given(const MusculoskeletalModel& model,
                                               const CoordinateTable& motion);

}  // namespace sinew
