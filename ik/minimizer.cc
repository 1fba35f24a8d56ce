#include "ik/minimizer.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <stdexcept>

namespace sinew {
namespace {

// Armijo's constant: Nocedal & Wright's choice for methods that scale their step.
constexpr double kArmijo = 1e-4;

// Two costs closer than this fraction are equal to rounding: the sums run over about a hundred
// squares.
constexpr double kCostRounding = 1e-14;

// No step turns a joint further than this [rad]. Far from the data the quadratic model promises
// turns of many radians, which end in other minima. Measured on 1000 frames of the five published
// trials, half from the default pose, half from random ones: Gauss-Newton reaches the best minimum
// from 92 % of them without a bound, L-BFGS from 53 %; bounded by 1.0 from 99 and 80 %, by 0.7 from
// 99 and 89 %, by 0.5 from 99 and 84 %. Solving from the frame before is never bounded.
constexpr double kLargestTurn = 0.7;

// Halving 60 times passes the spacing of doubles.
constexpr int kMaxTrials = 60;

std::unique_ptr<Direction> make_direction(const KinematicTree& tree,
                                          const MinimizerOptions& options) {
  switch (options.method) {
    case Method::kLbfgs:
      return std::make_unique<Lbfgs>(tree, options.lbfgs);
    case Method::kGaussNewton:
      return std::make_unique<GaussNewton>(tree, options.gauss_newton);
  }
  throw std::invalid_argument("MinimizerOptions.method is no method");
}

// Weights set the scale of the gradient, so the tolerance follows their sum.
double weight_scale(const IkProblem& problem) {
  double sum = 0.0;
  for (const PositionResidual& r : problem.positions) sum += r.weight.trace() / 3.0;
  for (const OrientationResidual& r : problem.orientations) sum += r.weight.trace() / 3.0;
  for (const DistanceResidual& r : problem.distances) sum += r.weight;
  for (const CoordinateResidual& r : problem.coordinates) sum += r.weight;
  for (const CoincidenceResidual& r : problem.coincidences) sum += r.weight;
  for (const AlignmentResidual& r : problem.alignments) sum += r.weight;
  return std::max(1.0, sum);
}

struct MethodName {
  Method method;
  const char* name;
};
constexpr MethodName kMethods[] = {{Method::kLbfgs, "lbfgs"},
                                   {Method::kGaussNewton, "gauss-newton"}};

}  // namespace

const char* to_string(Method method) {
  for (const MethodName& m : kMethods) {
    if (m.method == method) return m.name;
  }
  return "unknown";
}

Method method_from_string(const std::string& name) {
  std::string names;
  for (const MethodName& m : kMethods) {
    if (name == m.name) return m.method;
    names += std::string(names.empty() ? "" : ", ") + m.name;
  }
  throw std::invalid_argument(
      fmt::format("there is no method '{}'; expected one of {}", name, names));
}

const char* to_string(Termination termination) {
  switch (termination) {
    case Termination::kNone:
      return "none";
    case Termination::kGradient:
      return "gradient";
    case Termination::kCostChange:
      return "cost-change";
    case Termination::kStalled:
      return "stalled";
    case Termination::kMaxIterations:
      return "max-iterations";
    case Termination::kNotFinite:
      return "not-finite";
  }
  return "unknown";
}

std::string Summary::message() const {
  switch (termination) {
    case Termination::kGradient:
      return fmt::format("converged: the gradient's largest entry is {:.3g}", gradient_norm);
    case Termination::kCostChange:
      return fmt::format("converged: the cost no longer changes at {:.6g}", final_cost);
    case Termination::kStalled:
      return fmt::format(
          "no step lowers the cost {:.6g} further; the gradient's largest entry is "
          "{:.3g}",
          final_cost, gradient_norm);
    case Termination::kMaxIterations:
      return fmt::format(
          "not converged after {} iterations; the gradient's largest entry is {:.3g}", iterations,
          gradient_norm);
    case Termination::kNotFinite:
      return "the cost or its gradient is not a number at the start";
    case Termination::kNone:
      break;
  }
  return "not started";
}

void MinimizerOptions::validate() const {
  const auto reject = [](const char* field, double value, const char* bound) {
    throw std::invalid_argument(
        fmt::format("MinimizerOptions.{} is {}; expected {}", field, value, bound));
  };
  if (!(gradient_tolerance >= 0.0)) reject("gradient_tolerance", gradient_tolerance, "0 or more");
  if (!(cost_tolerance >= 0.0)) reject("cost_tolerance", cost_tolerance, "0 or more");
  if (max_iterations < 1) reject("max_iterations", max_iterations, "1 or more");
  if (lbfgs.memory < 1) reject("lbfgs.memory", lbfgs.memory, "1 or more");
  if (!(gauss_newton.damping > 0.0)) {
    reject("gauss_newton.damping", gauss_newton.damping, "more than 0");
  }
}

Minimizer::Minimizer(const KinematicTree& tree, const IkProblem& problem,
                     const MinimizerOptions& options)
    : tree_(tree),
      problem_(problem),
      options_(options),
      workspace_(tree),
      d_(tree.unknown_count()),
      step_(tree.unknown_count()),
      g_raw_(tree.unknown_count()),
      g_new_(tree.unknown_count()),
      jacobian_(3, tree.unknown_count()),
      q_(tree.default_q),
      q_new_(tree.default_q),
      tolerance_(options.gradient_tolerance * weight_scale(problem)) {
  options_.validate();
  direction_ = make_direction(tree, options_);
  const int n = tree.unknown_count();
  iterate_ = std::make_unique<Iterate>(Iterate{
      tree_, problem_, nullptr, workspace_, 0, kNaN, Eigen::VectorXd(n), Eigen::VectorXd(n),
      Eigen::VectorXd(n), Eigen::VectorXd(n), std::vector<char>(static_cast<std::size_t>(n), 0)});
}

double Minimizer::evaluate(const IkTargets& targets, Eigen::VectorXd& g) {
  ++summary_.evaluations;
  update_kinematics(tree_, workspace_);
  return options_.gradient == GradientKind::kDecomposed
             ? decomposed_gradient(tree_, problem_, targets, workspace_, g)
             : jacobian_gradient(tree_, problem_, targets, workspace_, jacobian_, g);
}

double Minimizer::evaluate_at(const IkTargets& targets, double length, Eigen::VectorXd& g) {
  step_ = length * d_;
  advance(tree_, q_, {step_.data(), static_cast<std::size_t>(step_.size())}, q_new_);
  std::copy(q_new_.begin(), q_new_.end(), workspace_.q.begin());
  return evaluate(targets, g);
}

void Minimizer::hold_bounds(Iterate& at) const {
  for (Eigen::Index x = 0; x < at.g.size(); ++x) {
    const auto i = static_cast<std::size_t>(x);
    const int q = tree_.q_of_v[static_cast<std::size_t>(tree_.unknown_v[i])];
    at.g[x] = g_raw_[x];
    at.held[i] = 0;
    if (q < 0) continue;
    const double value = q_[static_cast<std::size_t>(q)];
    if ((value <= tree_.lower[i] && g_raw_[x] > 0.0) ||
        (value >= tree_.upper[i] && g_raw_[x] < 0.0)) {
      at.held[i] = 1;
      at.g[x] = 0.0;
    }
  }
}

// How far along d until the first joint has turned by kLargestTurn.
double Minimizer::length_to_largest_turn() const {
  double turn = 1e-300;  // of the fastest joint at length 1
  for (Eigen::Index x = 0; x < d_.size(); ++x) {
    const auto v = static_cast<std::size_t>(tree_.unknown_v[static_cast<std::size_t>(x)]);
    turn = std::max(turn, workspace_.S[v].head<3>().norm() * std::abs(d_[x]));
  }
  return kLargestTurn / turn;
}

// Backtracks from the first length until Armijo's condition holds for the clipped step; the first
// shortening goes to the minimum of the parabola through f(0), f'(0) and f(length), later ones
// bisect.
bool Minimizer::search(Iterate& at) {
  length_ = std::min(direction_->scales_its_step() ? 1.0 : last_length_, length_to_largest_turn());
  for (int trial = 0; trial < kMaxTrials; ++trial) {
    f_new_ = evaluate_at(*at.targets, length_, g_new_);
    double slope = 0.0;  // g · (the step really taken)
    for (Eigen::Index x = 0; x < d_.size(); ++x) {
      const int q =
          tree_.q_of_v[static_cast<std::size_t>(tree_.unknown_v[static_cast<std::size_t>(x)])];
      const double taken =
          q < 0 ? step_[x] : q_new_[static_cast<std::size_t>(q)] - q_[static_cast<std::size_t>(q)];
      step_[x] = taken;
      slope += at.g[x] * taken;
    }
    const bool finite = std::isfinite(f_new_) && g_new_.allFinite();
    if (finite && f_new_ <= at.f + kArmijo * slope + kCostRounding * at.f) return true;
    const double minimizer = -0.5 * slope * length_ / (f_new_ - at.f - slope);
    const bool parabola = trial == 0 && finite && minimizer > 0.1 * length_ && minimizer < length_;
    length_ = parabola ? minimizer : 0.5 * length_;
  }
  return false;
}

void Minimizer::accept(Iterate& at) {
  std::swap(q_, q_new_);
  at.s = step_;
  at.y = g_new_ - g_raw_;
  at.previous_d = d_;
  direction_->learn(length_, at.f - f_new_);
  last_length_ = length_;
  at.f = f_new_;
  std::swap(g_raw_, g_new_);
  hold_bounds(at);
  for (Eigen::Index x = 0; x < at.g.size(); ++x) {
    if (at.held[static_cast<std::size_t>(x)]) at.s[x] = at.y[x] = 0.0;
  }
  ++at.iteration;
}

bool Minimizer::finished(const Iterate& at) {
  summary_.gradient_norm = at.g.size() > 0 ? at.g.cwiseAbs().maxCoeff() : 0.0;
  if (summary_.gradient_norm < tolerance_) {
    summary_.termination = Termination::kGradient;
  } else if (at.iteration >= options_.max_iterations) {
    summary_.termination = Termination::kMaxIterations;
  }
  return summary_.termination != Termination::kNone;
}

const Summary& Minimizer::minimize(const IkTargets& targets, std::span<double> q) {
  const auto start = std::chrono::steady_clock::now();
  summary_.termination = Termination::kNone;
  summary_.evaluations = 0;
  summary_.rows.clear();
  Iterate& at = *iterate_;
  at.targets = &targets;
  at.iteration = 0;
  last_length_ = 1.0;
  std::copy(q.begin(), q.end(), q_.begin());
  for (std::size_t x = 0; x < tree_.unknown_v.size(); ++x) {  // start inside the bounds
    const int i = tree_.q_of_v[static_cast<std::size_t>(tree_.unknown_v[x])];
    if (i < 0) continue;
    double& value = q_[static_cast<std::size_t>(i)];
    value = std::clamp(value, tree_.lower[x], tree_.upper[x]);
  }
  std::copy(q_.begin(), q_.end(), workspace_.q.begin());
  at.f = summary_.initial_cost = evaluate(targets, g_raw_);
  hold_bounds(at);
  direction_->start();
  if (!std::isfinite(at.f) || !g_raw_.allFinite()) summary_.termination = Termination::kNotFinite;
  while (summary_.termination == Termination::kNone && !finished(at)) {
    if (!direction_->compute(at, d_)) {
      direction_->start();
      d_ = -at.g;
    }
    const double f_before = at.f;
    if (!search(at)) {
      direction_->learn(0.0, 0.0);
      summary_.termination = Termination::kStalled;
      break;
    }
    accept(at);
    if (options_.record_iterations) {
      summary_.rows.push_back(
          {at.iteration, at.f, at.g.cwiseAbs().maxCoeff(), length_, at.s.norm()});
    }
    if (std::abs(f_before - at.f) < options_.cost_tolerance) {
      summary_.gradient_norm = at.g.cwiseAbs().maxCoeff();
      summary_.termination = Termination::kCostChange;
    }
  }
  // A failed search leaves the workspace elsewhere; callers read poses from it.
  std::copy(q_.begin(), q_.end(), workspace_.q.begin());
  update_kinematics(tree_, workspace_);
  std::copy(workspace_.q.begin(), workspace_.q.end(), q.begin());
  summary_.iterations = at.iteration;
  summary_.final_cost = at.f;
  summary_.held = static_cast<int>(std::count(at.held.begin(), at.held.end(), 1));
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
  summary_.seconds = elapsed.count();
  return summary_;
}

}  // namespace sinew
