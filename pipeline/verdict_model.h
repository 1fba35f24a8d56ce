#pragma once

#include <string>
#include <vector>

#include "data/numbers.h"
#include "data/verdict_reason.h"

namespace sinew {

/// A segment of one side and its partner of the other [m].
struct SideLength {
  std::string body, partner;
  double length = 0.0, partner_length = 0.0;
};

/// What a model says of the person that it stands for.
struct ModelEvidence {
  double mass = kNaN;    // [kg]
  bool stands = false;   // it has two feet, so that height and mass can be judged together
  double height = kNaN;  // of whoever stands; else its extent [m]
  std::vector<SideLength> sides;

  bool operator==(const ModelEvidence&) const = default;
};

/// Mass, height, mass over squared height, left against right. Codes: `mass`, `height`,
/// `body-mass-index`, `side-size`.
std::vector<VerdictReason> judge_model(const ModelEvidence& model);

/// How a model was fitted.
struct ScaleEvidence {
  struct Factor {
    std::string body;
    double smallest = 1.0, largest = 1.0;  // over its axes
  };
  std::vector<Factor> factors;
  bool converged = true;
  // In the pose that was found, of the weighted markers, before markers were moved, or, where sizes
  // and places were fitted, after that [m]. NaN where no pose was found.
  double pose_rms = kNaN;
  struct MovedMarker {
    std::string name;
    double distance = 0.0;  // [m]
  };
  std::vector<MovedMarker> moved;
};

/// Codes: `unconverged`, `scale-factor`, `marker-rms`, `moved-marker`.
std::vector<VerdictReason> judge_scale(const ScaleEvidence& scale);

}  // namespace sinew
