#include "pipeline/coordinate_values.h"

#include <span>
#include <vector>

#include "data/coordinate_spline.h"

namespace sinew {

RowMatrix coordinate_values_at(const Eigen::VectorXd& time, const CoordinateTable& table) {
  const CoordinateSpline spline(table.time, table.q);
  RowMatrix values = RowMatrix::Constant(time.size(), table.q.cols(), kNaN);
  std::vector<double> q(static_cast<std::size_t>(spline.size()));
  for (Eigen::Index frame = 0; frame < time.size(); ++frame) {
    if (time[frame] < spline.first_time() || time[frame] > spline.last_time()) continue;
    spline.evaluate(time[frame], q, {}, {});
    for (Eigen::Index c = 0; c < values.cols(); ++c) {
      if (table.measured[static_cast<std::size_t>(c)]) {
        values(frame, c) = q[static_cast<std::size_t>(c)];
      }
    }
  }
  return values;
}

}  // namespace sinew
