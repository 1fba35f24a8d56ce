#pragma once

#include <string>
#include <vector>

#include "data/load_coverage.h"
#include "data/numbers.h"
#include "data/time_table.h"
#include "dynamics/coordinate_table.h"
#include "dynamics/external_loads.h"
#include "pipeline/verdict_dynamics.h"

/// Gathers what a verdict on torques rests on.
namespace sinew {

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
