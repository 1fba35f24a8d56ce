#include "pipeline/verdict.h"

#include <algorithm>
#include <set>

namespace sinew {
namespace {

using Use = JointVerdict::Use;
using Weight = VerdictReason::Weight;

class Gathering {
 public:
  explicit Gathering(const std::vector<VerdictReason>& found) {
    for (const VerdictReason& r : found) {
      codes_.insert(r.code);
      const bool known = std::any_of(reasons_.begin(), reasons_.end(), [&](const VerdictReason& a) {
        return a.code == r.code && a.text == r.text;
      });
      if (!known) reasons_.push_back(r);
    }
  }

  void add(std::vector<VerdictReason> more) {
    for (VerdictReason& r : more) {
      if (!codes_.contains(r.code)) reasons_.push_back(std::move(r));
    }
  }

  std::vector<VerdictReason> take() {
    std::stable_partition(reasons_.begin(), reasons_.end(),
                          [](const VerdictReason& r) { return r.weight == Weight::kUnusable; });
    return std::move(reasons_);
  }

 private:
  std::set<std::string> codes_;
  std::vector<VerdictReason> reasons_;
};

bool names_one_of(const std::set<std::string>& names, const JointEvidence& joint) {
  return std::any_of(joint.coordinates.begin(), joint.coordinates.end(),
                     [&](const std::string& c) { return names.contains(c); });
}

// A reason that spoils the whole result names no coordinates; a wrong mass spoils no angle.
bool spoils_torques(const VerdictReason& r) {
  return r.weight == Weight::kUnusable && r.angles.empty() && r.torques.empty();
}

bool spoils_angles(const VerdictReason& r) {
  return spoils_torques(r) && r.code != "mass" && r.code != "mass-unit" &&
         r.code != "body-mass-index";
}

std::vector<JointVerdict> judge_joints(const VerdictEvidence& evidence,
                                       const std::vector<VerdictReason>& reasons) {
  std::set<std::string> angles, torques, partly;
  for (const VerdictReason& r : reasons) {
    angles.insert(r.angles.begin(), r.angles.end());
    torques.insert(r.torques.begin(), r.torques.end());
  }
  if (evidence.dynamics) {
    const std::vector<std::string> names = partly_known_torques(*evidence.dynamics);
    partly.insert(names.begin(), names.end());
  }
  const bool no_angles = std::any_of(reasons.begin(), reasons.end(), spoils_angles);
  const bool no_torques = std::any_of(reasons.begin(), reasons.end(), spoils_torques);
  std::vector<JointVerdict> joints;
  for (const JointEvidence& joint : evidence.joints) {
    JointVerdict verdict{joint.name, Use::kNone, Use::kNone};
    if (evidence.angles) {
      verdict.angles = no_angles || names_one_of(angles, joint) ? Use::kUnusable : Use::kUsable;
    }
    if (evidence.torques) {
      verdict.torques = no_torques || names_one_of(torques, joint) ? Use::kUnusable
                        : names_one_of(partly, joint)              ? Use::kPartly
                                                                   : Use::kUsable;
    }
    joints.push_back(verdict);
  }
  return joints;
}

}  // namespace

Verdict judge(const VerdictEvidence& evidence) {
  Gathering gathering(evidence.found);
  gathering.add(judge_model(evidence.model));
  if (evidence.scale) gathering.add(judge_scale(*evidence.scale));
  if (evidence.kinematics) gathering.add(judge_kinematics(*evidence.kinematics));
  if (evidence.dynamics) gathering.add(judge_dynamics(*evidence.dynamics));
  Verdict verdict;
  verdict.reasons = gathering.take();
  if (!verdict.reasons.empty()) {
    verdict.level = verdict.reasons.front().weight == Weight::kUnusable ? Verdict::Level::kUnusable
                                                                        : Verdict::Level::kRemarks;
  }
  verdict.joints = judge_joints(evidence, verdict.reasons);
  return verdict;
}

}  // namespace sinew
