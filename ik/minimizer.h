#pragma once

#include <Eigen/Core>
#include <chrono>
#include <memory>
#include <span>

#include "ik/direction.h"
#include "ik/minimizer_options.h"
#include "ik/residuals.h"
#include "ik/summary.h"

namespace sinew {

/// Minimizes the cost of one frame after another by q ← q ⊞ α d, eq. (17). Bounds are kept by an
/// active set: an unknown at its bound whose gradient points outward is held, the others are free,
/// and steps are clipped. Owns its workspaces; minimize() allocates nothing but the rows, if they
/// are asked for.
///
/// The line search accepts the first length α that satisfies Armijo's condition. Methods that scale
/// their step try 1 first, then their correction of it if they have one and fell short of what they
/// expected, then other directions if they want to; they go to the minimum of the parabola through
/// f(q), f(q + d) and the slope if all that fails. The others go to the minimum of the parabola
/// through f(q), f(q + α_{k−1} d) and the slope, as in the paper. Then both bisect. If nothing on
/// the way is accepted, −g has a last try before the frame ends as stalled.
class Minimizer {
 public:
  /// Keeps references to tree and problem. Throws std::invalid_argument for bad options.
  Minimizer(const KinematicTree& tree, const IkProblem& problem, const MinimizerOptions& options);

  /// From q (tree.q_count() values, e.g. the last frame's solution) to a minimum, written to q.
  /// Not converging is told by the Summary, which stays valid until the next call.
  const Summary& minimize(const IkTargets& targets, std::span<double> q);

  /// Kinematics of the solution.
  KinematicWorkspace& workspace() { return workspace_; }

 private:
  // A point on the way from the iterate.
  struct Trial {
    explicit Trial(const KinematicTree& tree)
        : workspace(tree), g(tree.unknown_count()), step(tree.unknown_count()) {}
    KinematicWorkspace workspace;
    Eigen::VectorXd g, step;        // raw gradient; the step really taken, clipped
    double f = kNaN, slope = kNaN;  // slope: the iterate's g · step
    double length = 1.0;            // along the direction
  };

  double gradient(const IkTargets& targets, KinematicWorkspace& workspace, Eigen::VectorXd& g);
  void start_at(const IkTargets& targets, std::span<const double> q);
  void hold_bounds(Iterate& at) const;
  double length_to_largest_turn() const;
  void evaluate_trial(const Iterate& at, const Eigen::VectorXd& d, double length,
                      bool with_gradient);
  bool try_length(const Iterate& at, const Eigen::VectorXd& d, double length, bool with_gradient);
  bool try_full_length(const Iterate& at);
  double interpolated_length(const Iterate& at);
  bool backtrack(const Iterate& at);
  bool step_by_direction(Iterate& at);
  bool step_by_gradient(Iterate& at);
  void accept(Iterate& at);
  double gradient_norm(const Iterate& at) const;
  bool finished(const Iterate& at);

  const KinematicTree& tree_;
  const IkProblem& problem_;
  MinimizerOptions options_;
  KinematicWorkspace workspace_;  // of the iterate
  Trial trial_, other_;           // the point that is tried, and one to compare it with
  std::unique_ptr<Direction> direction_;
  Summary summary_;
  Eigen::VectorXd d_, corrected_d_, g_raw_;
  Eigen::Matrix3Xd jacobian_;
  Iterate iterate_;
  double last_length_ = 1.0, tolerance_ = 0.0;
  std::chrono::steady_clock::time_point start_;
};

}  // namespace sinew
