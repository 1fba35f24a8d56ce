#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "data/marker_trajectories.h"
#include "ik/tracking.h"
#include "model/kinematic_tree.h"
#include "model/musculoskeletal_model.h"

namespace sinew {

/// A turn of a joint about an axis by θ = slope·q + intercept, whose coordinate does nothing else:
/// q ± 2π/slope is the same pose.
struct FreeTurn {
  int coordinate = -1;
  Eigen::Vector3d axis = Eigen::Vector3d::Zero();  // unit
  double slope = 1.0, intercept = 0.0;
  double lower = 0.0, upper = 0.0;  // bounds of θ [rad]; ±infinity where there are none
};

/// Three free turns of a joint in succession, R = R(a₁,θ₁) R(a₂,θ₂) R(a₃,θ₃). As a₁ᵀR a₃ depends on
/// θ₂ only,
///
///     a₁ᵀ R(a₂,θ₂) a₃ = C + A cos θ₂ + B sin θ₂,
///     C = (a₁ᵀa₂)(a₂ᵀa₃), A = a₁ᵀa₃ − C, B = a₁ᵀ(a₂ × a₃),                                     (1)
///
/// there is a second triple with θ₂' = 2φ − θ₂, φ = atan2(B, A). At θ₂ = φ or φ + π, the poles,
/// both meet; if a₂ is normal to a₁ and a₃ then R(a₂,θ₂) a₃ = σa₁ there with σ = ±1, and R depends
/// on θ₁ + σθ₃ only.
struct TurnTriple {
  std::array<int, 3> turns{};  // indices into TurnChoices::turns
  double phi = 0.0;            // φ
  bool has_line = false;       // a₂ is normal to a₁ and a₃
};

/// What of a model's angles the pose leaves to choose.
struct TurnChoices {
  std::vector<FreeTurn> turns;
  std::vector<int> single;  // turns of no triple
  std::vector<TurnTriple> triples;
};

/// Finds them. Left out are coordinates that are no unknowns, that also shift, drive a coupler or
/// decide whether a point is on a wire, and functions that are not linear.
TurnChoices find_turn_choices(const MusculoskeletalModel& model, const KinematicTree& tree,
                              const IkProblem& problem);

/// The second triple of the same orientation, to a whole turn of each angle. Rounding at the poles.
Eigen::Vector3d other_triple(const TurnChoices& choices, const TurnTriple& triple,
                             const Eigen::Vector3d& theta);

/// Makes the angles of solved frames follow each other: in every frame, among the coordinates of
/// equal pose and cost, those nearest to the frame before (to the default pose in the first one):
/// whole turns of one coordinate, the other triple of three successive turns, and at a pole the
/// nearest point of the line θ₁ + σθ₃ = const. Bounds hold. Costs are equal if they differ by less
/// than 1e-7 of them or of what 1e-5 mm on every marker makes; that counts for lines and where a
/// task pulls at a coordinate. Changes `result.coordinates`, and of frames moved along a line cost
/// and errors. first_frame: of the recording, where the result begins.
///
/// A few comparisons a frame; where a step is large, sines and cosines; at a pole, a cost.
void make_continuous(const MusculoskeletalModel& model, const KinematicTree& tree,
                     const TrackingProblem& tracking, const MarkerTrajectories& markers,
                     int first_frame, TrackingResult& result);

}  // namespace sinew
