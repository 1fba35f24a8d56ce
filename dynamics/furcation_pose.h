#pragma once

#include <span>
#include <vector>

#include "ik/minimizer.h"
#include "ik/wire_binding.h"
#include "model/kinematic_tree.h"
#include "model/musculoskeletal_model.h"

namespace sinew {

/// Where virtual links stand for a given pose of the bones: at the minimum of the wires' part of
/// eq. (38) and of what draws them to their places, as in inverse kinematics of a recording that
/// determines the bones.
class FurcationPose {
 public:
  explicit FurcationPose(const MusculoskeletalModel& model, const WireOptions& options = {});

  /// Overwrites the coordinates of virtual links in q (by coordinate of the model) and starts from
  /// them. Throws std::runtime_error if the minimum is not found.
  void solve(std::span<double> q);

  /// The wire that exceeds its natural length most in the last solution, relative to it.
  struct Strain {
    int path = -1;  // index into the model's paths; −1: all are slack
    double value = 0.0;
  };
  Strain largest_strain();

 private:
  KinematicTree tree_;  // every coordinate but those of virtual links is locked
  std::vector<TrackedWire> wires_;
  std::vector<int> free_;  // coordinates of virtual links
  IkProblem problem_;      // after the two above, which it fills
  IkTargets targets_;
  Minimizer minimizer_;
  std::vector<double> q_;
};

}  // namespace sinew
