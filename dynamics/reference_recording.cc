#include "dynamics/reference_recording.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <stdexcept>

#include "model/osim_file.h"

namespace sinew {
namespace {

using Eigen::Vector3d;

constexpr const char* kModelName = "the reference walk's model";

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

void ReferenceRecordingOptions::validate() const {
  const auto require = [](bool good, const char* field, double value, const char* bound) {
    if (good) return;
    throw std::invalid_argument(
        fmt::format("ReferenceRecordingOptions::{} is {}; it must be {}", field, value, bound));
  };
  const auto positive = [](double x) { return x > 0.0 && std::isfinite(x); };
  require(positive(strides), "strides", strides, "positive");
  require(positive(marker_rate), "marker_rate", marker_rate, "positive");
  require(positive(force_rate), "force_rate", force_rate, "positive");
  require(marker_noise >= 0.0 && std::isfinite(marker_noise), "marker_noise", marker_noise,
          "0 or more metres");
  require(occlusion >= 0.0 && occlusion < 1.0, "occlusion", occlusion, "from 0 to below 1");
}

ReferenceMotion::ReferenceMotion(const MusculoskeletalModel& model, const ReferenceWalk& walk)
    : curves_(walk.curves), stride_time_(walk.stride_time) {
  for (const Coordinate& c : model.coordinates) defaults_.push_back(c.default_value);
  for (const CoordinateCoupler& c : model.couplers) {
    couplers_.push_back({static_cast<std::size_t>(c.dependent),
                         static_cast<std::size_t>(c.independent), CompiledFunction(c.function)});
  }
  for (const WalkCurve& curve : curves_) {
    const int c = model.find_coordinate(curve.coordinate);
    const auto moves = [&](const CoordinateCoupler& coupler) { return coupler.dependent == c; };
    if (c < 0 || std::any_of(model.couplers.begin(), model.couplers.end(), moves)) {
      throw InputError({"the reference walk", 0},
                       {fmt::format("a curve for '{}'", curve.coordinate),
                        "an uncoupled coordinate of the model", "", "Correct the name."});
    }
    coordinates_.push_back(static_cast<std::size_t>(c));
  }
}

void ReferenceMotion::evaluate(double time, std::span<double> q, std::span<double> q_dot,
                               std::span<double> q_ddot) const {
  std::copy(defaults_.begin(), defaults_.end(), q.begin());
  std::fill(q_dot.begin(), q_dot.end(), 0.0);
  std::fill(q_ddot.begin(), q_ddot.end(), 0.0);
  const double phase = time / stride_time_, rate = 1.0 / stride_time_;
  for (std::size_t i = 0; i < curves_.size(); ++i) {
    const WalkCurve& curve = curves_[i];
    const auto [f, df, ddf] = sinew::evaluate(curve.series, phase - curve.delay);
    const std::size_t c = coordinates_[i];
    q[c] = f + curve.advance * phase;
    q_dot[c] = (df + curve.advance) * rate;
    q_ddot[c] = ddf * rate * rate;
  }
  for (const Coupler& coupler : couplers_) {
    const auto f = coupler.function.evaluate(q[coupler.independent]);
    const double v = q_dot[coupler.independent];
    q[coupler.dependent] = f.f;
    q_dot[coupler.dependent] = f.df * v;
    q_ddot[coupler.dependent] = f.ddf * v * v + f.df * q_ddot[coupler.independent];
  }
}

std::vector<FootLoad> share_wrench(const ReferenceWalk& walk, double time, const Vector3d& p_WC,
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

  std::vector<FootLoad> loads(steps.size());
  Vector3d rest = F;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    if (steps[i].share == 0.0) continue;
    FootLoad& load = loads[i];
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

ReferenceDynamics::ReferenceDynamics(const MusculoskeletalModel& model)
    : model_(model),
      compiled_(model),
      tree_(compile_tree(model)),
      kinematics_(tree_),
      state_(compiled_.default_state()),
      u_dot_(state_.getNU(), 0.0),
      residual_(state_.getNU(), 0.0),
      gravity_(compiled_.matter().getNumBodies()),
      applied_(compiled_.matter().getNumBodies()) {
  if (model.joints.empty() || model.joints[0].coordinates.size() != 6) {
    throw InputError({kModelName, 0},
                     {"the root cannot move freely", "6 coordinates in the first joint", "", ""});
  }
  for (const Joint& joint : model.joints) {
    if (joint.kind == Joint::Kind::kBall || joint.kind == Joint::Kind::kFree) {
      throw InputError(
          joint.source,
          {fmt::format("joint '{}' has speeds that are not its coordinates' rates", joint.name), "",
           "", "Replace it by a CustomJoint."});
    }
  }
}

void ReferenceDynamics::set_motion(std::span<const double> q, std::span<const double> q_dot,
                                   std::span<const double> q_ddot) {
  for (std::size_t c = 0; c < q.size(); ++c) {
    const int coordinate = static_cast<int>(c);
    kinematics_.q[static_cast<std::size_t>(tree_.q_of_coordinate[c])] = q[c];
    state_.updQ()[compiled_.q_index(coordinate)] = q[c];
    state_.updU()[compiled_.u_index(coordinate)] = q_dot[c];
    u_dot_[compiled_.u_index(coordinate)] = q_ddot[c];
  }
  update_kinematics(tree_, kinematics_);
  compiled_.system().realize(state_, SimTK::Stage::Velocity);
  gravity_.setToZero();
  for (std::size_t b = 1; b < model_.bodies.size(); ++b) {
    const Body& body = model_.bodies[b];
    const Vector3d weight = body.mass * model_.gravity;
    const Vector3d arm = kinematics_.X_WB[b].R * body.p_BCm;
    gravity_[compiled_.body(static_cast<int>(b))] =
        SimTK::SpatialVec(to_simtk(arm.cross(weight)), to_simtk(weight));
  }
}

Vector3d ReferenceDynamics::mass_center() const {
  return to_eigen(compiled_.matter().calcSystemMassCenterLocationInGround(state_));
}

Eigen::VectorXd ReferenceDynamics::solve(const SimTK::Vector_<SimTK::SpatialVec>& applied) {
  compiled_.matter().calcResidualForceIgnoringConstraints(
      state_, SimTK::Vector(state_.getNU(), 0.0), applied, u_dot_, residual_);
  Eigen::VectorXd tau(compiled_.coordinate_count());
  for (int c = 0; c < tau.size(); ++c) tau[c] = residual_[compiled_.u_index(c)];
  return tau;
}

Vector6d ReferenceDynamics::required_wrench() {
  const Eigen::VectorXd tau = solve(gravity_);
  Matrix6d S;
  Vector6d root;
  for (int k = 0; k < 6; ++k) {
    const int c = model_.joints[0].coordinates[static_cast<std::size_t>(k)];
    S.row(k) =
        kinematics_.S[static_cast<std::size_t>(tree_.v_of_coordinate[static_cast<std::size_t>(c)])];
    root[k] = tau[c];
  }
  Vector6d wrench = S.partialPivLu().solve(root);  // about the root's origin
  wrench.head<3>() += kinematics_.X_WB[1].p.cross(wrench.tail<3>());
  return wrench;
}

Eigen::VectorXd ReferenceDynamics::generalized_forces(std::span<const int> bodies,
                                                      std::span<const FootLoad> loads) {
  applied_ = gravity_;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const Vector3d arm = loads[i].point - kinematics_.X_WB[static_cast<std::size_t>(bodies[i])].p;
    const Vector3d moment = arm.cross(loads[i].force) + loads[i].torque;
    applied_[compiled_.body(bodies[i])] +=
        SimTK::SpatialVec(to_simtk(moment), to_simtk(loads[i].force));
  }
  return solve(applied_);
}

namespace {

constexpr double kGap = 0.1;  // of an occluded marker [s]

int body_of(const MusculoskeletalModel& model, const WalkFoot& foot) {
  const int body = model.find_body(foot.body);
  if (body >= 0) return body;
  throw InputError(
      {"the reference walk", 0},
      {"a foot is no body of the model", "the name of a body", foot.body, "Correct the name."});
}

// All that is evaluated at one time.
class Recorder {
 public:
  Recorder(const ReferenceWalk& walk, const MusculoskeletalModel& model)
      : q(model.coordinates.size()),
        q_dot(q.size()),
        q_ddot(q.size()),
        walk_(walk),
        model_(model),
        motion_(model, walk),
        dynamics_(model),
        tree_(compile_tree(model)),
        poses_(tree_) {
    for (const WalkFoot& foot : walk.feet) feet_.push_back(body_of(model, foot));
  }

  void move_to(double time) {
    motion_.evaluate(time, q, q_dot, q_ddot);
    dynamics_.set_motion(q, q_dot, q_ddot);
    loads = share_wrench(walk_, time, dynamics_.mass_center(), dynamics_.required_wrench());
  }

  Eigen::VectorXd torques() { return dynamics_.generalized_forces(feet_, loads); }

  void place_markers(Eigen::Ref<Eigen::RowVectorXd> p_WM) {
    for (std::size_t c = 0; c < q.size(); ++c) {
      poses_.q[static_cast<std::size_t>(tree_.q_of_coordinate[c])] = q[c];
    }
    update_poses(tree_, poses_);
    for (std::size_t m = 0; m < model_.markers.size(); ++m) {
      const Marker& marker = model_.markers[m];
      const RigidTransform& X_WB = poses_.X_WB[static_cast<std::size_t>(marker.body)];
      p_WM.segment<3>(3 * static_cast<Eigen::Index>(m)) = (X_WB * marker.p_BM).transpose();
    }
  }

  std::vector<double> q, q_dot, q_ddot;
  std::vector<FootLoad> loads;

 private:
  const ReferenceWalk& walk_;
  const MusculoskeletalModel& model_;
  ReferenceMotion motion_;
  ReferenceDynamics dynamics_;
  KinematicTree tree_;
  KinematicWorkspace poses_;
  std::vector<int> feet_;
};

// 0, 1/rate, … up to the recording's end.
Eigen::VectorXd sample_times(const ReferenceWalk& walk, double strides, double rate) {
  const double duration = strides * walk.stride_time;
  const auto last = static_cast<Eigen::Index>(std::floor(duration * rate + 1e-9));  // rounding
  return Eigen::VectorXd::LinSpaced(last + 1, 0.0, static_cast<double>(last)) / rate;
}

void prepare_tables(const ReferenceRecordingOptions& options, const ReferenceWalk& walk,
                    ReferenceRecording& r) {
  const MusculoskeletalModel& model = r.model;
  r.markers.rate = options.marker_rate;
  r.markers.time = sample_times(walk, options.strides, options.marker_rate);
  const Eigen::Index frames = r.markers.time.size();
  for (int i = 1; i <= frames; ++i) r.markers.frame_numbers.push_back(i);
  for (const Marker& marker : model.markers) r.markers.names.push_back(marker.name);
  r.markers.p_WM.resize(frames, 3 * static_cast<Eigen::Index>(model.markers.size()));

  r.true_coordinates.name = "Coordinates";
  r.true_forces.name = "Inverse Dynamics Generalized Forces";
  for (const Coordinate& c : model.coordinates) {
    const bool turns = c.motion == Coordinate::Motion::kRotational;
    r.true_coordinates.labels.push_back(c.name);
    r.true_forces.labels.push_back(c.name + (turns ? "_moment" : "_force"));
  }
  for (TimeTable* table : {&r.true_coordinates, &r.true_forces}) {
    table->in_degrees = false;
    table->time = r.markers.time;
    table->values.resize(frames, static_cast<Eigen::Index>(model.coordinates.size()));
  }
}

void prepare_forces(const ReferenceRecordingOptions& options, const ReferenceWalk& walk,
                    ReferenceRecording& r) {
  r.forces.name = "Ground reaction forces";
  r.forces.in_degrees = false;
  r.forces.time = sample_times(walk, options.strides, options.force_rate);
  for (const WalkFoot& foot : walk.feet) {
    ExternalForce force;
    force.name = "floor_" + foot.side;
    force.applied_to_body = foot.body;
    force.force_identifier = "ground_force_" + foot.side + "_v";
    force.point_identifier = "ground_force_" + foot.side + "_p";
    force.torque_identifier = "ground_torque_" + foot.side + "_";
    r.loads.forces.push_back(force);
    for (const std::string& part :
         {force.force_identifier, force.point_identifier, force.torque_identifier}) {
      for (const char* axis : {"x", "y", "z"}) r.forces.labels.push_back(part + axis);
    }
  }
  r.forces.values.resize(r.forces.time.size(), static_cast<Eigen::Index>(r.forces.labels.size()));
  r.loads.path = "the reference walk's loads";
  bind_columns(r.loads, r.forces.labels, "the reference walk's forces");
}

// Box & Muller's normal deviate from two uniform ones: the same on every platform, which
// std::normal_distribution is not.
double normal_deviate(std::mt19937_64& random) {
  const auto uniform = [&] { return (static_cast<double>(random() >> 11) + 0.5) * 0x1p-53; };
  const double radius = std::sqrt(-2.0 * std::log(uniform()));
  return radius * std::cos(2.0 * std::numbers::pi * uniform());
}

void spoil_markers(const ReferenceRecordingOptions& options, MarkerTrajectories& markers) {
  std::mt19937_64 random(options.seed);
  if (options.marker_noise > 0.0) {
    for (double& x : markers.p_WM.reshaped()) x += options.marker_noise * normal_deviate(random);
  }
  const auto frames = static_cast<std::uint64_t>(markers.frame_count());
  const auto gap = std::max<std::uint64_t>(1, std::llround(kGap * markers.rate));
  const double lost_frames = options.occlusion * static_cast<double>(frames);
  for (int m = 0; m < markers.marker_count() && lost_frames > 0.0; ++m) {
    auto p_WM = markers.p_WM.middleCols<3>(3 * m);
    for (double lost = 0.0; lost < std::floor(lost_frames);) {
      const auto first = random() % frames;
      for (auto i = first; i < std::min(frames, first + gap) && lost < lost_frames; ++i) {
        const auto frame = static_cast<Eigen::Index>(i);
        if (std::isnan(p_WM(frame, 0))) continue;
        p_WM.row(frame).setConstant(kNaN);
        lost += 1.0;
      }
    }
  }
}

}  // namespace

ReferenceRecording make_reference_recording(const ReferenceWalk& walk,
                                            const ReferenceRecordingOptions& options) {
  options.validate();
  ReferenceRecording r;
  r.model = parse_osim(kModelName, walk.model);
  prepare_tables(options, walk, r);
  prepare_forces(options, walk, r);
  Recorder recorder(walk, r.model);
  for (Eigen::Index i = 0; i < r.markers.time.size(); ++i) {
    recorder.move_to(r.markers.time[i]);
    recorder.place_markers(r.markers.p_WM.row(i));
    r.true_coordinates.values.row(i) =
        Eigen::Map<const Eigen::RowVectorXd>(recorder.q.data(), r.true_coordinates.values.cols());
    r.true_forces.values.row(i) = recorder.torques().transpose();
  }
  for (Eigen::Index i = 0; i < r.forces.time.size(); ++i) {
    recorder.move_to(r.forces.time[i]);
    Eigen::Index column = 0;
    for (const FootLoad& load : recorder.loads) {
      r.forces.values.row(i).segment<9>(column) << load.force.transpose(), load.point.transpose(),
          load.torque.transpose();
      column += 9;
    }
  }
  spoil_markers(options, r.markers);
  return r;
}

ReferenceRecording make_reference_recording(const ReferenceRecordingOptions& options) {
  return make_reference_recording(reference_walk(), options);
}

}  // namespace sinew
