#include "data/force_table.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>
#include <vector>

#include "data/conditioning.h"
#include "data/laboratory_axes.h"
#include "data/numbers.h"

namespace sinew {
namespace {

using Eigen::Vector3d;

bool has_loads(const ForcePlatformRecording& recording) {
  return recording.platform.usable() && recording.platform.has_moments &&
         recording.sample_count() > 0;
}

TimeTable as_table(const ForcePlatformRecording& recording) {
  TimeTable table;
  const Eigen::Index rows = recording.force.rows();
  table.time.resize(rows);
  for (Eigen::Index i = 0; i < rows; ++i) table.time[i] = static_cast<double>(i) / recording.rate;
  table.values.resize(rows, 6);
  table.values << recording.force, recording.moment;
  table.labels = {"fx", "fy", "fz", "mx", "my", "mz"};
  return table;
}

// Along the platform's normal; positive where it carries, whichever way its corners are numbered.
// What pulls is an offset, not a foot.
std::vector<double> pressing(const ForcePlatformRecording& recording, double threshold) {
  const Vector3d normal = recording.platform.R_WP.col(2);
  std::vector<double> force;
  double impulse = 0.0;
  for (Eigen::Index i = 0; i < recording.force.rows(); ++i) {
    force.push_back(recording.force.row(i).dot(normal));
    if (std::abs(force.back()) >= threshold) impulse += force.back();
  }
  if (impulse < 0.0) {
    for (double& f : force) f = -f;
  }
  return force;
}

}  // namespace

void rotate(ForcePlatformRecording& recording, const Eigen::Matrix3d& R_MW) {
  ForcePlatform& platform = recording.platform;
  for (Vector3d& corner : platform.corners) corner = R_MW * corner;
  platform.p_WC = R_MW * platform.p_WC;
  platform.R_WP = R_MW * platform.R_WP;
  for (RowMatrix* values :
       {&recording.force, &recording.moment, &recording.center, &recording.free_moment}) {
    rotate_vectors(R_MW, *values);
  }
}

void condition(ForcePlatformRecording& recording, const ForceConditioning& conditioning) {
  if (!has_loads(recording)) return;
  TimeTable table = as_table(recording);
  if (conditioning.cutoff) lowpass(table, *conditioning.cutoff);
  if (conditioning.rate) {
    table = resample(table, *conditioning.rate);
    recording.rate = *conditioning.rate;
  }
  const Eigen::Matrix3d& R_WP = recording.platform.R_WP;
  const Eigen::Index rows = table.time.size();
  recording.force = table.values.leftCols(3);
  recording.moment = table.values.rightCols(3);
  recording.center.setConstant(rows, 3, kNaN);
  recording.free_moment.setZero(rows, 3);
  const double threshold = std::max(conditioning.threshold, 1e-9);
  const std::vector<double> force = pressing(recording, threshold);
  for (Eigen::Index i = 0; i < rows; ++i) {
    const Wrench wrench = {R_WP.transpose() * recording.force.row(i).transpose(),
                           R_WP.transpose() * recording.moment.row(i).transpose()};
    if (!(force[static_cast<std::size_t>(i)] >= threshold)) {
      recording.force.row(i).setZero();
      recording.moment.row(i).setZero();
      continue;
    }
    const CenterOfPressure center = compute_center(wrench);
    recording.center.row(i) = recording.platform.p_WC + R_WP * center.p_CQ;
    recording.free_moment.row(i) = R_WP.col(2) * center.free_moment;
  }
}

void fill_centers(RowMatrix& centers, const Vector3d& whole) {
  Eigen::Index last = -1;
  for (Eigen::Index row = 0; row < centers.rows(); ++row) {
    if (std::isnan(centers(row, 0))) continue;
    for (Eigen::Index i = last + 1; i < row; ++i) {
      const double w = static_cast<double>(i - last) / static_cast<double>(row - last);
      if (last < 0) {
        centers.row(i) = centers.row(row);
      } else {
        centers.row(i) = (1.0 - w) * centers.row(last) + w * centers.row(row);
      }
    }
    last = row;
  }
  for (Eigen::Index i = last + 1; i < centers.rows(); ++i) {
    if (last < 0) {
      centers.row(i) = whole.transpose();
    } else {
      centers.row(i) = centers.row(last);
    }
  }
}

TimeTable force_table(const std::vector<ForcePlatformRecording>& recordings) {
  TimeTable table;
  table.name = "Force platforms";
  for (const ForcePlatformRecording& recording : recordings) {
    if (!has_loads(recording)) continue;
    const TimeTable part = as_table(recording);
    RowMatrix centers = recording.center, free_moment = recording.free_moment;
    fill_centers(centers, recording.platform.p_WC);
    // Without a centre of pressure there is no moment about it.
    free_moment = free_moment.array().isNaN().select(0.0, free_moment);
    const Eigen::Index columns = table.values.cols();
    table.time = part.time;
    table.values.conservativeResize(part.time.size(), columns + 9);
    table.values.rightCols(9) << recording.force, centers, free_moment;
    for (const char* kind : {"force_v", "force_p", "torque_"}) {
      for (const char axis : {'x', 'y', 'z'}) {
        table.labels.push_back(fmt::format("plate{}_{}{}", recording.platform.number, kind, axis));
      }
    }
  }
  return table;
}

}  // namespace sinew
