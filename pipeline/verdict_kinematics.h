#pragma once

#include <string>
#include <vector>

#include "data/numbers.h"
#include "data/verdict_reason.h"

namespace sinew {

/// One tracked marker over the frames.
struct MarkerEvidence {
  std::string name;
  int measured = 0;                 // frames
  double rms = kNaN;                // [m]
  double max = kNaN;                // [m]
  int side = 0;                     // −1 left, 1 right, 0 neither
  std::vector<std::string> angles;  // coordinates of the joint that carries its body
};

/// One coordinate that can move, over the frames.
struct CoordinateEvidence {
  std::string name;
  std::string partner;  // of the other side; empty: none, or named with that one
  bool rotational = true;
  double range = 0.0;         // largest − smallest [rad or m]
  double on_bound = 0.0;      // share of the frames in which it is held by its range's end
  bool undetermined = false;  // by the markers, as others found: not judged by its value
};

struct KinematicsEvidence {
  int frames = 0, unconverged = 0, unmeasured = 0;
  double marker_rms = kNaN;  // of all [m]
  double static_rms = kNaN;  // of the trial scaled by [m]
  double filled = 0.0;       // share of the tracked samples that were filled in
  double fallen = 0.0;  // share of the frames in which a person's feet are not below the pelvis
  std::vector<MarkerEvidence> markers;
  std::vector<CoordinateEvidence> coordinates;
};

/// Codes: `unconverged`, `marker-rms`, `marker-max`, `lost-marker`, `unmeasured-frames`,
/// `on-bound`, `static-rms`, `side-rms`, `side-range`, `filled-share`, `not-upright`. What
/// holds for all coordinates names all that `kinematics` has. O(markers + coordinates).
std::vector<VerdictReason> judge_kinematics(const KinematicsEvidence& kinematics);

}  // namespace sinew
