#include "ik/gauss_newton.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace sinew {
namespace {

// 1e8 times the mean curvature leaves steps of 1e-8: nothing more to gain beyond it.
constexpr double kLargestRelativeMu = 1e8;

// μ at the start of a frame where the problem has wires, likewise; it fades as steps succeed, or
// joints that are held weakly would end beside their minimum. What hangs on slack wires is held by
// next to nothing, and too long a step from far off ends badly: 1e-5 saves an iteration in ten on
// the detailed body walking, and leaves frames of the simplified one unsolved with 5 mm of noise.
constexpr double kWireDamping = 1e-4;

// What μ is multiplied by at least after a good step. On the detailed body walking 1/3, Nielsen's,
// takes 8.9 iterations a frame and 1/10 takes 3.1, both without corrections.
constexpr double kFade = 0.1;

// And after a bad one, twice as much after each in turn.
constexpr double kGrowth = 10.0;

// How far below its tolerance the gradient is to end, by the estimate, for a factorization to serve
// again.
constexpr double kSafety = 0.5;

// Rounds in which wires are added to one model that a step from it pulls taut: two or three serve.
constexpr int kMostRounds = 10;

}  // namespace

GaussNewton::GaussNewton(const KinematicTree& tree, const IkProblem& problem,
                         const Options& options, NewtonModel model)
    : options_(options),
      model_(model),
      curvature_(tree, problem, CostCurvature::Wires::kApart),
      factor_(tree.unknown_count(), curvature_.reversed_cliques(tree, problem)),
      held_(static_cast<std::size_t>(tree.unknown_count()), 0),
      prediction_(tree, problem),
      tensions_(tree.unknown_count(), static_cast<int>(problem.wires.size())),
      force_(problem.wires.size(), 0.0),
      bend_(problem.wires.size(), 0.0),
      gradient_(tree.unknown_count()),
      rhs_(tree.unknown_count()),
      stop_(tree.unknown_count()),
      solution_(tree.unknown_count()),
      d_(tree.unknown_count()) {
  indices_.reserve(static_cast<std::size_t>(tree.unknown_count()));
  row_.reserve(static_cast<std::size_t>(tree.unknown_count()));
  for (const CostCurvature::Entry& entry : curvature_.entries()) {
    offsets_.push_back(factor_.offset(entry.row, entry.column));
  }
}

void GaussNewton::start() {
  relative_mu_ = force_.empty() ? options_.damping : std::max(options_.damping, kWireDamping);
  growth_ = kGrowth;
  first_ = near_ = true;
  repeatable_ = false;
}

// The model without its wires, and how long these are now.
void GaussNewton::assemble(const Iterate& at, bool newton) {
  curvature_.update(at.tree, at.problem, *at.targets, at.workspace, newton);
  factor_.clear();
  curvature_.add_reversed(at.problem, *at.targets, at.workspace, offsets_, factor_.values());
  scale_ = std::max(factor_.mean_diagonal(), 1e-300);
  prediction_.update(at.problem, at.workspace, curvature_.rows().origin());
  for (std::size_t i = 0; i < force_.size(); ++i) {
    if (first_) force_[i] = at.problem.wires[i].weight * std::max(0.0, prediction_.excess()[i]);
    if (!(force_[i] > 0.0)) continue;
    curvature_.add_tension(at.problem, i, at.workspace, force_[i], offsets_, factor_.values());
  }
  first_ = false;
  gradient_ = at.g.reverse();
  stop_.setZero();
  stops_ = false;
  std::reverse_copy(at.held.begin(), at.held.end(), held_.begin());
}

bool GaussNewton::factorize(bool may_fail) {
  for (;;) {
    mu_ = relative_mu_ * scale_;
    if (factor_.factorize(mu_, held_)) return true;
    if (may_fail) return false;
    relative_mu_ *= 10.0;
    if (!(relative_mu_ < kLargestRelativeMu)) return false;
  }
}

// The row of a wire over the unknowns in reverse order, in indices_ and row_. Held ones are left
// out; returns what they do to its length.
double GaussNewton::take_row(const Iterate& at, std::size_t wire) {
  const InternalRows::WireRow full = curvature_.rows().wire_row(at.problem, wire, at.workspace);
  const std::span<const int> unknowns = curvature_.rows().support(full.support);
  const int last = static_cast<int>(rhs_.size()) - 1;
  double stretch = 0.0;
  indices_.clear();
  row_.clear();
  for (std::size_t k = 0; k < unknowns.size(); ++k) {
    const int reversed = last - unknowns[k];
    if (held_[static_cast<std::size_t>(reversed)]) {
      stretch += full.row[k] * stop_[reversed];
    } else {
      indices_.push_back(reversed);
      row_.push_back(full.row[k]);
    }
  }
  return stretch;
}

void GaussNewton::add_wire(const Iterate& at, std::size_t wire) {
  const double excess = prediction_.excess()[wire] + bend_[wire] + take_row(at, wire);
  tensions_.add(static_cast<int>(wire), excess, at.problem.wires[wire].weight, indices_, row_,
                factor_);
}

// Minimizes the model with what is held at stop_. Returns whether wires became taut or slack.
bool GaussNewton::minimize_with_wires(const Iterate& at) {
  const std::span<const double> excess = prediction_.excess();
  rhs_ = -gradient_;
  stored_ = 0.0;
  for (std::size_t i = 0; i < excess.size(); ++i) {
    if (!(excess[i] > 0.0)) continue;
    take_row(at, i);
    const double force = at.problem.wires[i].weight * excess[i];
    for (std::size_t k = 0; k < row_.size(); ++k) rhs_[indices_[k]] += force * row_[k];
    stored_ += 0.5 * force * excess[i];
  }
  if (stops_) {  // H · stop for what is held
    solution_.setZero();
    factor_.add_product(stop_, solution_);
    solution_ = rhs_ - solution_;
  } else {
    solution_ = rhs_;
  }
  for (Eigen::Index i = 0; i < solution_.size(); ++i) {
    if (held_[static_cast<std::size_t>(i)]) solution_[i] = stop_[i];
  }
  factor_.forward(solution_);
  tensions_.begin(solution_);
  std::fill(bend_.begin(), bend_.end(), 0.0);
  for (std::size_t i = 0; i < excess.size(); ++i) {
    if (excess[i] > 0.0) add_wire(at, i);
  }
  return add_taut_wires(at);
}

// Solves the model, and again with the wires that the step pulls taut, until there are no more.
bool GaussNewton::add_taut_wires(const Iterate& at) {
  bool changed = false, added = true;
  for (int round = 0; added && round < kMostRounds; ++round) {
    tensions_.solve();
    tensions_.step(factor_, solution_);
    d_ = solution_.reverse();
    added = false;
    if (force_.empty()) break;
    prediction_.predict(at.tree, at.problem, curvature_.rows(), d_);
    for (std::size_t i = 0; i < force_.size(); ++i) {
      const bool taut = prediction_.predicted()[i] + bend_[i] > 0.0;
      changed = changed || taut != (prediction_.excess()[i] > 0.0);
      if (!taut || tensions_.has(static_cast<int>(i))) continue;
      add_wire(at, i);
      added = true;
    }
  }
  for (std::size_t i = 0; i < force_.size(); ++i) {
    force_[i] = tensions_.tension(static_cast<int>(i));
  }
  return changed;
}

// Holds what the step carries over a bound there.
bool GaussNewton::stop_at_bounds(const Iterate& at) {
  bool changed = false;
  for (Eigen::Index x = 0; x < d_.size(); ++x) {
    const auto i = static_cast<std::size_t>(x);
    const auto reversed = static_cast<std::size_t>(d_.size() - 1 - x);
    const int entry = at.tree.q_of_v[static_cast<std::size_t>(at.tree.unknown_v[i])];
    if (entry < 0 || held_[reversed]) continue;
    const double q = at.workspace.q[static_cast<std::size_t>(entry)];
    const double lower = at.tree.lower[i] - q, upper = at.tree.upper[i] - q;
    if (d_[x] >= lower && d_[x] <= upper) continue;
    held_[reversed] = 1;
    stop_[static_cast<Eigen::Index>(reversed)] = d_[x] < lower ? lower : upper;
    stops_ = changed = true;
  }
  return changed;
}

bool GaussNewton::minimize_model(const Iterate& at, bool newton, Eigen::Ref<Eigen::VectorXd> d) {
  const bool may_fail = newton && model_ != NewtonModel::kNewton;
  assemble(at, newton);
  if (!factorize(may_fail)) return false;
  minimize_with_wires(at);
  if (stop_at_bounds(at)) {  // once: three times saves nothing
    if (!factorize(may_fail)) return false;
    minimize_with_wires(at);
  }
  d = d_;
  repeatable_ = force_.empty() && holds_same(at);
  if (repeatable_) {  // (H + μE)d = −g
    expected_ = -0.5 * at.g.dot(d_) + 0.5 * mu_ * d_.squaredNorm();
    return true;
  }
  // The model's decrease from 0 to the step.
  stop_ = d_.reverse();
  solution_.setZero();
  factor_.add_product(stop_, solution_);
  expected_ = rhs_.dot(stop_) - 0.5 * stop_.dot(solution_) + stored_ - tensions_.energy();
  return true;
}

// Whether to take all second derivatives first.
bool GaussNewton::tries_newton() const {
  return model_ == NewtonModel::kNearMinimum ? near_ : model_ != NewtonModel::kGaussNewton;
}

// The minimum of Newton's model, unless it is Gauss-Newton's that serves.
bool GaussNewton::minimize_newton(const Iterate& at, Eigen::Ref<Eigen::VectorXd> d) {
  const bool definite = minimize_model(at, true, d);
  if (model_ != NewtonModel::kNearMinimum) return definite;
  return near_ = definite && d_.cwiseAbs().maxCoeff() < kSmallStep;
}

bool GaussNewton::holds_same(const Iterate& at) const {
  return std::equal(at.held.rbegin(), at.held.rend(), held_.begin());
}

// Whether the last factorization will do: the gradient shrank by a factor over the last step, and
// shrinking it once more by the same is enough. A new factorization would square that factor, which
// nobody asks for. Not with wires, which bend the cost from one step to the next.
bool GaussNewton::may_repeat(const Iterate& at) {
  const double norm = at.g.size() > 0 ? at.g.cwiseAbs().maxCoeff() : 0.0;
  const double before = std::exchange(last_norm_, norm);
  return repeatable_ && norm * norm < kSafety * at.tolerance * before && holds_same(at);
}

// The step by the last factorization, if that will do.
bool GaussNewton::repeat(const Iterate& at, Eigen::Ref<Eigen::VectorXd> d) {
  if (!may_repeat(at)) return false;
  solution_ = -at.g.reverse();
  factor_.solve(solution_);
  d_ = solution_.reverse();
  stop_.setZero();
  if (stop_at_bounds(at)) return repeatable_ = false;
  d = d_;
  expected_ = -0.5 * at.g.dot(d) + 0.5 * mu_ * d_.squaredNorm();
  return true;
}

bool GaussNewton::compute(const Iterate& at, Eigen::Ref<Eigen::VectorXd> d) {
  if (repeat(at, d)) return true;
  for (;;) {
    bool done = tries_newton() && minimize_newton(at, d);
    if (!done && model_ != NewtonModel::kNewton) done = minimize_model(at, false, d);
    if (!done) return false;
    if (at.g.dot(d) < 0.0) return true;
    // Several bounds at once may lead uphill, but not if the step is short.
    relative_mu_ *= growth_;
    growth_ *= 2.0;
    if (!(relative_mu_ < kLargestRelativeMu)) return false;
  }
}

bool GaussNewton::correct(const Iterate& at, const KinematicWorkspace& trial,
                          Eigen::Ref<Eigen::VectorXd> d) {
  if (force_.empty()) return false;
  for (std::size_t i = 0; i < force_.size(); ++i) {
    const WireResidual& wire = at.problem.wires[i];
    const double excess = wire_length(at.problem, wire, trial) - wire.natural_length;
    const double bend = excess - prediction_.predicted()[i];
    tensions_.lengthen(static_cast<int>(i), bend - bend_[i]);
    bend_[i] = bend;
  }
  add_taut_wires(at);
  d = d_;
  return at.g.dot(d) < 0.0;
}

void GaussNewton::learn(double accepted_length, double actual_decrease) {
  const double ratio = expected_ > 0.0 ? actual_decrease / expected_ : 0.0;
  repeatable_ = repeatable_ && accepted_length == 1.0;
  // Where wires leave much to be held weakly, Newton's matrix is often not definite: one attempt.
  near_ = (near_ || force_.empty()) && accepted_length == 1.0 && ratio > 0.0 && d_.size() > 0 &&
          d_.cwiseAbs().maxCoeff() < kSmallStep;
  if (accepted_length == 1.0 && ratio > 0.0) {
    const double r = 2.0 * ratio - 1.0;
    relative_mu_ *= std::max(kFade, 1.0 - r * r * r);
    relative_mu_ = std::max(relative_mu_, options_.damping);
    growth_ = kGrowth;
  } else {
    relative_mu_ = std::min(relative_mu_ * growth_, kLargestRelativeMu);
    growth_ *= 2.0;
  }
}

}  // namespace sinew
