#pragma once

#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "ik/articulated.h"
#include "ik/conjugate_gradient.h"
#include "ik/direction.h"
#include "ik/gauss_newton.h"
#include "ik/lbfgs.h"
#include "ik/levenberg_marquardt.h"

namespace sinew {

enum class Method {
  kSteepestDescent,
  kConjugateGradient,
  kBfgs,
  kLbfgs,
  kLevenbergMarquardt,
  // With all second derivatives near the minimum. Where the articulated sweep costs less than the
  // factorization, articulated_sweep_is_faster(), and gradients are decomposed, it is kArticulated.
  kGaussNewton,
  // O(links), continuing the sweep of the decomposed gradient, which they always take. Couplings
  // and residuals that join two links do not fit their sweep: on such problems GaussNewton's sparse
  // factorization stands in for it, with the same second derivatives but those of wires.
  kArticulatedGaussNewton,
  kArticulatedNewton,
  kArticulated,  // turns from one to the other by itself
};
struct MinimizerOptions;
/// The method that a minimization really takes, see kGaussNewton.
Method resolved_method(const KinematicTree& tree, const IkProblem& problem,
                       const MinimizerOptions& options);
/// True for the articulated methods.
bool continues_gradient_sweep(Method method);

enum class GradientKind { kDecomposed, kJacobian };

/// What (e3) measures, over the unknowns that no bound holds.
enum class GradientTest {
  kLargestEntry,  // max|g| < tolerance · max(1, Σ weights)
  kEuclidean,     // ‖g‖₂ < tolerance, as in the paper
};

/// `steepest-descent`, `lbfgs`, …; what the command line takes and reports print.
const char* to_string(Method method);
/// Throws std::invalid_argument, listing the names there are, for another name.
Method method_from_string(const std::string& name);
/// In the order of Method.
std::vector<Method> all_methods();
/// Their names, separated by commas.
std::string method_names();

struct MinimizerOptions {
  Method method = Method::kGaussNewton;
  GradientKind gradient = GradientKind::kDecomposed;

  // (e3), see GradientTest. The weakest determinate direction of the gait models has curvature
  // 1e-4, so with max|g| an angle is then within 1e-5 rad.
  double gradient_tolerance = 1e-9;
  GradientTest test = GradientTest::kLargestEntry;
  // Stop when |f_{k+1} − f_k| < cost_tolerance (e2). 0: off.
  double cost_tolerance = 0.0;
  int max_iterations = 2000;                                    // (e1)
  double time_limit = std::numeric_limits<double>::infinity();  // of one frame [s]
  // Asked after every iteration; true ends the frame as out of time.
  std::function<bool()> stop;

  // No step turns a joint further than this [rad]. Far from the data the quadratic model promises
  // turns of many radians, which end in other minima. Measured on 1000 frames of the five published
  // trials, half from the default pose, half from random ones: Gauss-Newton reaches the best
  // minimum from 92 % of them without a bound, L-BFGS from 53 %; bounded by 1.0 from 99 and 80 %,
  // by 0.7 from 99 and 89 %, by 0.5 from 99 and 84 %. Solving from the frame before is never
  // bounded.
  double largest_turn = 0.7;

  // Let methods that scale their step start from the interpolated length too, as the paper does,
  // rather than from 1. Costs them an evaluation an iteration and robs them of the exact step.
  bool always_interpolate = false;

  bool record_iterations = false;  // fill Summary::rows

  ConjugateGradient::Options conjugate_gradient;
  Lbfgs::Options lbfgs;
  LevenbergMarquardt::Options levenberg_marquardt;
  GaussNewton::Options gauss_newton;
  Articulated::Options articulated;

  /// Throws std::invalid_argument naming field, value and bound.
  void validate() const;
};

/// The method as Ayusawa & Nakamura 2012 ran it: k_max = 100000, ε₂ = ε₃ = 1e-12 with ‖g‖₂, no
/// bound on turns, the line search interpolated in BFGS as well, L-BFGS (not in the paper) from γE.
MinimizerOptions paper_options(Method method);

/// The direction that the options name.
std::unique_ptr<Direction> make_direction(const KinematicTree& tree, const IkProblem& problem,
                                          const MinimizerOptions& options);

}  // namespace sinew
