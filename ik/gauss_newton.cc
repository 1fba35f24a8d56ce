#include "ik/gauss_newton.h"

#include <algorithm>
#include <cmath>

namespace sinew {
namespace {

// 1e8 times the mean curvature leaves steps of 1e-8: nothing more to gain beyond it.
constexpr double kLargestRelativeMu = 1e8;

// μ at the start of a frame where the problem has wires, likewise; it fades as steps succeed, or
// joints that are held weakly would end beside their minimum. What hangs on slack wires is held by
// next to nothing, and too long a step pulls other wires taut. Measured while it did not fade, and
// with a looser gradient: on the whole body walking 1e-9 takes 6.5 iterations a frame, 1e-6 3.5,
// 1e-5 2.8 and 1e-4 2.2, with markers 1 mm and skin 10 mm off 12.2 and 5.6.
constexpr double kWireDamping = 1e-4;

// Factorizations for one direction. On the whole body walking, one takes 6.3 iterations and 39
// evaluations a frame, two take 6.5 and 18, three 5.6 and 10, without what kWireDamping does; more
// cost more than they save.
constexpr int kMostRounds = 2;

}  // namespace

GaussNewton::GaussNewton(const KinematicTree& tree, const IkProblem& problem,
                         const Options& options, NewtonModel model)
    : options_(options),
      model_(model),
      curvature_(tree, problem),
      factor_(tree.unknown_count(), curvature_.reversed_cliques(tree, problem)),
      held_(static_cast<std::size_t>(tree.unknown_count()), 0),
      prediction_(tree, problem),
      taut_(problem.wires.size(), 0),
      rhs_(tree.unknown_count()),
      stop_(tree.unknown_count()),
      solution_(tree.unknown_count()),
      d_(tree.unknown_count()) {
  for (const CostCurvature::Entry& entry : curvature_.entries()) {
    offsets_.push_back(factor_.offset(entry.row, entry.column));
  }
}

double GaussNewton::least_damping() const {
  return taut_.empty() ? options_.damping : std::max(options_.damping, kWireDamping);
}

void GaussNewton::start() {
  relative_mu_ = least_damping();
  growth_ = 2.0;
}

// The model with the wires that are taut now.
void GaussNewton::assemble(const Iterate& at, bool newton) {
  curvature_.update(at.tree, at.problem, *at.targets, at.workspace, newton);
  factor_.clear();
  curvature_.add_reversed(at.problem, *at.targets, at.workspace, offsets_, factor_.values());
  scale_ = std::max(factor_.mean_diagonal(), 1e-300);
  prediction_.update(at.problem, at.workspace, curvature_.rows().origin());
  for (std::size_t i = 0; i < taut_.size(); ++i) taut_[i] = prediction_.excess()[i] > 0.0;
  rhs_ = -at.g.reverse();
  stop_.setZero();
  slack_cost_ = 0.0;
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

// Takes wires into the model that the step pulls taut, and those out that it lets go.
bool GaussNewton::change_wires(const Iterate& at, const Eigen::VectorXd& d) {
  const std::span<const double> after =
      prediction_.predict(at.tree, at.problem, curvature_.rows(), d);
  const Eigen::Index last = rhs_.size() - 1;
  bool changed = false;
  for (std::size_t i = 0; i < taut_.size(); ++i) {
    const bool taut = after[i] > 0.0;
    if (taut == (taut_[i] != 0)) continue;
    changed = true;
    taut_[i] = taut;
    const double sign = taut ? 1.0 : -1.0;
    const InternalRows::WireRow wire =
        curvature_.add_wire(at.problem, i, at.workspace, sign, offsets_, factor_.values());
    const double excess = prediction_.excess()[i];
    const double force = sign * at.problem.wires[i].weight * excess;
    const std::span<const int> unknowns = curvature_.rows().support(wire.support);
    for (std::size_t k = 0; k < wire.row.size(); ++k)
      rhs_[last - unknowns[k]] -= force * wire.row[k];
    slack_cost_ += 0.5 * force * excess;
  }
  return changed;
}

// Holds what the step carries over a bound there.
bool GaussNewton::stop_at_bounds(const Iterate& at, const Eigen::VectorXd& d) {
  bool changed = false;
  for (Eigen::Index x = 0; x < d.size(); ++x) {
    const auto i = static_cast<std::size_t>(x);
    const auto reversed = static_cast<std::size_t>(d.size() - 1 - x);
    const int entry = at.tree.q_of_v[static_cast<std::size_t>(at.tree.unknown_v[i])];
    if (entry < 0 || held_[reversed]) continue;
    const double q = at.workspace.q[static_cast<std::size_t>(entry)];
    const double lower = at.tree.lower[i] - q, upper = at.tree.upper[i] - q;
    if (d[x] >= lower && d[x] <= upper) continue;
    held_[reversed] = 1;
    stop_[static_cast<Eigen::Index>(reversed)] = d[x] < lower ? lower : upper;
    changed = true;
  }
  return changed;
}

bool GaussNewton::minimize_model(const Iterate& at, bool newton, Eigen::Ref<Eigen::VectorXd> d) {
  assemble(at, newton);
  for (int round = 0;; ++round) {
    if (!factorize(newton && model_ == NewtonModel::kAutomatic)) return false;
    solution_.setZero();  // H · stop for what is held
    factor_.add_product(stop_, solution_);
    solution_ = rhs_ - solution_;
    for (Eigen::Index i = 0; i < solution_.size(); ++i) {
      if (held_[static_cast<std::size_t>(i)]) solution_[i] = stop_[i];
    }
    factor_.solve(solution_);
    d_ = solution_.reverse();
    if (round + 1 == kMostRounds) break;
    // Bounds alone are left to the line search and the active set: foreseen, they made problems
    // without wires cycle (5 mm of noise on the whole body: 319 ms a frame in place of 6).
    if (!change_wires(at, d_)) break;
    stop_at_bounds(at, d_);
  }
  d = d_;
  // The model's value at the step, with H + μE d = rhs where nothing is held.
  solution_.setZero();
  stop_ = d_.reverse();
  factor_.add_product(stop_, solution_);
  expected_ = rhs_.dot(stop_) - 0.5 * stop_.dot(solution_) - slack_cost_;
  return true;
}

bool GaussNewton::compute(const Iterate& at, Eigen::Ref<Eigen::VectorXd> d) {
  bool done = model_ != NewtonModel::kGaussNewton && minimize_model(at, true, d);
  if (!done && model_ != NewtonModel::kNewton) done = minimize_model(at, false, d);
  return done && at.g.dot(d) < 0.0;
}

void GaussNewton::learn(double accepted_length, double actual_decrease) {
  const double ratio = expected_ > 0.0 ? actual_decrease / expected_ : 0.0;
  if (accepted_length == 1.0 && ratio > 0.0) {
    const double r = 2.0 * ratio - 1.0;
    relative_mu_ *= std::max(1.0 / 3.0, 1.0 - r * r * r);
    relative_mu_ = std::max(relative_mu_, options_.damping);
    growth_ = 2.0;
  } else {
    relative_mu_ = std::min(relative_mu_ * growth_, kLargestRelativeMu);
    growth_ *= 2.0;
  }
}

}  // namespace sinew
