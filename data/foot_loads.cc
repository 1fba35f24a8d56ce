#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "data/foot_assignment.h"
#include "data/force_table.h"
#include "data/numbers.h"

namespace sinew {
namespace {

using Eigen::Vector3d;

// The loads of one foot at one sample: those that carry it, by platform.
struct Load {
  Vector3d force = Vector3d::Zero(), center = Vector3d::Constant(kNaN);
  Vector3d free_moment = Vector3d::Zero();
};

Load sum_of(const std::vector<Load>& loads) {
  if (loads.size() == 1) return loads.front();
  Load sum;
  Vector3d moment = Vector3d::Zero();
  double height = 0.0;
  for (const Load& load : loads) {
    sum.force += load.force;
    moment += load.center.cross(load.force) + load.free_moment;
    height += load.center.y() / static_cast<double>(loads.size());
  }
  const Vector3d& F = sum.force;
  sum.center = {(moment.z() + height * F.x()) / F.y(), height,
                (height * F.z() - moment.x()) / F.y()};
  sum.free_moment = moment - sum.center.cross(F);
  return sum;
}

}  // namespace

TimeTable foot_loads(const FootAssignment& assignment,
                     const std::vector<ForcePlatformRecording>& plates) {
  TimeTable table;
  table.name = "Ground reactions";
  // `condition` leaves platforms without moments as they are; the others have the same samples.
  const auto any = std::find_if(plates.begin(), plates.end(), [](const auto& plate) {
    return plate.platform.has_moments && plate.sample_count() > 0;
  });
  if (any == plates.end()) return table;
  const Eigen::Index rows = any->force.rows();
  const double rate = any->rate;
  table.time.resize(rows);
  for (Eigen::Index i = 0; i < rows; ++i) table.time[i] = static_cast<double>(i) / rate;
  for (std::size_t foot = 0; foot < assignment.feet.size(); ++foot) {
    std::vector<std::vector<Load>> loads(static_cast<std::size_t>(rows));
    Vector3d anywhere = any->platform.p_WC;
    for (const PlateContact& contact : assignment.contacts) {
      if (contact.foot != static_cast<int>(foot) ||
          contact.state != PlateContact::State::kAssigned) {
        continue;
      }
      const ForcePlatformRecording& plate = plates[static_cast<std::size_t>(contact.plate)];
      const auto first = static_cast<Eigen::Index>(std::lround(contact.from * rate));
      const auto last = static_cast<Eigen::Index>(std::lround(contact.to * rate));
      for (Eigen::Index i = first; i <= last && i < rows; ++i) {
        if (std::isnan(plate.center(i, 0))) continue;
        loads[static_cast<std::size_t>(i)].push_back({plate.force.row(i).transpose(),
                                                      plate.center.row(i).transpose(),
                                                      plate.free_moment.row(i).transpose()});
      }
    }
    RowMatrix forces = RowMatrix::Zero(rows, 3), moments = forces,
              centers = RowMatrix::Constant(rows, 3, kNaN);
    for (Eigen::Index i = 0; i < rows; ++i) {
      const auto& at = loads[static_cast<std::size_t>(i)];
      if (at.empty()) continue;
      const Load sum = sum_of(at);
      forces.row(i) = sum.force.transpose();
      centers.row(i) = sum.center.transpose();
      moments.row(i) = sum.free_moment.transpose();
    }
    fill_centers(centers, anywhere);
    const Eigen::Index columns = table.values.cols();
    table.values.conservativeResize(rows, columns + 9);
    table.values.rightCols(9) << forces, centers, moments;
    for (const char* kind : {"force_v", "force_p", "torque_"}) {
      for (const char axis : {'x', 'y', 'z'}) {
        table.labels.push_back(fmt::format("{}_{}{}", assignment.feet[foot].name, kind, axis));
      }
    }
  }
  return table;
}

}  // namespace sinew
