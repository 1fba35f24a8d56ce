#include "pipeline/dynamics_evidence.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "data/numbers.h"
#include "model/limb_paths.h"
#include "pipeline/verdict_evidence.h"
#include "pipeline/verdict_limits.h"

namespace sinew {
namespace {

// Forces on one body, or on all of them: frames × 3 in ground's axes.
struct Pushing {
  int body = -1;  // -1: all
  RowMatrix forces;
};

// Of all loads, then of every loaded body; false if some are given in other axes than ground's.
bool sum_loads(const ExternalLoads& loads, const Eigen::VectorXd& time,
               std::vector<Pushing>& sums) {
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
  struct Shift {
    int column = -1;
    Eigen::Vector3d axis;  // in ground
  };
  std::vector<int> forces, moments;
  std::vector<Shift> level;  // forces along a horizontal axis of ground
  int vertical = -1;         // the force along up, where a coordinate is just that
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

std::string axis_name(const RootColumns::Shift& shift) {
  int axis = 0;
  shift.axis.cwiseAbs().maxCoeff(&axis);
  return std::string(1, static_cast<char>('x' + axis));
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

// RMS over the frames that are wanted, or over all where none is.
double rms_where(const Eigen::VectorXd& values, const std::vector<bool>& wanted) {
  double sum = 0.0, all = 0.0;
  int count = 0;
  for (Eigen::Index f = 0; f < values.size(); ++f) {
    all += values[f] * values[f];
    if (!wanted[static_cast<std::size_t>(f)]) continue;
    sum += values[f] * values[f];
    ++count;
  }
  if (count > 0) return std::sqrt(sum / count);
  return std::sqrt(all / static_cast<double>(std::max<Eigen::Index>(values.size(), 1)));
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

// Frames in which a load is looked at, all of them or those of one contact.
struct Looked {
  std::vector<bool> frames;
  std::string times;
};

// The known frames, and those of each contact of the load that is known for long enough to tell.
std::vector<Looked> looks_at(const Pushing& pushing, const Eigen::VectorXd& time,
                             const std::vector<bool>& known) {
  constexpr double kLongEnough = 0.3;  // [s] half of a stance
  std::vector<Looked> looks{{known, ""}};
  if (pushing.body < 0) return looks;
  const auto n = static_cast<Eigen::Index>(known.size());
  for (Eigen::Index f = 0; f < n; ++f) {
    Looked contact{std::vector<bool>(known.size()), ""};
    const Eigen::Index first = f;
    while (f < n && known[static_cast<std::size_t>(f)] &&
           pushing.forces.row(f).norm() > kContactForce) {
      contact.frames[static_cast<std::size_t>(f++)] = true;
    }
    if (f == first || time[f - 1] - time[first] < kLongEnough) continue;
    contact.times = fmt::format("from {:.2f} s to {:.2f} s", time[first], time[f - 1]);
    looks.push_back(std::move(contact));
  }
  if (looks.size() == 2) looks.pop_back();  // the only one
  return looks;
}

// What the body's movement needs of the load is that load and what is left at the root.
PushEvidence push_along(const RootColumns::Shift& shift, const RowMatrix& forces,
                        const TimeTable& table, const Looked& looked) {
  PushEvidence push;
  push.times = looked.times;
  push.axis = axis_name(shift);
  const Eigen::VectorXd load = forces * shift.axis, need = load + table.values.col(shift.column);
  double dot = 0.0;
  for (Eigen::Index f = 0; f < load.size(); ++f) {
    if (looked.frames[static_cast<std::size_t>(f)]) dot += load[f] * need[f];
  }
  const auto n = static_cast<double>(std::count(looked.frames.begin(), looked.frames.end(), true));
  push.load_rms = rms_where(load, looked.frames);
  push.need_rms = rms_where(need, looked.frames);
  push.cosine = dot / (n * push.load_rms * push.need_rms);
  push.acts_rms = rms_where(forces.rowwise().norm(), looked.frames);
  return push;
}

TurnEvidence turn_of(const RootColumns& root, const RowMatrix& forces, const TimeTable& table,
                     const Looked& looked) {
  TurnEvidence turn;
  turn.times = looked.times;
  const RootColumns::Shift &first = root.level[0], &second = root.level[1];
  const Eigen::VectorXd x = forces * first.axis, z = forces * second.axis,
                        left_x = table.values.col(first.column),
                        left_z = table.values.col(second.column);
  turn.load_rms = std::hypot(rms_where(x, looked.frames), rms_where(z, looked.frames));
  const double now = std::hypot(rms_where(left_x, looked.frames), rms_where(left_z, looked.frames));
  const std::string a = axis_name(first), b = axis_name(second);
  for (const double s : {1.0, -1.0}) {
    for (const double t : {1.0, -1.0}) {
      // The load would be (s z, t x): what is left gets the difference.
      const double then = std::hypot(rms_where(left_x + x - s * z, looked.frames),
                                     rms_where(left_z + z - t * x, looked.frames));
      if (then / now >= turn.left) continue;
      turn.left = then / now;
      turn.axes =
          fmt::format("{} is {}{}, {} is {}{}", a, s < 0.0 ? "-" : "", b, b, t < 0.0 ? "-" : "", a);
    }
  }
  return turn;
}

// Sums of the loads, and the mass that they carry in the known frames, in which `hangs` is what is
// left at the root, upwards.
void add_loads(const MusculoskeletalModel& model, const TimeTable& forces,
               const ExternalLoads& loads, const std::vector<bool>& known, const RootColumns& root,
               const Eigen::VectorXd& hangs, DynamicsEvidence& e) {
  std::vector<Pushing> pushing;
  const bool in_ground = sum_loads(loads, forces.time, pushing);
  const RowMatrix& sums = pushing[0].forces;
  e.peak_load = sums.rowwise().norm().maxCoeff();
  if (!in_ground) return;
  for (const Pushing& of : pushing) {
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
  for (const Pushing& of : pushing) {
    const std::string body =
        of.body < 0 ? std::string() : model.bodies[static_cast<std::size_t>(of.body)].name;
    for (const Looked& looked : looks_at(of, forces.time, known)) {
      // One body's is the sum.
      if (of.body >= 0 && pushing.size() == 2 && looked.times.empty()) continue;
      for (const RootColumns::Shift& shift : root.level) {
        e.pushes.push_back(push_along(shift, of.forces, forces, looked));
        e.pushes.back().body = body;
      }
      if (root.level.size() != 2) continue;
      e.turns.push_back(turn_of(root, of.forces, forces, looked));
      e.turns.back().body = body;
    }
  }
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
