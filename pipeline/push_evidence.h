#pragma once

#include <Eigen/Core>
#include <vector>

#include "data/time_table.h"
#include "model/musculoskeletal_model.h"
#include "pipeline/verdict_dynamics.h"

namespace sinew {

/// What is left at the root along a horizontal axis of ground: a column of the generalized forces.
struct LevelForce {
  int column = -1;
  Eigen::Vector3d axis;
};

/// Forces on one body, or on all of them: frames × 3 in ground's axes [N].
struct BodyForces {
  int body = -1;  // -1: all
  RowMatrix forces;
};

/// RMS over the frames that are wanted, or over all where none is.
double rms_where(const Eigen::VectorXd& values, const std::vector<bool>& wanted);

/// Adds `pushes`, and `turns` where the root can go both ways, of the sum and of each body's load,
/// over the known frames and over each of its contacts that is known for 0.3 s or more. `loads`:
/// the sum, then the bodies. `left`: generalized forces. O(frames · loads).
void add_pushes(const MusculoskeletalModel& model, const std::vector<BodyForces>& loads,
                const std::vector<LevelForce>& level, const TimeTable& left,
                const std::vector<bool>& known, DynamicsEvidence& evidence);

}  // namespace sinew
