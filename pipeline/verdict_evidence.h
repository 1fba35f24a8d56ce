#pragma once

#include <vector>

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

/// `locked`: coordinates of a person's model that it locks on one side only, or at the root, where
/// others are free; models of both hands' wrists or feet locked are what their authors meant.
std::vector<VerdictReason> lock_reasons(const MusculoskeletalModel& model);

/// What others find in a solved trial: angles that no marker determines, steps, gaps, locks, and in
/// a recording that nobody has looked at before markers that bear each other's names, frames that
/// stand still and holes in time. Time: one eigenvalue
/// decomposition, and O(frames · markers).
std::vector<VerdictReason> tracking_findings(const IkJob& job, const TrackingResult& result);

ScaleEvidence scale_evidence(const ScaledModel& scaled);

}  // namespace sinew
