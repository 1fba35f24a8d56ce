#include "ik/bfgs.h"

#include <algorithm>

namespace sinew {

Bfgs::Bfgs(const KinematicTree& tree)
    : H_(tree.unknown_count(), tree.unknown_count()),
      Hy_(tree.unknown_count()),
      column_(tree.unknown_count()),
      held_(static_cast<std::size_t>(tree.unknown_count()), 0) {}

void Bfgs::start() {
  H_.setIdentity();
  std::fill(held_.begin(), held_.end(), 0);
}

// H_FF ← H_FF − h hᵀ/H_xx is the inverse of the Hessian without row and column x.
void Bfgs::eliminate(Eigen::Index x) {
  const double pivot = H_(x, x);
  column_.head(x) = H_.row(x).head(x);
  column_.tail(H_.rows() - x) = H_.col(x).tail(H_.rows() - x);
  column_[x] = 0.0;
  H_.selfadjointView<Eigen::Lower>().rankUpdate(column_, -1.0 / pivot);
  H_.row(x).head(x).setZero();
  H_.col(x).tail(H_.rows() - x).setZero();
  H_(x, x) = pivot;
}

// (34), multiplied out.
void Bfgs::update(const Iterate& at) {
  const double sy = at.s.dot(at.y);
  // As in L-BFGS: curvature that is not positive beyond rounding would make H indefinite.
  if (!(sy > 1e-12 * at.s.norm() * at.y.norm())) return;
  Hy_.noalias() = H_.selfadjointView<Eigen::Lower>() * at.y;
  const double ss = (1.0 + at.y.dot(Hy_) / sy) / sy;
  for (Eigen::Index j = 0; j < H_.cols(); ++j) {  // Eigen's rank-two update allocates
    const Eigen::Index below = H_.rows() - j;
    H_.col(j).tail(below) +=
        (ss * at.s[j] - Hy_[j] / sy) * at.s.tail(below) - at.s[j] / sy * Hy_.tail(below);
  }
}

bool Bfgs::compute(const Iterate& at, Eigen::Ref<Eigen::VectorXd> d) {
  for (Eigen::Index x = 0; x < d.size(); ++x) {
    const auto i = static_cast<std::size_t>(x);
    if (at.held[i] && !held_[i]) eliminate(x);
    held_[i] = at.held[i];
  }
  if (at.iteration > 0) update(at);
  d.noalias() = H_.selfadjointView<Eigen::Lower>() * (-at.g);  // (33)
  return d.dot(at.g) < 0.0;
}

}  // namespace sinew
