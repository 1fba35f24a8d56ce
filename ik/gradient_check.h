#pragma once

#include <Eigen/Core>
#include <span>

#include "ik/residuals.h"
#include "model/kinematic_tree.h"

namespace sinew {

/// How the decomposed gradient compares with differences of the cost. Vectors have an entry for
/// every unknown, in [1/rad] or [1/m].
struct GradientCheck {
  Eigen::VectorXd gradient;     // decomposed_gradient()
  Eigen::VectorXd quotient;     // central differences of cost()
  Eigen::VectorXd uncertainty;  // of the quotient, as its extrapolation estimates it
  Eigen::VectorXd difference;   // gradient − quotient
  int worst = -1;               // unknown with the largest |difference|; −1 without unknowns
  double scale = 0.0;           // largest |entry| of gradient and quotient

  /// Largest |difference| as a part of `scale`; about 1e-9 where both are right. At a minimum both
  /// are zero and this says nothing: check somewhere else.
  double worst_relative() const;
};

/// Checks the gradient of a problem at q (tree.q_count() values; dependent ones are set by their
/// couplers): every unknown is stepped by advance(), so quaternions turn on their manifold, to both
/// sides, through its bounds if need be. Steps need no choosing: they shrink from 0.01 to 3e-7 rad
/// or m, the quotients are extrapolated to step zero, and the one that is surest of itself counts
/// (after Ridders 1982, Advances in Engineering Software 4(2), 75-76).
/// For your own models and problems, and after any change to a joint, a coupler or a residual.
/// Costs that have a kink at q (a coincidence of both ends of a distance, a corner of a piecewise
/// linear function, an orientation half a turn off) have no gradient there: expect a difference.
/// Throws as validate(tree, problem, targets). O(unknowns · (links + residuals)).
GradientCheck check_gradient(const KinematicTree& tree, const IkProblem& problem,
                             const IkTargets& targets, std::span<const double> q);

}  // namespace sinew
