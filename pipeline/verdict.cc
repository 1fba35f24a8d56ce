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
  std::vector<JointVerdict> joints;
  for (const JointEvidence& joint : evidence.joints) {
    JointVerdict verdict{joint.name, Use::kNone, Use::kNone};
    if (evidence.angles) {
      verdict.angles = names_one_of(angles, joint) ? Use::kUnusable : Use::kUsable;
    }
    if (evidence.torques) {
      verdict.torques = names_one_of(torques, joint)  ? Use::kUnusable
                        : names_one_of(partly, joint) ? Use::kPartly
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
