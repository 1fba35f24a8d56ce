#pragma once

#include <string>
#include <vector>

#include "data/numbers.h"
#include "data/verdict_reason.h"

namespace sinew {

/// In how many frames all that the ground does to a foot is known.
struct FootEvidence {
  std::string name;
  int complete = 0;                  // frames
  std::string times;                 // for people
  std::vector<std::string> torques;  // coordinates of its leg and of the root
};

/// What is left at the root, where no actuator acts: RMS and largest length of the vector over
/// frames. Moments about the root's own axes are taken for the components of one vector.
struct RootResidual {
  double force_rms = kNaN;  // [N]
  double force_max = kNaN;
  double moment_rms = kNaN;  // [N m]
  double moment_max = kNaN;
};

/// Along one horizontal axis of ground: a load against what the movement needs of it, which is that
/// load and what is left at the root. Over the known frames.
struct PushEvidence {
  std::string body;        // that it acts on; empty: the sum of all loads
  std::string times;       // of one contact, for people; empty: all of them
  std::string axis;        // "x" …
  double load_rms = kNaN;  // [N]
  double need_rms = kNaN;  // [N]
  double cosine = kNaN;    // between both, over the frames
  double acts_rms = kNaN;  // of the load, along all axes [N]
};

/// Along both horizontal axes of ground: by how much less is left at the root if a load is turned
/// by a right angle or its axes are exchanged, which is what exchanged channels and rotated
/// platforms do. Over the known frames.
struct TurnEvidence {
  std::string body, times;  // as PushEvidence's
  std::string axes;         // "x is z, z is -x" of what fits best
  double load_rms = kNaN;   // [N]
  double left = kNaN;       // RMS of the horizontal force left then, over that which is left now
};

/// Mean of a body's load, upwards.
struct PullEvidence {
  std::string body;
  double mean = kNaN;  // [N]
};

struct DynamicsEvidence {
  bool floating = false;  // nothing but loads holds the model
  bool loads_given = false;
  bool by_platforms = false;  // whether each frame's loads are complete was told by platforms
  double weight = kNaN;       // of the model [N]
  double height = kNaN;       // [m]
  int frames = 0;
  int known = 0;  // frames in which all loads are known; without platforms: in which less than half
                  // of the weight hangs on the root
  double peak_load = kNaN;  // largest length of all loads' sum [N]
  // Of all loads' sum, over the frames [N]. NaN where not all are given in ground's axes.
  double mean_vertical_load = kNaN;
  double vertical_load_rms = kNaN;
  double horizontal_load_rms = kNaN;
  // Mass that the loads carry [kg]: by platforms over strides or in the static trial, else over the
  // known frames.
  double carried_mass = kNaN;
  bool mass_of_some_frames = true;
  std::vector<PushEvidence> pushes;
  std::vector<TurnEvidence> turns;
  std::vector<PullEvidence> pulls;
  RootResidual root;                     // over the known frames, or over all if there are none
  std::vector<FootEvidence> feet;        // by the platforms
  std::vector<std::string> supporting;   // coordinates between what carries the body and the root
  std::vector<std::string> not_given;    // coordinates that the motion lacks
  std::vector<std::string> coordinates;  // all
};

/// Codes: `no-loads`, `loads-missing`, `loads-pull-down`, `loads-sideways`, `loads-turned`,
/// `loads-no-push`, `mass-carried`, `residual-force`, `residual-moment`, `not-in-motion`. A model
/// that the ground holds has no residuals: what acts at its root is a torque like any other. O(feet
/// + coordinates).
std::vector<VerdictReason> judge_dynamics(const DynamicsEvidence& dynamics);

/// Coordinates whose torques can be used in some of the frames only.
std::vector<std::string> partly_known_torques(const DynamicsEvidence& dynamics);

}  // namespace sinew
