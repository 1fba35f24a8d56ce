#include "ik/minimizer_options.h"

#include <fmt/format.h>

#include <stdexcept>

#include "ik/bfgs.h"
#include "ik/steepest_descent.h"

namespace sinew {
namespace {

struct MethodName {
  Method method;
  const char* name;
};
constexpr MethodName kMethods[] = {
    {Method::kSteepestDescent, "steepest-descent"},
    {Method::kConjugateGradient, "conjugate-gradient"},
    {Method::kBfgs, "bfgs"},
    {Method::kLbfgs, "lbfgs"},
    {Method::kLevenbergMarquardt, "levenberg-marquardt"},
    {Method::kGaussNewton, "gauss-newton"},
    {Method::kArticulatedGaussNewton, "articulated-gauss-newton"},
    {Method::kArticulatedNewton, "articulated-newton"},
    {Method::kArticulated, "articulated"},
};

std::unique_ptr<Direction> make_articulated(const KinematicTree& tree, const IkProblem& problem,
                                            NewtonModel model, const MinimizerOptions& options) {
  if (!articulated_sweep_fits(tree, problem)) {
    return std::make_unique<GaussNewton>(tree, problem, options.gauss_newton, model);
  }
  return std::make_unique<Articulated>(tree, problem, model, options.articulated);
}

}  // namespace

Method resolved_method(const KinematicTree& tree, const IkProblem& problem,
                       const MinimizerOptions& options) {
  const bool may_choose =
      options.method == Method::kGaussNewton && options.gradient == GradientKind::kDecomposed;
  return may_choose && articulated_sweep_is_faster(tree, problem) ? Method::kArticulated
                                                                  : options.method;
}

bool continues_gradient_sweep(Method method) {
  return method == Method::kArticulatedGaussNewton || method == Method::kArticulatedNewton ||
         method == Method::kArticulated;
}

const char* to_string(Method method) {
  for (const MethodName& m : kMethods) {
    if (m.method == method) return m.name;
  }
  return "unknown";
}

Method method_from_string(const std::string& name) {
  for (const MethodName& m : kMethods) {
    if (name == m.name) return m.method;
  }
  throw std::invalid_argument(
      fmt::format("there is no method '{}'; expected one of {}", name, method_names()));
}

std::vector<Method> all_methods() {
  std::vector<Method> methods;
  for (const MethodName& m : kMethods) methods.push_back(m.method);
  return methods;
}

std::string method_names() {
  std::string names;
  for (const MethodName& m : kMethods) names += std::string(names.empty() ? "" : ", ") + m.name;
  return names;
}

void MinimizerOptions::validate() const {
  const auto reject = [](const char* field, double value, const char* bound) {
    throw std::invalid_argument(
        fmt::format("MinimizerOptions.{} is {}; expected {}", field, value, bound));
  };
  if (!(gradient_tolerance >= 0.0)) reject("gradient_tolerance", gradient_tolerance, "0 or more");
  if (!(cost_tolerance >= 0.0)) reject("cost_tolerance", cost_tolerance, "0 or more");
  if (max_iterations < 1) reject("max_iterations", max_iterations, "1 or more");
  if (!(time_limit > 0.0)) reject("time_limit", time_limit, "more than 0");
  if (!(largest_turn > 0.0)) reject("largest_turn", largest_turn, "more than 0");
  if (!(conjugate_gradient.t >= 0.0)) {
    reject("conjugate_gradient.t", conjugate_gradient.t, "0 or more");
  }
  if (!(levenberg_marquardt.lambda > 0.0)) {
    reject("levenberg_marquardt.lambda", levenberg_marquardt.lambda, "more than 0");
  }
  if (lbfgs.memory < 1) reject("lbfgs.memory", lbfgs.memory, "1 or more");
  if (!(gauss_newton.damping > 0.0)) {
    reject("gauss_newton.damping", gauss_newton.damping, "more than 0");
  }
  if (!(articulated.damping > 0.0)) {
    reject("articulated.damping", articulated.damping, "more than 0");
  }
}

MinimizerOptions paper_options(Method method) {
  MinimizerOptions options;
  options.method = method;
  options.max_iterations = 100000;
  options.cost_tolerance = 1e-12;
  options.gradient_tolerance = 1e-12;
  options.test = GradientTest::kEuclidean;
  options.largest_turn = std::numeric_limits<double>::infinity();
  options.always_interpolate = method == Method::kBfgs;
  options.lbfgs.start = Lbfgs::Start::kScaledIdentity;
  return options;
}

std::unique_ptr<Direction> make_direction(const KinematicTree& tree, const IkProblem& problem,
                                          const MinimizerOptions& options) {
  switch (options.method) {
    case Method::kSteepestDescent:
      return std::make_unique<SteepestDescent>();
    case Method::kConjugateGradient:
      return std::make_unique<ConjugateGradient>(tree, options.conjugate_gradient);
    case Method::kBfgs:
      return std::make_unique<Bfgs>(tree);
    case Method::kLbfgs:
      return std::make_unique<Lbfgs>(tree, problem, options.lbfgs);
    case Method::kLevenbergMarquardt:
      return std::make_unique<LevenbergMarquardt>(tree, problem, options.levenberg_marquardt);
    case Method::kGaussNewton:
      // With wires second derivatives are seldom positive definite: on the whole body walking they
      // cost more than they save, and frames ended stalled.
      return std::make_unique<GaussNewton>(
          tree, problem, options.gauss_newton,
          problem.wires.empty() ? NewtonModel::kNearMinimum : NewtonModel::kGaussNewton);
    case Method::kArticulatedGaussNewton:
      return make_articulated(tree, problem, Articulated::Model::kGaussNewton, options);
    case Method::kArticulatedNewton:
      return make_articulated(tree, problem, Articulated::Model::kNewton, options);
    case Method::kArticulated:
      return make_articulated(tree, problem, Articulated::Model::kAutomatic, options);
  }
  throw std::invalid_argument("MinimizerOptions.method is no method");
}

}  // namespace sinew
