#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "ik/tracking.h"

namespace sinew {

struct AttachmentOptions {
  // RMS by which a marker may move about its place on a bone [m]: soft tissue moves markers of the
  // thigh by up to 30 mm, others less (Leardini et al. 2005, Gait Posture 21:212-225).
  double most_spread = 0.02;
  // On the next body it must move by this times as much, and by this more [m], unless the two
  // bodies move alike there.
  double margin = 1.5, least_difference = 0.005;
  double least_seconds = 0.3;  // measured, half a step of a walk …
  int least_frames = 20;
  // From the nearest joint, mass centre or marker of the body [m]; as ModelCheckOptions'.
  double farthest = 0.25;

  /// Throws std::invalid_argument naming field, value and bound.
  void validate() const;
};

/// What a recorded marker that is not the model's turned out to be.
struct MarkerAttachment {
  enum class Fate {
    kAttached,
    kSeldom,     // measured in too few frames
    kStill,      // stays in the laboratory
    kLoose,      // keeps its distances to no body
    kFar,        // keeps them, but away from the body: something that is held or carried
    kAmbiguous,  // two bodies would do
  };

  std::string name;
  int recorded = -1;  // index into MarkerTrajectories::names
  Fate fate = Fate::kLoose;
  int body = -1;                                           // the best one
  Eigen::Vector3d p_BM = Eigen::Vector3d::Constant(kNaN);  // its mean place there [m]
  double spread = kNaN;                                    // RMS about it [m]
  int next_body = -1;         // the best of those that do not move alike …
  double next_spread = kNaN;  // … and the spread there [m]
  double confidence() const;  // 1 − spread/next_spread
};

/// Where bodies are, frame by frame: what track() found, and which of them the tracked markers
/// determine (their pose moves in no direction of the null space of the markers' JᵀJ).
struct BodyPoses {
  std::vector<std::vector<RigidTransform>> X_WB;  // frames × bodies
  std::vector<bool> determined;                   // bodies; ground is
};
BodyPoses body_poses(const MusculoskeletalModel& model, const KinematicTree& tree,
                     const TrackingProblem& tracking, const MarkerTrajectories& markers,
                     const TrackingResult& solved);

/// Holds each candidate, by its column, against each determined body and the ground: the spread is
/// the RMS distance of X_BW p_WM from its mean over the frames in which it is measured. Frames are
/// those of `poses`, which are the first of `markers`. O(candidates · bodies · frames).
std::vector<MarkerAttachment> find_attachments(const MusculoskeletalModel& model,
                                               const BodyPoses& poses,
                                               const MarkerTrajectories& markers,
                                               const std::vector<int>& candidates,
                                               const AttachmentOptions& options = {});

/// Mean place of a marker in a body over the frames in which it is measured [m], and the spread.
struct PlaceInBody {
  Eigen::Vector3d p_BM = Eigen::Vector3d::Constant(kNaN);
  double spread = kNaN;
  int frames = 0;
};
PlaceInBody place_in_body(const BodyPoses& poses, const MarkerTrajectories& markers, int marker,
                          int body);

/// From a point to the nearest joint, mass centre or marker of its body [m].
double distance_from_bone(const MusculoskeletalModel& model, int body, const Eigen::Vector3d& p_BM);

/// Evenly spread frames of a recording, `count` at most.
MarkerTrajectories some_frames(const MarkerTrajectories& markers, int first, int last, int count);

}  // namespace sinew
