#pragma once

#include <memory>
#include <span>

#include "ik/residuals.h"
#include "ik/summary.h"

namespace sinew {

/// Newton-Raphson on the equations e(q) = [Δp; Δγ; Δl] = 0, eqs. (7)-(10), by KINSOL (SUNDIALS 6):
/// what inverse kinematics by least squares replaces, and the yardstick for it. Converges
/// quadratically where J = ∂e/∂q has full rank at the solution; ends as singular or diverges where
/// it has not, as at an outstretched limb.
///
/// KINSOL wants as many equations as unknowns, so the shorter of the two is padded with zeros, and
/// its linear solver is replaced by one that gives the step of least norm J δ = −e where there are
/// fewer equations, the only step where they are equal, and the least-squares step where there are
/// more. All three by a complete orthogonal decomposition, J's rank being what is left above
/// rounding; less than full rank ends the solve. Weights are folded into the equations: they change
/// only least-squares steps. Slack wires are no equations. Bounds are not kept.
///
/// Ends as kSolved, kSingular, kDiverged, kMaxIterations or kNotFinite; Summary::detail has
/// KINSOL's own word. O(equations · unknowns · min of both) an iteration.
class NewtonRaphson {
 public:
  struct Options {
    bool line_search = false;  // KIN_LINESEARCH instead of full steps
    // Solved when max|Σ^½ e| < tolerance [m or rad].
    double tolerance = 1e-12;
    int max_iterations = 200;  // KINSOL's default
    // Longer steps are shortened [rad and m]; five in a row end the solve as diverged. Far beyond
    // any sensible step: Newton-Raphson is shown as it is.
    double largest_step = 1e3;
    bool record_iterations = false;  // fill Summary::rows

    /// Throws std::invalid_argument naming field, value and bound.
    void validate() const;
  };

  /// Copies the tree, keeps a reference to the problem. Throws std::invalid_argument for bad
  /// options.
  NewtonRaphson(const KinematicTree& tree, const IkProblem& problem, const Options& options);
  ~NewtonRaphson();
  NewtonRaphson(const NewtonRaphson&) = delete;
  NewtonRaphson& operator=(const NewtonRaphson&) = delete;

  /// From q (tree.q_count() values) to where the equations hold, or to where it gave up, written to
  /// q. Summary's cost and gradient are those of the least-squares problem.
  const Summary& solve(const IkTargets& targets, std::span<double> q);

 private:
  class Kinsol;
  std::unique_ptr<Kinsol> kinsol_;
};

}  // namespace sinew
