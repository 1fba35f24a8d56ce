#include "pipeline/dynamics_evidence.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "data/numbers.h"
#include "model/limb_paths.h"
#include "pipeline/push_evidence.h"
#include "pipeline/verdict_evidence.h"
#include "pipeline/verdict_limits.h"

namespace sinew {
namespace {

// Of all loads, then of every loaded body; false if some are given in other axes than ground's.
bool sum_loads(const ExternalLoads& loads, const Eigen::VectorXd& time,
               std::vector<BodyForces>& sums) {
  sums = {{-1, RowMatrix::Zero(time.size(), 3)}};
  bool in_ground = true;
  for (int load = 0; load < loads.size() && time.size() > 0; ++load) {
    const int body = loads.sample(load, time[0]).body;
    std::size_t own = 1;
    while (own < sums.size() && sums[own].body != body) ++own;
    if (own == sums.size()) sums.push_back({body, RowMatrix::Zero(time.size(), 3)});
    for (Eigen::Index f = 0; f < time.size(); ++f) {
      const ExternalLoads::Sample sample = loads.sample(load, time[f]);
      in_ground = in_ground && sample.force_frame == 0;
      sums[0].forces.row(f) += sample.force.transpose();
      sums[own].forces.row(f) += sample.force.transpose();
    }
  }
  return in_ground;
}

// Columns of the joints that connect the model to ground.
struct RootColumns {
  std::vector<int> forces, moments;
  std::vector<LevelForce> level;
  int vertical = -1;  // the force along up, where a coordinate is just that
  double sign = 1.0;
};

// The axis of a root's shift in ground, where it is a fixed one.
Eigen::Vector3d shift_axis(const Joint& joint, int coordinate) {
  if (joint.kind == Joint::Kind::kCustom) {
    for (std::size_t slot = 3; slot < 6; ++slot) {
      if (joint.axes[slot].coordinate == coordinate) return joint.X_PF.R * joint.axes[slot].axis;
    }
    return Eigen::Vector3d::Zero();
  }
  int shift = 0;
  for (const int c : joint.coordinates) {
    if (c == coordinate) break;
    ++shift;
  }
  const int turns = joint.kind == Joint::Kind::kFree     ? 3
                    : joint.kind == Joint::Kind::kPlanar ? 1
                                                         : 0;
  const int axis = shift - turns;
  if (axis < 0 || axis > 2) return Eigen::Vector3d::Zero();
  return joint.X_PF.R.col(axis);
}

RootColumns root_columns(const MusculoskeletalModel& model, const TimeTable& forces) {
  RootColumns root;
  const Eigen::Vector3d up = up_of(model);
  for (std::size_t c = 0; c < model.coordinates.size(); ++c) {
    const Coordinate& coordinate = model.coordinates[c];
    const Joint& joint = model.joints[static_cast<std::size_t>(coordinate.joint)];
    if (joint.parent != 0 || of_virtual_link(model, static_cast<int>(c))) continue;
    const bool turns = coordinate.motion == Coordinate::Motion::kRotational;
    const int column = forces.find_column(coordinate.name + (turns ? "_moment" : "_force"));
    if (column < 0) continue;
    (turns ? root.moments : root.forces).push_back(column);
    if (turns) continue;
    const Eigen::Vector3d axis = shift_axis(joint, static_cast<int>(c));
    const double along = axis.dot(up);
    constexpr double kSameAxis = 0.99;  // 8 degrees: what a tilted floor may have
    if (std::abs(along) < 1.0 - kSameAxis && axis.cwiseAbs().maxCoeff() > kSameAxis) {
      root.level.push_back({column, axis});
    }
    if (std::abs(along) < kSameAxis) continue;
    root.vertical = column;
    root.sign = along > 0.0 ? 1.0 : -1.0;
  }
  return root;
}

Eigen::VectorXd lengths(const TimeTable& table, const std::vector<int>& columns) {
  Eigen::VectorXd squares = Eigen::VectorXd::Zero(table.values.rows());
  for (const int column : columns) squares += table.values.col(column).cwiseAbs2();
  return squares.cwiseSqrt();
}

double max_where(const Eigen::VectorXd& values, const std::vector<bool>& wanted) {
  double most = 0.0, all = 0.0;
  bool any = false;
  for (Eigen::Index f = 0; f < values.size(); ++f) {
    all = std::max(all, values[f]);
    if (!wanted[static_cast<std::size_t>(f)]) continue;
    most = std::max(most, values[f]);
    any = true;
  }
  return any ? most : all;
}

double mean_where(const Eigen::VectorXd& values, const std::vector<bool>& wanted) {
  double sum = 0.0;
  int count = 0;
  for (Eigen::Index f = 0; f < values.size(); ++f) {
    if (!wanted[static_cast<std::size_t>(f)]) continue;
    sum += values[f];
    ++count;
  }
  return count > 0 ? sum / count : kNaN;
}

// Coordinates between ground and what carries the body: what loads act on, or else the feet.
std::vector<std::string> supporting_coordinates(const MusculoskeletalModel& model,
                                                const std::vector<int>& bodies) {
  std::vector<std::string> names;
  for (const int body : bodies) {
    for (const std::string& name : coordinates_to_ground(model, body)) {
      if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
    }
  }
  return names;
}

std::vector<int> loaded_bodies(const ExternalLoads& loads, const Eigen::VectorXd& time) {
  std::set<int> bodies;
  for (int load = 0; load < loads.size() && time.size() > 0; ++load) {
    bodies.insert(loads.sample(load, time[0]).body);
  }
  return {bodies.begin(), bodies.end()};
}

// Sums of the loads, and the mass that they carry in the known frames, in which `hangs` is what is
// left at the root, upwards.
void add_loads(const MusculoskeletalModel& model, const TimeTable& forces,
               const ExternalLoads& loads, const std::vector<bool>& known, const RootColumns& root,
               const Eigen::VectorXd& hangs, DynamicsEvidence& e) {
  std::vector<BodyForces> pushing;
  const bool in_ground = sum_loads(loads, forces.time, pushing);
  const RowMatrix& sums = pushing[0].forces;
  e.peak_load = sums.rowwise().norm().maxCoeff();
  if (!in_ground) return;
  for (const BodyForces& of : pushing) {
    if (of.body < 0) continue;
    e.pulls.push_back(
        {model.bodies[static_cast<std::size_t>(of.body)].name, (of.forces * up_of(model)).mean()});
  }
  const Eigen::VectorXd vertical = sums * up_of(model);
  const auto n = static_cast<double>(vertical.size());
  e.mean_vertical_load = vertical.mean();
  e.vertical_load_rms = std::sqrt(vertical.squaredNorm() / n);
  e.horizontal_load_rms = std::sqrt(std::max(0.0, sums.squaredNorm() - vertical.squaredNorm()) / n);
  const double given = mean_where(vertical, known), left = mean_where(hangs, known);
  if (given > 0.0) e.carried_mass = model.total_mass() * given / (given + left);
  if (e.known == 0) return;
  add_pushes(model, pushing, root.level, forces, known, e);
}

void add_feet(const MusculoskeletalModel& model, const CoverageOfFrames& of,
              const Eigen::VectorXd& time, const Stance& stance, DynamicsEvidence& evidence) {
  LoadCoverage solved{of.coverage->feet, {}};
  for (Eigen::Index f = 0; f < time.size(); ++f) {
    solved.loads.push_back(of.coverage->loads[static_cast<std::size_t>(of.first + f)]);
  }
  for (std::size_t foot = 0; foot < solved.feet.size(); ++foot) {
    FootEvidence e;
    e.name = solved.feet[foot];
    e.complete = solved.complete_frames(foot);
    e.times = complete_times(solved, foot, time);
    std::vector<int> bodies;
    for (const int body : stance.feet) {
      const int side = side_of_body(model, body);
      if (side == (e.name == "right" ? 1 : e.name == "left" ? -1 : 0)) bodies.push_back(body);
    }
    e.torques = supporting_coordinates(model, bodies);
    evidence.feet.push_back(e);
  }
}

}  // namespace

DynamicsEvidence dynamics_evidence(const MusculoskeletalModel& model, const TimeTable& forces,
                                   const ExternalLoads& loads, const CoverageOfFrames& of) {
  DynamicsEvidence e;
  const Stance stance = default_stance(model);
  const ModelEvidence body = model_evidence(model);
  e.floating = is_floating(model);
  e.loads_given = loads.size() > 0;
  e.by_platforms = of.coverage != nullptr;
  e.weight = body.mass * model.gravity.norm();
  e.height = body.height;
  e.frames = static_cast<int>(forces.time.size());
  for (std::size_t c = 0; c < model.coordinates.size(); ++c) {
    if (of_virtual_link(model, static_cast<int>(c))) continue;
    e.coordinates.push_back(model.coordinates[c].name);
  }
  const std::vector<int> loaded = loaded_bodies(loads, forces.time);
  e.supporting = supporting_coordinates(model, loaded.empty() ? stance.feet : loaded);

  const RootColumns root = root_columns(model, forces);
  const Eigen::VectorXd force = lengths(forces, root.forces),
                        moment = lengths(forces, root.moments),
                        hangs = root.vertical < 0
                                    ? force
                                    : Eigen::VectorXd(root.sign * forces.values.col(root.vertical));
  std::vector<bool> known(static_cast<std::size_t>(e.frames));
  for (std::size_t f = 0; f < known.size(); ++f) {
    known[f] = e.by_platforms
                   ? of.coverage->complete(static_cast<std::size_t>(of.first) + f)
                   : hangs[static_cast<Eigen::Index>(f)] <= limits::kUncarried * e.weight;
  }
  e.known = static_cast<int>(std::count(known.begin(), known.end(), true));
  e.root = {rms_where(force, known), max_where(force, known), rms_where(moment, known),
            max_where(moment, known)};
  if (e.loads_given) add_loads(model, forces, loads, known, root, hangs, e);
  if (e.by_platforms) {
    add_feet(model, of, forces.time, stance, e);
    // Measured best where nobody moves, then over whole strides; what is left tells roughly.
    e.mass_of_some_frames = std::isnan(of.stride_mass) && std::isnan(of.standing_mass);
    if (!e.mass_of_some_frames) {
      e.carried_mass = std::isnan(of.stride_mass) ? of.standing_mass : of.stride_mass;
    } else if (root.vertical < 0) {
      e.carried_mass = kNaN;
    }
  } else if (root.vertical < 0) {
    e.carried_mass = kNaN;
  }
  return e;
}

std::vector<std::string> coordinates_not_given(const MusculoskeletalModel& model,
                                               const CoordinateTable& motion) {
  std::set<int> dependent;
  for (const CoordinateCoupler& coupler : model.couplers) dependent.insert(coupler.dependent);
  std::vector<std::string> names;
  for (std::size_t c = 0; c < model.coordinates.size(); ++c) {
    const Coordinate& coordinate = model.coordinates[c];
    if (motion.measured[c] || coordinate.locked || coordinate.prescribed) continue;
    const int index = static_cast<int>(c);
    if (dependent.contains(index) || of_virtual_link(model, index)) continue;
    names.push_back(coordinate.name);
  }
  return names;
}

}  // namespace sinew
