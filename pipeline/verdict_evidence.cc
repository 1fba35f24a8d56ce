#include "pipeline/verdict_evidence.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "data/conditioning.h"
#include "data/frame_continuity.h"
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

std::vector<VerdictReason> lock_reasons(const MusculoskeletalModel& model) {
  if (!stands_for_a_person(model)) return {};
  const auto locked = [&](int c) { return model.coordinates[static_cast<std::size_t>(c)].locked; };
  std::vector<std::string> names;
  for (std::size_t b = 1; b < model.bodies.size(); ++b) {
    const Joint& joint = model.joints[b - 1];
    const int other = partner_body(model, static_cast<int>(b));
    const Joint* partner = other > 0 ? &model.joints[static_cast<std::size_t>(other) - 1] : nullptr;
    for (std::size_t i = 0; i < joint.coordinates.size(); ++i) {
      if (!locked(joint.coordinates[i])) continue;
      const bool one_side =
          partner != nullptr && i < partner->coordinates.size() && !locked(partner->coordinates[i]);
      const bool root = joint.parent == 0 &&
                        !std::all_of(joint.coordinates.begin(), joint.coordinates.end(), locked);
      if (!one_side && !root) continue;
      names.push_back(model.coordinates[static_cast<std::size_t>(joint.coordinates[i])].name);
    }
  }
  if (names.empty()) return {};
  VerdictReason r =
      own_reason("locked",
                 fmt::format("the model locks {}, but not what moves with it or on the other side",
                             some_names(names)),
                 "unlock in the model what the person can move");
  r.angles = r.torques = std::move(names);
  return {r};
}

std::vector<VerdictReason> tracking_findings(const IkJob& job, const TrackingResult& result) {
  std::vector<VerdictReason> found = coverage_reasons(job, result);
  if (job.check_recording && stands_for_a_person(job.model)) {
    const MarkerTrajectories solved =
        slice(job.recording.markers, job.options.first_frame, job.options.end_frame);
    append(found, exchange_reasons(job.recording));
    append(found, frame_reasons(solved));
  }
  append(found, angle_jumps(job.model, result));
  append(found, job.reasons);
  append(found, lock_reasons(job.model));
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

}  // namespace sinew
