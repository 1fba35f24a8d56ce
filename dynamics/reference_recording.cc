#include "dynamics/reference_recording.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>

#include "dynamics/floor_forces.h"
#include "dynamics/furcation_pose.h"
#include "dynamics/reference_dynamics.h"
#include "dynamics/reference_motion.h"
#include "model/kinematic_tree.h"
#include "model/whole_body.h"

namespace sinew {

void ReferenceRecordingOptions::validate() const {
  const auto require = [](const char* field, double value) {
    if (value > 0.0 && std::isfinite(value)) return;
    throw std::invalid_argument(
        fmt::format("ReferenceRecordingOptions::{} is {}; it must be positive", field, value));
  };
  require("strides", strides);
  require("marker_rate", marker_rate);
  require("force_rate", force_rate);
  artifacts.validate();
}

namespace {

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
  Recorder(const ReferenceWalk& walk, const MusculoskeletalModel& model,
           const MarkerArtifacts& artifacts)
      : q(model.coordinates.size()),
        q_dot(q.size()),
        q_ddot(q.size()),
        walk_(walk),
        model_(model),
        artifacts_(artifacts),
        motion_(model, walk),
        dynamics_(model),
        tree_(compile_tree(model)),
        poses_(tree_) {
    for (const WalkFoot& foot : walk.feet) feet_.push_back(body_of(model, foot));
    if (model.virtual_link_count() > 0) furcations_.emplace(model);
  }

  void move_to(double time) {
    motion_.evaluate(time, q, q_dot, q_ddot);
    dynamics_.set_motion(q, q_dot, q_ddot);
    loads = share_wrench(walk_, time, dynamics_.mass_center(), dynamics_.required_wrench());
  }

  Eigen::VectorXd torques() { return dynamics_.generalized_forces(feet_, loads); }

  // Puts the virtual links where the bones' pose wants them.
  void place_links() {
    if (furcations_) furcations_->solve(q);
  }

  void place_markers(double phase, Eigen::Ref<Eigen::RowVectorXd> p_WM) {
    for (std::size_t c = 0; c < q.size(); ++c) {
      poses_.q[static_cast<std::size_t>(tree_.q_of_coordinate[c])] = q[c];
    }
    update_poses(tree_, poses_);
    for (int m = 0; m < static_cast<int>(model_.markers.size()); ++m) {
      const int body = model_.markers[static_cast<std::size_t>(m)].body;
      const RigidTransform& X_WB = poses_.X_WB[static_cast<std::size_t>(body)];
      p_WM.segment<3>(3 * m) = (X_WB * moved_marker(artifacts_, model_, m, phase)).transpose();
    }
  }

  std::vector<double> q, q_dot, q_ddot;
  std::vector<FloorLoad> loads;

 private:
  const ReferenceWalk& walk_;
  const MusculoskeletalModel& model_;
  const MarkerArtifacts& artifacts_;
  ReferenceMotion motion_;
  ReferenceDynamics dynamics_;
  std::optional<FurcationPose> furcations_;
  KinematicTree tree_;
  KinematicWorkspace poses_;
  std::vector<int> feet_;
};

// 0, 1/rate, … up to the duration's end.
Eigen::VectorXd sample_times(double duration, double rate) {
  const auto last = static_cast<Eigen::Index>(std::floor(duration * rate + 1e-9));  // rounding
  return Eigen::VectorXd::LinSpaced(last + 1, 0.0, static_cast<double>(last)) / rate;
}

MarkerTrajectories empty_trajectories(const MusculoskeletalModel& model, double duration,
                                      double rate) {
  MarkerTrajectories markers;
  markers.rate = rate;
  markers.time = sample_times(duration, rate);
  for (int i = 1; i <= markers.time.size(); ++i) markers.frame_numbers.push_back(i);
  for (const Marker& marker : model.markers) markers.names.push_back(marker.name);
  markers.p_WM.resize(markers.time.size(), 3 * static_cast<Eigen::Index>(model.markers.size()));
  return markers;
}

bool of_virtual_link(const MusculoskeletalModel& model, const Coordinate& c) {
  return model.bodies[static_cast<std::size_t>(c.joint) + 1].virtual_link;
}

void prepare_tables(ReferenceRecording& r) {
  r.true_coordinates.name = "Coordinates";
  r.true_speeds.name = "Speeds";
  r.true_accelerations.name = "Accelerations";
  r.true_forces.name = "Inverse Dynamics Generalized Forces";
  for (const Coordinate& c : r.model.coordinates) {
    r.true_coordinates.labels.push_back(c.name);
    if (of_virtual_link(r.model, c)) continue;
    const bool turns = c.motion == Coordinate::Motion::kRotational;
    r.true_forces.labels.push_back(c.name + (turns ? "_moment" : "_force"));
  }
  r.true_speeds.labels = r.true_accelerations.labels = r.true_coordinates.labels;
  for (TimeTable* table :
       {&r.true_coordinates, &r.true_speeds, &r.true_accelerations, &r.true_forces}) {
    table->in_degrees = false;
    table->time = r.markers.time;
    table->values.resize(r.markers.time.size(), static_cast<Eigen::Index>(table->labels.size()));
  }
}

// Forces go on to the last frame's end, as platforms measure several samples a frame.
void prepare_forces(const ReferenceRecordingOptions& options, const ReferenceWalk& walk,
                    ReferenceRecording& r) {
  const double frames_end = r.markers.time[r.markers.time.size() - 1] + 1.0 / options.marker_rate;
  r.forces.name = "Ground reaction forces";
  r.forces.in_degrees = false;
  r.forces.time = sample_times(frames_end - 1.0 / options.force_rate, options.force_rate);
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

// One row of all that is sampled with the markers.
void record_markers(const ReferenceWalk& walk, Eigen::Index row, Recorder& recorder,
                    ReferenceRecording& r) {
  const double time = r.markers.time[row];
  recorder.move_to(time);
  const Eigen::VectorXd torques = recorder.torques();
  Eigen::Index column = 0;
  for (std::size_t c = 0; c < r.model.coordinates.size(); ++c) {
    if (of_virtual_link(r.model, r.model.coordinates[c])) continue;
    r.true_forces.values(row, column++) = torques[static_cast<Eigen::Index>(c)];
  }
  recorder.place_links();
  recorder.place_markers(time / walk.stride_time, r.markers.p_WM.row(row));
  const auto copy = [row](const std::vector<double>& values, TimeTable& table) {
    std::copy(values.begin(), values.end(), table.values.row(row).begin());
  };
  copy(recorder.q, r.true_coordinates);
  copy(recorder.q_dot, r.true_speeds);
  copy(recorder.q_ddot, r.true_accelerations);
}

}  // namespace

ReferenceRecording make_reference_recording(const MusculoskeletalModel& model,
                                            const ReferenceWalk& walk,
                                            const ReferenceRecordingOptions& options) {
  options.validate();
  ReferenceRecording r;
  r.model = model;
  r.markers = empty_trajectories(model, options.strides * walk.stride_time, options.marker_rate);
  prepare_tables(r);
  prepare_forces(options, walk, r);
  Recorder recorder(walk, r.model, options.artifacts);
  for (Eigen::Index i = 0; i < r.markers.time.size(); ++i) record_markers(walk, i, recorder, r);
  for (Eigen::Index i = 0; i < r.forces.time.size(); ++i) {
    recorder.move_to(r.forces.time[i]);
    Eigen::Index column = 0;
    for (const FloorLoad& load : recorder.loads) {
      r.forces.values.row(i).segment<9>(column) << load.force.transpose(), load.point.transpose(),
          load.torque.transpose();
      column += 9;
    }
  }
  spoil_markers(options.artifacts, r.markers);
  return r;
}

ReferenceRecording make_reference_recording(const ReferenceRecordingOptions& options) {
  return make_reference_recording(whole_body(), reference_walk(), options);
}

MarkerTrajectories make_static_recording(const MusculoskeletalModel& model,
                                         const ReferenceRecordingOptions& options) {
  options.validate();
  constexpr double kDuration = 1.0;  // [s]
  MarkerTrajectories markers = empty_trajectories(model, kDuration, options.marker_rate);
  const KinematicTree tree = compile_tree(model);
  KinematicWorkspace poses(tree);
  poses.q = tree.default_q;
  update_poses(tree, poses);
  for (Eigen::Index m = 0; m < static_cast<Eigen::Index>(model.markers.size()); ++m) {
    const Marker& marker = model.markers[static_cast<std::size_t>(m)];
    const Eigen::Vector3d p_WM = poses.X_WB[static_cast<std::size_t>(marker.body)] * marker.p_BM;
    markers.p_WM.middleCols<3>(3 * m).rowwise() = p_WM.transpose();
  }
  spoil_markers(options.artifacts, markers);
  return markers;
}

}  // namespace sinew
