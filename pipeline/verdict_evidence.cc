#include "pipeline/verdict_evidence.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "ik/angle_jumps.h"
#include "model/limb_paths.h"
#include "model/model_check.h"
#include "model/tree_pose.h"
#include "pipeline/finding_reasons.h"
#include "pipeline/reports.h"
#include "pipeline/undetermined.h"
#include "pipeline/verdict_limits.h"
#include "pipeline/verdict_reasons.h"

namespace sinew {
namespace {

const Coordinate& coordinate_of(const MusculoskeletalModel& model, int c) {
  return model.coordinates[static_cast<std::size_t>(c)];
}

bool of_virtual_link(const MusculoskeletalModel& model, int c) {
  const Joint& joint = model.joints[static_cast<std::size_t>(coordinate_of(model, c).joint)];
  return model.bodies[static_cast<std::size_t>(joint.child)].virtual_link;
}

// From the joint that carries a body to the farthest of those that it carries.
double length_of(const MusculoskeletalModel& model, int body) {
  const Eigen::Vector3d& begin = model.joints[static_cast<std::size_t>(body) - 1].X_BM.p;
  double length = 0.0;
  for (const Joint& joint : model.joints) {
    if (joint.parent != body || model.bodies[static_cast<std::size_t>(joint.child)].virtual_link) {
      continue;
    }
    length = std::max(length, (joint.X_PF.p - begin).norm());
  }
  return length;
}

// Coordinates of the nearest joint that moves the body.
std::vector<std::string> angles_of_body(const MusculoskeletalModel& model, int body) {
  std::vector<std::string> names;
  while (body > 0 && names.empty()) {
    const Joint& joint = model.joints[static_cast<std::size_t>(body) - 1];
    for (const int c : joint.coordinates) names.push_back(coordinate_of(model, c).name);
    body = joint.parent;
  }
  return names;
}

std::vector<MarkerEvidence> marker_evidence(const IkJob& job, const TrackingResult& result) {
  std::vector<MarkerEvidence> markers;
  const std::vector<MarkerError> errors = marker_errors(job.tracking, result);
  for (std::size_t m = 0; m < errors.size(); ++m) {
    const int body =
        job.model.markers[static_cast<std::size_t>(job.tracking.markers[m].model)].body;
    // What weighs nothing is shown, not fitted.
    if (!(errors[m].weight > 0.0)) continue;
    markers.push_back({shown_marker(job.recorded_names, errors[m].name), errors[m].measured,
                       errors[m].rms, errors[m].max, side_of_body(job.model, body),
                       angles_of_body(job.model, body)});
  }
  return markers;
}

double filled_share(const IkJob& job) {
  const auto& filled = job.tracking.filled;
  if (filled.size() == 0) return 0.0;
  const auto part =
      filled.middleRows(job.options.first_frame, job.options.end_frame - job.options.first_frame);
  return static_cast<double>(part.count()) / static_cast<double>(part.size());
}

// The body that a foot's limb hangs from ground by.
int pelvis_of(const MusculoskeletalModel& model, int foot) {
  int body = foot;
  while (true) {
    const int parent = model.joints[static_cast<std::size_t>(body) - 1].parent;
    if (parent == 0) return body;
    body = parent;
  }
}

CoordinateEvidence coordinate_evidence(const MusculoskeletalModel& model, int c,
                                       const Eigen::VectorXd& values) {
  constexpr double kAtBound = 1e-9;  // bounded coordinates are clipped to them exactly
  const Coordinate& coordinate = coordinate_of(model, c);
  CoordinateEvidence evidence;
  evidence.name = coordinate.name;
  evidence.rotational = coordinate.motion == Coordinate::Motion::kRotational;
  evidence.range = values.maxCoeff() - values.minCoeff();
  if (coordinate.clamped) {
    const auto at = [&](double bound) {
      return ((values.array() - bound).abs() < kAtBound).count();
    };
    evidence.on_bound = static_cast<double>(at(coordinate.range_min) + at(coordinate.range_max)) /
                        static_cast<double>(values.size());
  }
  for (const std::string& name : partner_names(coordinate.name)) {
    if (model.find_coordinate(name) > c) evidence.partner = name;
  }
  return evidence;
}

// Of at most a hundred frames; 0 for a model that stands for no person.
double fallen_share(const MusculoskeletalModel& model, const KinematicTree& tree,
                    const RowMatrix& coordinates) {
  const Stance stance = default_stance(model);
  if (!stands_for_a_person(model) || stance.feet.empty()) return 0.0;
  KinematicWorkspace ws(tree);
  const Eigen::Vector3d up = up_of(model);
  const Eigen::Index step = std::max<Eigen::Index>(1, coordinates.rows() / 100);
  int frames = 0, fallen = 0;
  for (Eigen::Index f = 0; f < coordinates.rows(); f += step) {
    pose_tree(tree, coordinates.row(f), ws);
    Eigen::Vector3d feet = Eigen::Vector3d::Zero();
    for (const int foot : stance.feet) feet += ws.X_WB[static_cast<std::size_t>(foot)].p;
    const int root = pelvis_of(model, stance.feet.front());
    const Eigen::Vector3d d =
        ws.X_WB[static_cast<std::size_t>(root)].p - feet / static_cast<double>(stance.feet.size());
    ++frames;
    fallen += up.dot(d) < 0.5 * d.norm();
  }
  return static_cast<double>(fallen) / std::max(frames, 1);
}

// Sums of all loads: frames × 3 in ground's axes; false if some are given in others.
bool sum_loads(const ExternalLoads& loads, const Eigen::VectorXd& time, RowMatrix& sums) {
  sums = RowMatrix::Zero(time.size(), 3);
  bool in_ground = true;
  for (int load = 0; load < loads.size(); ++load) {
    for (Eigen::Index f = 0; f < time.size(); ++f) {
      const ExternalLoads::Sample sample = loads.sample(load, time[f]);
      in_ground = in_ground && sample.force_frame == 0;
      sums.row(f) += sample.force.transpose();
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

// Markers by their weights in the static pose, which say how well each is known to be placed.
double weighted_rms(const std::vector<PlacedMarker>& markers) {
  double sum = 0.0, weight = 0.0;
  for (const PlacedMarker& m : markers) {
    if (!std::isfinite(m.distance)) continue;
    sum += m.weight * m.distance * m.distance;
    weight += m.weight;
  }
  return weight > 0.0 ? std::sqrt(sum / weight) : kNaN;
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

PushEvidence push_along(const RootColumns::Shift& shift, const RowMatrix& sums,
                        const TimeTable& forces, const std::vector<bool>& known) {
  PushEvidence push;
  int axis = 0;
  shift.axis.cwiseAbs().maxCoeff(&axis);
  push.axis = std::string(1, static_cast<char>('x' + axis));
  const Eigen::VectorXd load = sums * shift.axis, need = load + forces.values.col(shift.column);
  double dot = 0.0;
  for (Eigen::Index f = 0; f < load.size(); ++f) {
    if (known[static_cast<std::size_t>(f)]) dot += load[f] * need[f];
  }
  const auto n = static_cast<double>(std::count(known.begin(), known.end(), true));
  push.load_rms = rms_where(load, known);
  push.need_rms = rms_where(need, known);
  push.cosine = dot / (n * push.load_rms * push.need_rms);
  return push;
}

// Sums of the loads, and the mass that they carry in the known frames, in which `hangs` is what is
// left at the root, upwards.
void add_loads(const MusculoskeletalModel& model, const TimeTable& forces,
               const ExternalLoads& loads, const std::vector<bool>& known, const RootColumns& root,
               const Eigen::VectorXd& hangs, DynamicsEvidence& e) {
  RowMatrix sums;
  const bool in_ground = sum_loads(loads, forces.time, sums);
  e.peak_load = sums.rowwise().norm().maxCoeff();
  if (!in_ground) return;
  const Eigen::VectorXd vertical = sums * up_of(model);
  const auto n = static_cast<double>(vertical.size());
  e.mean_vertical_load = vertical.mean();
  e.vertical_load_rms = std::sqrt(vertical.squaredNorm() / n);
  e.horizontal_load_rms = std::sqrt(std::max(0.0, sums.squaredNorm() - vertical.squaredNorm()) / n);
  const double given = mean_where(vertical, known), left = mean_where(hangs, known);
  if (given > 0.0) e.carried_mass = model.total_mass() * given / (given + left);
  if (e.known == 0) return;
  for (const RootColumns::Shift& shift : root.level) {
    e.pushes.push_back(push_along(shift, sums, forces, known));
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

std::vector<JointEvidence> joint_evidence(const MusculoskeletalModel& model) {
  std::vector<JointEvidence> joints;
  for (const Joint& joint : model.joints) {
    if (joint.coordinates.empty() ||
        model.bodies[static_cast<std::size_t>(joint.child)].virtual_link) {
      continue;
    }
    JointEvidence e{joint.name, {}};
    for (const int c : joint.coordinates) e.coordinates.push_back(coordinate_of(model, c).name);
    joints.push_back(e);
  }
  return joints;
}

ModelEvidence model_evidence(const MusculoskeletalModel& model) {
  ModelEvidence evidence;
  evidence.mass = model.total_mass();
  const Stance stance = default_stance(model);
  evidence.height = stance.highest - stance.lowest;
  evidence.stands = stands_for_a_person(model);
  if (evidence.stands) {
    evidence.height = std::max(evidence.height, (stance.hip - stance.lowest) / limits::kHipHeight);
  }
  for (int b = 1; b < static_cast<int>(model.bodies.size()); ++b) {
    const int partner = partner_body(model, b);
    if (partner <= b) continue;
    const double a = length_of(model, b), c = length_of(model, partner);
    if (a == 0.0 || c == 0.0) continue;
    evidence.sides.push_back({model.bodies[static_cast<std::size_t>(b)].name,
                              model.bodies[static_cast<std::size_t>(partner)].name, a, c});
  }
  return evidence;
}

KinematicsEvidence kinematics_evidence(const IkJob& job, const TrackingResult& result,
                                       double static_rms, const std::vector<VerdictReason>& found) {
  KinematicsEvidence evidence;
  evidence.frames = static_cast<int>(result.frames.size());
  evidence.unconverged = unconverged_frames(result);
  for (const FrameResult& frame : result.frames) evidence.unmeasured += frame.measured_markers == 0;
  evidence.marker_rms = total_marker_rms(result);
  evidence.static_rms = static_rms;
  evidence.filled = filled_share(job);
  evidence.fallen = fallen_share(job.model, job.tree, result.coordinates);
  evidence.markers = marker_evidence(job, result);
  std::set<std::string> undetermined;
  for (const VerdictReason& r : found) undetermined.insert(r.angles.begin(), r.angles.end());
  for (std::size_t c = 0; c < job.model.coordinates.size(); ++c) {
    const int v = job.tree.v_of_coordinate[c];
    if (job.tree.unknown_of_v[static_cast<std::size_t>(v)] < 0) continue;
    if (of_virtual_link(job.model, static_cast<int>(c))) continue;
    evidence.coordinates.push_back(coordinate_evidence(
        job.model, static_cast<int>(c), result.coordinates.col(static_cast<Eigen::Index>(c))));
    evidence.coordinates.back().undetermined =
        undetermined.contains(evidence.coordinates.back().name);
  }
  return evidence;
}

std::vector<VerdictReason> tracking_findings(const IkJob& job, const TrackingResult& result) {
  std::vector<VerdictReason> found = coverage_reasons(job, result);
  if (job.find_exchanges && stands_for_a_person(job.model)) {
    const std::vector<VerdictReason> more = exchange_reasons(job.recording);
    found.insert(found.end(), more.begin(), more.end());
  }
  for (const std::vector<VerdictReason>& more : {angle_jumps(job.model, result), job.reasons}) {
    found.insert(found.end(), more.begin(), more.end());
  }
  return found;
}

ScaleEvidence scale_evidence(const ScaledModel& scaled) {
  ScaleEvidence evidence;
  const bool person = stands_for_a_person(scaled.document.model());
  for (std::size_t b = 1; person && b < scaled.bodies.size(); ++b) {
    const Eigen::Vector3d& f = scaled.factors.of_body[b];
    evidence.factors.push_back({scaled.bodies[b], f.minCoeff(), f.maxCoeff()});
  }
  if (scaled.placement) {
    evidence.converged = converged(scaled.placement->termination);
    evidence.pose_rms = weighted_rms(scaled.placement->markers);
    for (const PlacedMarker& m : scaled.placement->markers) {
      if (m.fate == PlacedMarker::Fate::kMoved && m.weight > 0.0) {
        evidence.moved.push_back({m.name, m.distance});
      }
    }
  }
  if (scaled.automatic) {
    evidence.converged = scaled.automatic->converged;
    evidence.pose_rms = scaled.automatic->rms_after;
    for (const MarkerOffset& o : scaled.automatic->offsets) {
      evidence.moved.push_back(
          {scaled.automatic->markers[static_cast<std::size_t>(o.marker)].name, o.offset.norm()});
    }
  }
  return evidence;
}

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
