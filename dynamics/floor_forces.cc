#include "dynamics/floor_forces.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace sinew {
namespace {

using Eigen::Vector3d;

// 6x⁵ − 15x⁴ + 10x³, twice continuously differentiable where it meets 0 and 1.
double smooth_step(double x) {
  const double t = std::clamp(x, 0.0, 1.0);
  return std::min(1.0, t * t * t * (10.0 + t * (6.0 * t - 15.0)));  // never past 1 by rounding
}

struct Step {
  double share = 0.0;                    // of the body's weight
  Vector3d pressure = Vector3d::Zero();  // p_i of share_wrench
};

// What a foot does at `phase`: the stance that began last, if it lasts still.
Step step_at(const ReferenceWalk& walk, const WalkFoot& foot, double phase) {
  const double stride = std::floor(phase - foot.strike);
  const double since = phase - foot.strike - stride;
  const double both = foot.stance - 0.5;  // double support lasts as long as stance exceeds swing
  Step step;
  step.share = smooth_step(since / both) * (1.0 - smooth_step((since - 0.5) / both));
  const double heading = foot.side == "l" ? foot.toe_out : -foot.toe_out;
  const Eigen::AngleAxisd R_WB(heading, Vector3d::UnitY());
  const double part = since / foot.stance;
  const Vector3d p_BC = (1.0 - part) * foot.first_pressure + part * foot.last_pressure;
  step.pressure = foot.p_WB + R_WB * p_BC + stride * walk.stride_length * Vector3d::UnitX();
  return step;
}

}  // namespace

std::vector<FloorLoad> share_wrench(const ReferenceWalk& walk, double time, const Vector3d& p_WC,
                                    const Vector6d& wrench) {
  const Vector3d M = wrench.head<3>(), F = wrench.tail<3>();
  if (!(F.y() > 0.0)) {
    throw std::invalid_argument(
        fmt::format("the reference walk would have to pull at the floor at {} s: its vertical "
                    "force is {} N. Move the body less up and down.",
                    time, F.y()));
  }
  std::vector<Step> steps;
  Vector3d offset(M.z() / F.y(), 0.0, -M.x() / F.y());  // c − Σ s_j p_j
  for (const WalkFoot& foot : walk.feet) {
    steps.push_back(step_at(walk, foot, time / walk.stride_time));
    offset -= steps.back().share * steps.back().pressure;
  }
  offset.y() = 0.0;

  std::vector<FloorLoad> loads(steps.size());
  Vector3d rest = F;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    if (steps[i].share == 0.0) continue;
    FloorLoad& load = loads[i];
    load.point = steps[i].pressure + offset;
    load.point.y() = 0.0;
    load.force = steps[i].share * F.y() / p_WC.y() * (p_WC - load.point);
    rest -= load.force;
  }
  double free_moment = M.y();
  for (std::size_t i = 0; i < steps.size(); ++i) {
    loads[i].force += steps[i].share * rest;
    free_moment -= loads[i].point.cross(loads[i].force).y();
  }
  for (std::size_t i = 0; i < steps.size(); ++i) {
    loads[i].torque.y() = steps[i].share * free_moment;
  }
  return loads;
}

}  // namespace sinew
