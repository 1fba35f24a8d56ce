#pragma once

#include <span>
#include <utility>
#include <vector>

#include "ik/residuals.h"
#include "ik/tracking.h"
#include "model/simbody_model.h"

namespace sinew {

/// Coordinate targets and wires as a goal of Simbody's Assembler, beside its own goal for markers:
///
///     ( ½ Σ w (q^d − q)² + ½ Σ ρσ max{0, l − l^d}² ) / W
///
/// with W the sum of the weights of the markers measured in the frame, by which Simbody divides its
/// goal for markers. Lengths come from Simbody's own poses, the gradient from its own operator
/// multiplyBySystemJacobianTranspose.
class AssemblerGoal : public SimTK::AssemblyCondition {
 public:
  /// Keeps references to both.
  AssemblerGoal(const SimbodyModel& model, const TrackingProblem& tracking);

  /// Of the frame that is solved next.
  void set_targets(const IkTargets& targets);

  int calcGoal(const SimTK::State& state, SimTK::Real& goal) const override;
  int calcGoalGradient(const SimTK::State& state, SimTK::Vector& gradient) const override;

 private:
  struct Station {
    int body;
    SimTK::Vec3 p_BP;
  };

  void find_path(const SimTK::State& state, const WireResidual& wire) const;
  double path_length() const;

  const SimbodyModel& model_;
  const TrackingProblem& tracking_;
  std::vector<double> values_;   // of the coordinate targets; NaN: none
  std::vector<double> weights_;  // of the coordinate targets in this frame
  double scale_ = 1.0;           // 1/W
  // Scratch: the points of one wire that are on its path, and their places in the world.
  mutable std::vector<Station> path_;
  mutable std::vector<SimTK::Vec3> places_;
};

}  // namespace sinew
