#pragma once

#include <Eigen/Core>
#include <vector>

#include "ik/residuals.h"
#include "model/kinematic_tree.h"

namespace sinew {

/// Where a minimization stands; what directions are made from. Vectors have an entry for every
/// unknown. Entries held by a bound are zero in g, s and y.
struct Iterate {
  const KinematicTree& tree;
  const IkProblem& problem;
  const IkTargets* targets;       // of this frame
  KinematicWorkspace& workspace;  // kinematics of this iterate, with the wrenches of its gradient
  int iteration = 0;
  double f = 0.0;
  Eigen::VectorXd g;           // gradient
  Eigen::VectorXd s, y;        // last step and the gradient's change over it; iteration > 0
  Eigen::VectorXd previous_d;  // last direction; iteration > 0
  std::vector<char> held;      // 1: at a bound that g pushes against
  double tolerance = 0.0;      // of the gradient, below which the frame ends
};

/// Which second derivatives of the cost the methods of second order take.
enum class NewtonModel {
  kGaussNewton,  // JᵀΣJ
  kNewton,       // all
  kAutomatic,    // what serves better, as each method has it
  kNearMinimum,  // JᵀΣJ, and all where steps have become small (GaussNewton only)
};

/// A step that changes no unknown by more than this [rad or m] starts near a minimum: Newton's and
/// Gauss-Newton's models lead to the same one. From the default pose steps are ten times as long;
/// the start of a frame of the published walks and runs is off by 0.07 at most.
constexpr double kSmallStep = 0.1;

/// The one choice that tells methods apart: where to go from an iterate, eq. (17)'s d_k.
class Direction {
 public:
  virtual ~Direction() = default;

  /// Forgets everything; called before the first iterate of a frame.
  virtual void start() = 0;

  /// Writes d for the iterate; entries that are held must come out zero. Returns false if the
  /// method has nothing better than −g to offer here.
  virtual bool compute(const Iterate& at, Eigen::Ref<Eigen::VectorXd> d) = 0;

  /// The length to try first along d: 1 for methods that scale their step themselves; the
  /// others continue from the last accepted length.
  virtual bool scales_its_step() const = 0;

  /// The cost's decrease that the method's own model expects of the whole step d; NaN without one.
  virtual double expected_decrease() const { return kNaN; }

  /// Tells how the last direction fared: the accepted length and the decrease there, or 0 and what
  /// the first length gave (negative; −infinity if it was not a number) where none was accepted.
  virtual void learn(double /*accepted_length*/, double /*actual_decrease*/) {}

  /// True for methods that would rather be asked for another direction, after learn(0, …), than be
  /// followed less far. compute() then comes again with the same iterate.
  virtual bool wants_retry() const { return false; }

  /// Writes to d another direction for the same iterate, once the first one, tried at full length,
  /// has led to the poses of `trial`: one that knows how residuals have bent away from their first
  /// order on the way (a second-order correction; Nocedal & Wright 2006, sec. 15.6). Returns false
  /// if the method has none. What expected_decrease() says stays.
  virtual bool correct(const Iterate& /*at*/, const KinematicWorkspace& /*trial*/,
                       Eigen::Ref<Eigen::VectorXd> /*d*/) {
    return false;
  }
};

}  // namespace sinew
