#include "ik/marker_attachment.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "ik/curvature.h"
#include "ik/marker_coverage.h"

namespace sinew {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;

// Columns: directions of the unknowns in which no measured marker moves.
MatrixXd null_space(const KinematicTree& tree, const TrackingProblem& alone,
                    const IkTargets& targets, KinematicWorkspace& ws) {
  constexpr double kNullEigenvalue = 1e-10;  // of the largest: rounding of a sum of squares
  CostCurvature curvature(tree, alone.problem);
  MatrixXd H(tree.unknown_count(), tree.unknown_count());
  curvature.update(tree, alone.problem, targets, ws);
  curvature.matrix(alone.problem, targets, ws, H);
  const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(H);
  Eigen::Index count = 0;
  while (count < H.rows() &&
         solver.eigenvalues()[count] <= kNullEigenvalue * solver.eigenvalues()[H.rows() - 1]) {
    ++count;
  }
  return solver.eigenvectors().leftCols(count);
}

std::vector<bool> determined_bodies(const KinematicTree& tree, const TrackingProblem& tracking,
                                    const MarkerTrajectories& markers, int frame,
                                    KinematicWorkspace& ws) {
  constexpr double kMoves = 1e-3;  // of a body, by a unit step [rad, m]
  const TrackingProblem alone = markers_alone(tracking);
  IkTargets targets(alone.problem);
  set_targets(alone, markers, frame, targets);
  update_kinematics(tree, ws);
  const MatrixXd free = null_space(tree, alone, targets, ws);
  std::vector<bool> determined(static_cast<std::size_t>(tree.link_count()), true);
  Eigen::Matrix3Xd J(3, tree.unknown_count());
  for (int b = 1; b < tree.link_count(); ++b) {
    if (free.cols() == 0) break;
    station_jacobian(tree, ws, b, Vector3d::Zero(), J);
    double moves = (J * free).cwiseAbs().maxCoeff();
    rotation_jacobian(tree, ws, b, J);
    moves = std::max(moves, (J * free).cwiseAbs().maxCoeff());
    determined[static_cast<std::size_t>(b)] = moves < kMoves;
  }
  return determined;
}

// RMS by which a point that is fixed in body `b` moves in body `c`.
double relative_spread(const BodyPoses& poses, int b, int c, const Vector3d& p_BM) {
  Vector3d sum = Vector3d::Zero();
  double squares = 0.0;
  for (const std::vector<RigidTransform>& X_WB : poses.X_WB) {
    const Vector3d p =
        X_WB[static_cast<std::size_t>(c)].inverse() * (X_WB[static_cast<std::size_t>(b)] * p_BM);
    sum += p;
    squares += p.squaredNorm();
  }
  const auto n = static_cast<double>(poses.X_WB.size());
  return std::sqrt(std::max(0.0, squares / n - (sum / n).squaredNorm()));
}

class Candidate {
 public:
  Candidate(const MusculoskeletalModel& model, const BodyPoses& poses,
            const MarkerTrajectories& markers, int marker, const AttachmentOptions& options)
      : model_(model), poses_(poses), options_(options) {
    result_.name = markers.names[static_cast<std::size_t>(marker)];
    result_.recorded = marker;
    for (std::size_t b = 0; b < model.bodies.size(); ++b) {
      const bool counts = poses.determined[b] && !model.bodies[b].virtual_link;
      places_.push_back(counts ? place_in_body(poses, markers, marker, static_cast<int>(b))
                               : PlaceInBody{});
    }
    seconds_ =
        places_[0].frames * (poses.X_WB.size() > 1 ? markers.time[1] - markers.time[0] : 0.0);
  }

  MarkerAttachment judge() {
    if (places_[0].frames < options_.least_frames || seconds_ < options_.least_seconds) {
      return ended(MarkerAttachment::Fate::kSeldom);
    }
    find_best();
    if (result_.body < 0) return ended(MarkerAttachment::Fate::kLoose);
    if (std::min(result_.spread, places_[0].spread) > options_.most_spread) {
      return ended(MarkerAttachment::Fate::kLoose);
    }
    if (!exceeds(places_[0].spread)) return ended(MarkerAttachment::Fate::kStill);
    if (result_.next_body >= 0 && !exceeds(result_.next_spread)) {
      return ended(MarkerAttachment::Fate::kAmbiguous);
    }
    if (distance_from_bone(model_, result_.body, result_.p_BM) > options_.farthest) {
      return ended(MarkerAttachment::Fate::kFar);
    }
    return ended(MarkerAttachment::Fate::kAttached);
  }

 private:
  bool exceeds(double spread) const {
    return spread > options_.margin * result_.spread &&
           spread > result_.spread + options_.least_difference;
  }

  void find_best() {
    for (std::size_t b = 1; b < places_.size(); ++b) {
      if (!(places_[b].spread < result_.spread || std::isnan(result_.spread))) continue;
      if (std::isnan(places_[b].spread)) continue;
      result_.body = static_cast<int>(b);
      result_.p_BM = places_[b].p_BM;
      result_.spread = places_[b].spread;
    }
    if (result_.body < 0) return;
    for (std::size_t b = 0; b < places_.size(); ++b) {
      const int body = static_cast<int>(b);
      if (body == result_.body || std::isnan(places_[b].spread)) continue;
      // Bodies that move alike, as heel bone and talus may, are one here.
      if (b > 0 &&
          relative_spread(poses_, result_.body, body, result_.p_BM) < options_.least_difference) {
        continue;
      }
      if (!std::isnan(result_.next_spread) && places_[b].spread >= result_.next_spread) continue;
      result_.next_body = body;
      result_.next_spread = places_[b].spread;
    }
  }

  MarkerAttachment ended(MarkerAttachment::Fate fate) {
    result_.fate = fate;
    return result_;
  }

  const MusculoskeletalModel& model_;
  const BodyPoses& poses_;
  const AttachmentOptions& options_;
  std::vector<PlaceInBody> places_;
  double seconds_ = 0.0;
  MarkerAttachment result_;
};

}  // namespace

void AttachmentOptions::validate() const {
  const auto require = [](const char* name, double value, double least) {
    if (std::isfinite(value) && value >= least) return;
    throw std::invalid_argument(fmt::format("{} is {}; expected {} or more", name, value, least));
  };
  require("most_spread", most_spread, 0.0);
  require("margin", margin, 1.0);
  require("least_difference", least_difference, 0.0);
  require("least_seconds", least_seconds, 0.0);
  require("least_frames", least_frames, 2.0);
  require("farthest", farthest, 0.0);
}

double MarkerAttachment::confidence() const {
  // Nothing else to compare with but the laboratory itself.
  if (std::isnan(next_spread) || !(next_spread > 0.0)) return 0.9;
  return std::clamp(1.0 - spread / next_spread, 0.0, 0.99);
}

BodyPoses body_poses(const MusculoskeletalModel& model, const KinematicTree& tree,
                     const TrackingProblem& tracking, const MarkerTrajectories& markers,
                     const TrackingResult& solved) {
  BodyPoses poses;
  KinematicWorkspace ws(tree);
  std::ptrdiff_t most = -1;
  for (std::size_t f = 0; f < solved.frames.size(); ++f) {
    for (std::size_t c = 0; c < model.coordinates.size(); ++c) {
      ws.q[static_cast<std::size_t>(tree.q_of_coordinate[c])] =
          solved.coordinates(static_cast<Eigen::Index>(f), static_cast<Eigen::Index>(c));
    }
    update_poses(tree, ws);
    poses.X_WB.push_back(ws.X_WB);
    const std::ptrdiff_t measured = solved.frames[f].measured_markers;
    if (measured <= most) continue;
    most = measured;
    poses.determined = determined_bodies(tree, tracking, markers, static_cast<int>(f), ws);
  }
  return poses;
}

PlaceInBody place_in_body(const BodyPoses& poses, const MarkerTrajectories& markers, int marker,
                          int body) {
  PlaceInBody place;
  Vector3d sum = Vector3d::Zero();
  double squares = 0.0;
  for (std::size_t f = 0; f < poses.X_WB.size(); ++f) {
    const Vector3d p_WM = markers.position(static_cast<int>(f), marker);
    if (!p_WM.allFinite()) continue;
    const Vector3d p = poses.X_WB[f][static_cast<std::size_t>(body)].inverse() * p_WM;
    sum += p;
    squares += p.squaredNorm();
    ++place.frames;
  }
  if (place.frames == 0) return place;
  place.p_BM = sum / place.frames;
  place.spread = std::sqrt(std::max(0.0, squares / place.frames - place.p_BM.squaredNorm()));
  return place;
}

std::vector<MarkerAttachment> find_attachments(const MusculoskeletalModel& model,
                                               const BodyPoses& poses,
                                               const MarkerTrajectories& markers,
                                               const std::vector<int>& candidates,
                                               const AttachmentOptions& options) {
  options.validate();
  std::vector<MarkerAttachment> attachments;
  for (const int marker : candidates) {
    attachments.push_back(Candidate(model, poses, markers, marker, options).judge());
  }
  return attachments;
}

double distance_from_bone(const MusculoskeletalModel& model, int body, const Vector3d& p_BM) {
  double nearest = (model.bodies[static_cast<std::size_t>(body)].p_BCm - p_BM).norm();
  for (const Joint& joint : model.joints) {
    if (joint.child == body) nearest = std::min(nearest, (joint.X_BM.p - p_BM).norm());
    if (joint.parent == body) nearest = std::min(nearest, (joint.X_PF.p - p_BM).norm());
  }
  for (const Marker& marker : model.markers) {
    if (marker.body == body) nearest = std::min(nearest, (marker.p_BM - p_BM).norm());
  }
  return nearest;
}

MarkerTrajectories some_frames(const MarkerTrajectories& markers, int first, int last, int count) {
  const int available = last - first + 1, used = std::min(count, available);
  MarkerTrajectories some;
  some.names = markers.names;
  some.rate = markers.rate;
  some.time.resize(used);
  some.p_WM.resize(used, markers.p_WM.cols());
  for (int i = 0; i < used; ++i) {
    const int frame =
        used == 1
            ? first
            : first + static_cast<int>(std::llround(double(i) * (available - 1) / (used - 1)));
    some.frame_numbers.push_back(markers.frame_numbers[static_cast<std::size_t>(frame)]);
    some.time[i] = markers.time[frame];
    some.p_WM.row(i) = markers.p_WM.row(frame);
  }
  return some;
}

}  // namespace sinew
