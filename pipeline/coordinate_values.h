#pragma once

#include <Eigen/Core>

#include "data/time_table.h"
#include "dynamics/coordinate_table.h"

namespace sinew {

/// Values of a coordinate file at `time`, times × coordinates of the model, by splines; NaN outside
/// the file and for coordinates that it does not have.
RowMatrix coordinate_values_at(const Eigen::VectorXd& time, const CoordinateTable& table);

}  // namespace sinew
