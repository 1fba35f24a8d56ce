#include "ik/lbfgs.h"

#include <algorithm>
#include <cmath>

namespace sinew {

Lbfgs::Lbfgs(const KinematicTree& tree, const IkProblem& problem, const Options& options)
    : start_(options.start),
      curvature_(tree, problem),
      S_(tree.unknown_count(), options.memory),
      Y_(tree.unknown_count(), options.memory),
      rho_(options.memory),
      alpha_(options.memory),
      inverse_diagonal_(tree.unknown_count()) {}

void Lbfgs::start() { stored_ = next_ = 0; }

void Lbfgs::remember(const Iterate& at) {
  const double sy = at.s.dot(at.y);
  // A pair without positive curvature would make H indefinite; the bound is Nocedal & Wright's
  // cautious update with rounding as the margin.
  if (!(sy > 1e-12 * at.s.norm() * at.y.norm())) return;
  S_.col(next_) = at.s;
  Y_.col(next_) = at.y;
  rho_[next_] = 1.0 / sy;
  next_ = (next_ + 1) % static_cast<int>(S_.cols());
  stored_ = std::min(stored_ + 1, static_cast<int>(S_.cols()));
  if (start_ == Start::kScaledIdentity) inverse_diagonal_.setConstant(sy / at.y.squaredNorm());
}

void Lbfgs::precondition(const Iterate& at) {
  if (start_ == Start::kScaledIdentity) {
    inverse_diagonal_.setOnes();
    return;
  }
  curvature_.update(at.tree, at.problem, *at.targets, at.workspace);
  curvature_.diagonal(at.tree, at.problem, *at.targets, at.workspace, inverse_diagonal_);
  // Unknowns that no residual sees get the largest curvature: they stay where they are.
  const double largest = std::max(inverse_diagonal_.maxCoeff(), 1e-300);
  for (double& value : inverse_diagonal_) {
    value = 1.0 / (value > 1e-6 * largest ? value : largest);
  }
}

bool Lbfgs::compute(const Iterate& at, Eigen::Ref<Eigen::VectorXd> d) {
  if (at.iteration == 0) {
    precondition(at);
  } else {
    remember(at);
  }
  const int memory = static_cast<int>(S_.cols());
  const auto slot = [&](int age) { return (next_ - 1 - age + 2 * memory) % memory; };
  d = -at.g;
  for (int age = 0; age < stored_; ++age) {
    const int i = slot(age);
    alpha_[i] = rho_[i] * S_.col(i).dot(d);
    d -= alpha_[i] * Y_.col(i);
  }
  d.array() *= inverse_diagonal_.array();
  for (int age = stored_ - 1; age >= 0; --age) {
    const int i = slot(age);
    d += (alpha_[i] - rho_[i] * Y_.col(i).dot(d)) * S_.col(i);
  }
  for (Eigen::Index x = 0; x < d.size(); ++x) {
    if (at.held[static_cast<std::size_t>(x)]) d[x] = 0.0;
  }
  return d.dot(at.g) < 0.0;
}

}  // namespace sinew
