#include "ik/minimizer.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace sinew {
namespace {

// Armijo's constant: Nocedal & Wright's choice for methods that scale their step.
constexpr double kArmijo = 1e-4;

// Two costs closer than this fraction are equal to rounding: the sums run over about a hundred
// squares.
constexpr double kCostRounding = 1e-14;

// Halving 60 times passes the spacing of doubles.
constexpr int kMaxTrials = 60;

// Iterations in a row that lower neither the cost, to rounding, nor the gradient's smallest norm so
// far, before a frame ends as stalled. While conjugate gradients still make headway, their
// gradient's norm takes up to 60 iterations to fall below where it was.
constexpr int kMaxFlat = 100;

// A method that asks again multiplies its damping by 2, 4, 8, … or more: after ten times by 2^55.
constexpr int kMaxRetries = 10;

// A step that lowers the cost by less than this part of what its method expects is worth a
// correction, which costs an evaluation. On the whole body walking with markers 1 mm and skin 10 mm
// off, 0.9 saves one iteration in six.
constexpr double kWorthCorrecting = 0.9;

// A parabola is trusted this far beyond the length that it was drawn through.
constexpr double kLargestGrowth = 10.0;

// Weights set the scale of the gradient, so the tolerance follows their sum. Wires are left out:
// most are slack and pull at nothing, and a thousand of them would let markers end far from their
// places. So would a heavy task of a coordinate; but its gradient, w Δq, is rounded to w 1e-16,
// which 1e-4 of its weight keeps a thousand times below a tolerance of 1e-9.
double weight_scale(const IkProblem& problem) {
  constexpr double kCoordinateShare = 1e-4;
  double sum = 0.0;
  for (const PositionResidual& r : problem.positions) sum += r.weight.trace() / 3.0;
  for (const OrientationResidual& r : problem.orientations) sum += r.weight.trace() / 3.0;
  for (const DistanceResidual& r : problem.distances) sum += r.weight;
  for (const CoordinateResidual& r : problem.coordinates) sum += kCoordinateShare * r.weight;
  for (const CoincidenceResidual& r : problem.coincidences) sum += r.weight;
  for (const AlignmentResidual& r : problem.alignments) sum += r.weight;
  return std::max(1.0, sum);
}

double tolerance_of(const MinimizerOptions& options, const IkProblem& problem) {
  const bool scaled = options.test == GradientTest::kLargestEntry;
  return options.gradient_tolerance * (scaled ? weight_scale(problem) : 1.0);
}

}  // namespace

Minimizer::Minimizer(const KinematicTree& tree, const IkProblem& problem,
                     const MinimizerOptions& options)
    : tree_(tree),
      problem_(problem),
      options_(options),
      workspace_(tree),
      trial_(tree),
      other_(tree),
      d_(tree.unknown_count()),
      corrected_d_(tree.unknown_count()),
      g_raw_(tree.unknown_count()),
      jacobian_(3, tree.unknown_count()),
      iterate_{.tree = tree,
               .problem = problem,
               .targets = nullptr,
               .workspace = workspace_,
               .g = Eigen::VectorXd(tree.unknown_count()),
               .s = Eigen::VectorXd(tree.unknown_count()),
               .y = Eigen::VectorXd(tree.unknown_count()),
               .previous_d = Eigen::VectorXd(tree.unknown_count()),
               .held = std::vector<char>(static_cast<std::size_t>(tree.unknown_count()), 0)},
      tolerance_(tolerance_of(options, problem)) {
  options_.validate();
  options_.method = resolved_method(tree, problem, options_);
  iterate_.tolerance = tolerance_;
  if (continues_gradient_sweep(options_.method)) options_.gradient = GradientKind::kDecomposed;
  direction_ = make_direction(tree, problem, options_);
}

double Minimizer::gradient(const IkTargets& targets, KinematicWorkspace& ws, Eigen::VectorXd& g) {
  ++summary_.evaluations;
  update_kinematics(tree_, ws);
  return options_.gradient == GradientKind::kDecomposed
             ? decomposed_gradient(tree_, problem_, targets, ws, g)
             : jacobian_gradient(tree_, problem_, targets, ws, jacobian_, g);
}

void Minimizer::hold_bounds(Iterate& at) const {
  for (Eigen::Index x = 0; x < at.g.size(); ++x) {
    const auto i = static_cast<std::size_t>(x);
    const int q = tree_.q_of_v[static_cast<std::size_t>(tree_.unknown_v[i])];
    at.g[x] = g_raw_[x];
    at.held[i] = 0;
    if (q < 0) continue;
    const double value = workspace_.q[static_cast<std::size_t>(q)];
    if ((value <= tree_.lower[i] && g_raw_[x] > 0.0) ||
        (value >= tree_.upper[i] && g_raw_[x] < 0.0)) {
      at.held[i] = 1;
      at.g[x] = 0.0;
    }
  }
}

// How far along d until the first joint has turned by the largest turn.
double Minimizer::length_to_largest_turn() const {
  double turn = 1e-300;  // of the fastest joint at length 1
  for (Eigen::Index x = 0; x < d_.size(); ++x) {
    const auto v = static_cast<std::size_t>(tree_.unknown_v[static_cast<std::size_t>(x)]);
    turn = std::max(turn, workspace_.S[v].head<3>().norm() * std::abs(d_[x]));
  }
  return options_.largest_turn / turn;
}

// Evaluates f(q ⊞ length · d), its gradient as well if asked to, and the slope of the clipped step.
void Minimizer::evaluate_trial(const Iterate& at, const Eigen::VectorXd& d, double length,
                               bool with_gradient) {
  trial_.length = length;
  Eigen::VectorXd& step = trial_.step;
  step = length * d;
  advance(tree_, workspace_.q, {step.data(), static_cast<std::size_t>(step.size())},
          trial_.workspace.q);
  trial_.slope = 0.0;
  for (Eigen::Index x = 0; x < step.size(); ++x) {
    const int entry =
        tree_.q_of_v[static_cast<std::size_t>(tree_.unknown_v[static_cast<std::size_t>(x)])];
    if (entry >= 0) {
      const auto q = static_cast<std::size_t>(entry);
      step[x] = trial_.workspace.q[q] - workspace_.q[q];
    }
    trial_.slope += at.g[x] * step[x];
  }
  if (with_gradient) {
    trial_.f = gradient(*at.targets, trial_.workspace, trial_.g);
  } else {
    ++summary_.evaluations;
    update_poses(tree_, trial_.workspace);
    trial_.f = cost(tree_, problem_, *at.targets, trial_.workspace);
  }
}

// Whether Armijo's condition holds at the length. The gradient there is known afterwards if it
// does; with_gradient computes both at once, which is cheaper where acceptance is likely.
bool Minimizer::try_length(const Iterate& at, const Eigen::VectorXd& d, double length,
                           bool with_gradient) {
  evaluate_trial(at, d, length, with_gradient);
  // Clipping may turn a long step uphill. False where the cost is not a number.
  if (trial_.slope > 0.0 || !(trial_.f <= at.f + kArmijo * trial_.slope + kCostRounding * at.f)) {
    return false;
  }
  if (!with_gradient) gradient(*at.targets, trial_.workspace, trial_.g);
  return std::isfinite(trial_.f) && trial_.g.allFinite();
}

// The whole direction, or its correction if that ends lower.
bool Minimizer::try_full_length(const Iterate& at) {
  const bool accepted = try_length(at, d_, 1.0, true);
  const double expected = direction_->expected_decrease();
  // False where the method expects nothing or the cost is not a number.
  const bool short_of_it = at.f - trial_.f < kWorthCorrecting * expected;
  if (!short_of_it || !(expected > kCostRounding * at.f)) return accepted;
  if (!direction_->correct(at, trial_.workspace, corrected_d_)) return accepted;
  std::swap(trial_, other_);
  if (try_length(at, corrected_d_, 1.0, true) && !(accepted && other_.f <= trial_.f)) {
    d_.swap(corrected_d_);
    return true;
  }
  std::swap(trial_, other_);
  return accepted;
}

// The minimum of the parabola through f(q), the slope and f at the last accepted length; through
// both slopes where the costs differ by no more than rounding.
double Minimizer::interpolated_length(const Iterate& at) {
  const double largest = length_to_largest_turn();
  double length = std::min(last_length_, largest);
  evaluate_trial(at, d_, length, false);
  const auto usable = [&] { return std::isfinite(trial_.f) && trial_.slope < 0.0; };
  for (int trial = 0; !usable() && trial < kMaxTrials; ++trial) {
    length *= 0.5;
    evaluate_trial(at, d_, length, false);
  }
  double bend = trial_.f - at.f - trial_.slope;
  if (std::abs(bend) < 10.0 * kCostRounding * at.f) {  // noise: the slopes still tell
    gradient(*at.targets, trial_.workspace, trial_.g);
    bend = 0.5 * (trial_.g.dot(trial_.step) - trial_.slope);
  }
  const double grown = kLargestGrowth * length;
  const double minimizer = bend > 0.0 ? -0.5 * trial_.slope * length / bend : grown;
  return std::min({minimizer, grown, largest});
}

bool Minimizer::backtrack(const Iterate& at) {
  for (int trial = 0; trial < kMaxTrials; ++trial) {
    double shorter = 0.5 * trial_.length;
    if (trial == 0 && std::isfinite(trial_.f) && trial_.slope < 0.0) {
      const double minimizer =
          -0.5 * trial_.slope * trial_.length / (trial_.f - at.f - trial_.slope);
      if (minimizer > 0.1 * trial_.length && minimizer < trial_.length) shorter = minimizer;
    }
    if (try_length(at, d_, shorter, false)) return true;
  }
  return false;
}

bool Minimizer::step_by_direction(Iterate& at) {
  for (int retry = 0;; ++retry) {
    if (!direction_->compute(at, d_)) return false;
    const bool scaled = direction_->scales_its_step() && !options_.always_interpolate;
    const double length =
        scaled ? std::min(1.0, length_to_largest_turn()) : interpolated_length(at);
    if (length == 1.0 ? try_full_length(at) : try_length(at, d_, length, true)) return true;
    if (!direction_->wants_retry() || retry == kMaxRetries) break;
    direction_->learn(0.0, std::isfinite(trial_.f) ? at.f - trial_.f : -HUGE_VAL);
  }
  if (backtrack(at)) return true;
  direction_->learn(0.0, 0.0);
  return false;
}

// Only a decrease beyond rounding counts, or −g would be tried for ever at the end.
bool Minimizer::step_by_gradient(Iterate& at) {
  direction_->start();
  d_ = -at.g;
  return (try_length(at, d_, interpolated_length(at), true) || backtrack(at)) &&
         trial_.f < at.f * (1.0 - kCostRounding);
}

void Minimizer::accept(Iterate& at) {
  std::swap(workspace_, trial_.workspace);
  at.s = trial_.step;
  at.y = trial_.g - g_raw_;
  at.previous_d = d_;
  last_length_ = trial_.length;
  at.f = trial_.f;
  std::swap(g_raw_, trial_.g);
  hold_bounds(at);
  for (Eigen::Index x = 0; x < at.g.size(); ++x) {
    if (at.held[static_cast<std::size_t>(x)]) at.s[x] = at.y[x] = 0.0;
  }
  ++at.iteration;
}

double Minimizer::gradient_norm(const Iterate& at) const {
  if (at.g.size() == 0) return 0.0;
  return options_.test == GradientTest::kEuclidean ? at.g.norm() : at.g.cwiseAbs().maxCoeff();
}

bool Minimizer::finished(const Iterate& at) {
  summary_.gradient_norm = gradient_norm(at);
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start_;
  if (summary_.gradient_norm < tolerance_) {
    summary_.termination = Termination::kGradient;
  } else if (summary_.termination == Termination::kNone &&
             at.iteration >= options_.max_iterations) {
    summary_.termination = Termination::kMaxIterations;
  } else if (summary_.termination == Termination::kNone &&
             (elapsed.count() > options_.time_limit || (options_.stop && options_.stop()))) {
    summary_.termination = Termination::kTimeLimit;
  }
  return summary_.termination != Termination::kNone;
}

void Minimizer::start_at(const IkTargets& targets, std::span<const double> q) {
  start_ = std::chrono::steady_clock::now();
  summary_.termination = Termination::kNone;
  summary_.evaluations = 0;
  summary_.gradient_norm = kNaN;
  summary_.rows.clear();
  std::copy(q.begin(), q.end(), workspace_.q.begin());
  for (std::size_t x = 0; x < tree_.unknown_v.size(); ++x) {  // start inside the bounds
    const int i = tree_.q_of_v[static_cast<std::size_t>(tree_.unknown_v[x])];
    if (i < 0) continue;
    double& value = workspace_.q[static_cast<std::size_t>(i)];
    value = std::clamp(value, tree_.lower[x], tree_.upper[x]);
  }
  Iterate& at = iterate_;
  at.targets = &targets;
  at.iteration = 0;
  at.f = summary_.initial_cost = gradient(targets, workspace_, g_raw_);
  hold_bounds(at);
  last_length_ = 1.0;
  direction_->start();
  if (!std::isfinite(at.f) || !g_raw_.allFinite()) summary_.termination = Termination::kNotFinite;
}

const Summary& Minimizer::minimize(const IkTargets& targets, std::span<double> q) {
  start_at(targets, q);
  Iterate& at = iterate_;
  if (summary_.termination == Termination::kNone) finished(at);
  int flat = 0;
  double smallest_norm = summary_.gradient_norm;
  while (summary_.termination == Termination::kNone) {
    const double f_before = at.f;
    if (step_by_direction(at)) {
      direction_->learn(trial_.length, at.f - trial_.f);
    } else if (!step_by_gradient(at)) {
      summary_.termination = Termination::kStalled;
      break;
    }
    accept(at);
    const double norm = gradient_norm(at);
    if (options_.record_iterations) {
      summary_.rows.push_back({at.iteration, at.f, norm, trial_.length, at.s.norm()});
    }
    const bool headway = at.f < f_before * (1.0 - kCostRounding) || norm < smallest_norm;
    flat = headway ? 0 : flat + 1;
    smallest_norm = std::min(smallest_norm, norm);
    if (std::abs(f_before - at.f) < options_.cost_tolerance) {
      summary_.termination = Termination::kCostChange;
    } else if (flat == kMaxFlat) {
      summary_.termination = Termination::kStalled;
    }
    finished(at);
  }
  std::copy(workspace_.q.begin(), workspace_.q.end(), q.begin());
  summary_.iterations = at.iteration;
  summary_.final_cost = at.f;
  summary_.held = 0;
  summary_.bound_push = 0.0;
  for (Eigen::Index x = 0; x < g_raw_.size(); ++x) {
    if (!at.held[static_cast<std::size_t>(x)]) continue;
    ++summary_.held;
    summary_.bound_push = std::max(summary_.bound_push, std::abs(g_raw_[x]));
  }
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start_;
  summary_.seconds = elapsed.count();
  return summary_;
}

}  // namespace sinew
