#pragma once

#include <optional>
#include <string>
#include <vector>

#include "data/verdict_reason.h"
#include "pipeline/verdict_dynamics.h"
#include "pipeline/verdict_kinematics.h"
#include "pipeline/verdict_model.h"

namespace sinew {

struct JointEvidence {
  std::string name;
  std::vector<std::string> coordinates;
};

/// All that a verdict rests on; a command leaves out what it did not do.
struct VerdictEvidence {
  std::vector<JointEvidence> joints;     // that move and are no virtual links'
  bool angles = false, torques = false;  // whether the command gives them
  ModelEvidence model;
  std::optional<ScaleEvidence> scale;
  std::optional<KinematicsEvidence> kinematics;
  std::optional<DynamicsEvidence> dynamics;
  // What others found. They know their matter better: a code that is here is not judged again.
  std::vector<VerdictReason> found;
};

struct JointVerdict {
  enum class Use {
    kNone,  // not computed
    kUsable,
    kPartly,  // in the frames only in which all loads are known
    kUnusable,
  };
  std::string joint;
  Use angles = Use::kNone, torques = Use::kNone;

  bool operator==(const JointVerdict&) const = default;
};

struct Verdict {
  enum class Level { kGood, kRemarks, kUnusable };
  Level level = Level::kGood;
  std::vector<VerdictReason> reasons;  // the weightiest first
  std::vector<JointVerdict> joints;
};

/// Judges the evidence: unusable if one reason is, with remarks if there is any. A joint's angles
/// (torques) cannot be used if a reason names one of its coordinates. Reasons of one code and text
/// stand once. O(reasons · coordinates).
Verdict judge(const VerdictEvidence& evidence);

}  // namespace sinew
