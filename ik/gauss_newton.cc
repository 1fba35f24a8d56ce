#include "ik/gauss_newton.h"

#include <algorithm>
#include <cmath>

namespace sinew {
namespace {

// 1e8 times the mean curvature leaves steps of 1e-8: nothing more to gain beyond it.
constexpr double kLargestRelativeMu = 1e8;

}  // namespace

GaussNewton::GaussNewton(const KinematicTree& tree, const Options& options)
    : options_(options),
      curvature_(tree),
      H_(tree.unknown_count(), tree.unknown_count()),
      factor_(tree.unknown_count(), tree.unknown_count()),
      Hd_(tree.unknown_count()) {}

void GaussNewton::start() {
  relative_mu_ = options_.damping;
  growth_ = 2.0;
}

bool GaussNewton::factorize(const Iterate& at, double mu) {
  factor_ = H_;
  factor_.diagonal().array() += mu;
  for (Eigen::Index x = 0; x < factor_.rows(); ++x) {
    if (!at.held[static_cast<std::size_t>(x)]) continue;
    factor_.row(x).setZero();
    factor_.col(x).setZero();
    factor_(x, x) = 1.0;
  }
  Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>> llt(factor_);  // in place
  return llt.info() == Eigen::Success;
}

bool GaussNewton::compute(const Iterate& at, Eigen::Ref<Eigen::VectorXd> d) {
  curvature_.update(at.tree, at.problem, *at.targets, at.workspace);
  curvature_.matrix(at.tree, at.problem, *at.targets, at.workspace, H_);
  scale_ = std::max(H_.diagonal().mean(), 1e-300);
  while (!factorize(at, relative_mu_ * scale_)) {
    relative_mu_ *= 10.0;
    if (!(relative_mu_ < kLargestRelativeMu)) return false;
  }
  d = -at.g;
  factor_.triangularView<Eigen::Lower>().solveInPlace(d);
  factor_.triangularView<Eigen::Lower>().transpose().solveInPlace(d);
  Hd_.noalias() = H_ * d;
  expected_ = -at.g.dot(d) - 0.5 * d.dot(Hd_);
  return d.dot(at.g) < 0.0;
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
