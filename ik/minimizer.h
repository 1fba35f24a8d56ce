#pragma once

#include <Eigen/Core>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "ik/direction.h"
#include "ik/gauss_newton.h"
#include "ik/lbfgs.h"
#include "ik/residuals.h"

namespace sinew {

enum class Method { kLbfgs, kGaussNewton };
enum class GradientKind { kDecomposed, kJacobian };

/// `lbfgs`, `gauss-newton`; what the command line takes and reports print.
const char* to_string(Method method);
/// Throws std::invalid_argument, listing the names there are, for another name.
Method method_from_string(const std::string& name);

struct MinimizerOptions {
  Method method = Method::kGaussNewton;
  GradientKind gradient = GradientKind::kDecomposed;

  // Stop when max|g| < gradient_tolerance · max(1, Σ weights) (e3). The weakest determinate
  // direction of the gait models has curvature 1e-4, so an angle is then within 1e-5 rad.
  double gradient_tolerance = 1e-9;
  // Stop when |f_{k+1} − f_k| < cost_tolerance (e2). 0: off.
  double cost_tolerance = 0.0;
  int max_iterations = 2000;       // (e1)
  bool record_iterations = false;  // fill Summary::rows

  Lbfgs::Options lbfgs;
  GaussNewton::Options gauss_newton;

  /// Throws std::invalid_argument naming field, value and bound.
  void validate() const;
};

enum class Termination {
  kNone,
  kGradient,       // converged by e3
  kCostChange,     // converged by e2
  kStalled,        // no step lowers the cost further: at the limit of rounding
  kMaxIterations,  // e1
  kNotFinite,      // the cost or its gradient is not a number at the start
};

const char* to_string(Termination termination);

struct IterationRow {
  int iteration;
  double f, gradient_norm, step_length, step_norm;
};

struct Summary {
  Termination termination = Termination::kNone;
  int iterations = -1;
  int evaluations = -1;  // of the cost, with or without its gradient
  double initial_cost = kNaN, final_cost = kNaN;
  double gradient_norm = kNaN;  // max|g| over unknowns that no bound holds
  int held = -1;                // unknowns that end on a bound
  double seconds = kNaN;
  std::vector<IterationRow> rows;

  /// One sentence on how it ended.
  std::string message() const;
  bool converged() const {
    return termination == Termination::kGradient || termination == Termination::kCostChange ||
           termination == Termination::kStalled;
  }
};

/// Minimizes the cost of one frame after another. Bounds are kept by an active set: an unknown at
/// its bound whose gradient points outward is held, the others are free, and steps are clipped.
/// Owns its workspace; minimize() allocates nothing but the rows, if they are asked for.
class Minimizer {
 public:
  /// Keeps references to tree and problem. Throws std::invalid_argument for bad options.
  Minimizer(const KinematicTree& tree, const IkProblem& problem, const MinimizerOptions& options);

  /// From q (tree.q_count() values, e.g. the last frame's solution) to a minimum, written to q.
  /// Not converging is told by the Summary, which stays valid until the next call.
  const Summary& minimize(const IkTargets& targets, std::span<double> q);

  KinematicWorkspace& workspace() { return workspace_; }

 private:
  double evaluate(const IkTargets& targets, Eigen::VectorXd& g);
  double evaluate_at(const IkTargets& targets, double length, Eigen::VectorXd& g);
  void hold_bounds(Iterate& at) const;
  double length_to_largest_turn() const;
  bool search(Iterate& at);
  void accept(Iterate& at);
  bool finished(const Iterate& at);

  const KinematicTree& tree_;
  const IkProblem& problem_;
  MinimizerOptions options_;
  KinematicWorkspace workspace_;
  std::unique_ptr<Direction> direction_;
  Summary summary_;
  Eigen::VectorXd d_, step_, g_raw_, g_new_;
  Eigen::Matrix3Xd jacobian_;
  std::vector<double> q_, q_new_;
  std::unique_ptr<Iterate> iterate_;
  const IkTargets* targets_ = nullptr;
  double f_new_ = kNaN, length_ = 1.0, last_length_ = 1.0, tolerance_ = 0.0;
};

}  // namespace sinew
