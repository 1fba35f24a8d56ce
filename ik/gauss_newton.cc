#include "ik/gauss_newton.h"

#include <algorithm>
#include <cmath>

namespace sinew {
namespace {

// 1e8 times the mean curvature leaves steps of 1e-8: nothing more to gain beyond it.
constexpr double kLargestRelativeMu = 1e8;

}  // namespace

GaussNewton::GaussNewton(const KinematicTree& tree, const IkProblem& problem,
                         const Options& options)
    : options_(options),
      curvature_(tree, problem),
      factor_(tree.unknown_count(), curvature_.reversed_cliques(tree, problem)),
      held_(static_cast<std::size_t>(tree.unknown_count()), 0) {
  for (const GaussNewtonCurvature::Entry& entry : curvature_.entries()) {
    offsets_.push_back(factor_.offset(entry.row, entry.column));
  }
}

void GaussNewton::start() {
  relative_mu_ = options_.damping;
  growth_ = 2.0;
}

bool GaussNewton::compute(const Iterate& at, Eigen::Ref<Eigen::VectorXd> d) {
  curvature_.update(at.tree, at.problem, *at.targets, at.workspace);
  factor_.clear();
  curvature_.add_reversed(at.problem, *at.targets, at.workspace, offsets_, factor_.values());
  std::reverse_copy(at.held.begin(), at.held.end(), held_.begin());
  const double scale = std::max(factor_.mean_diagonal(), 1e-300);
  while (!factor_.factorize(relative_mu_ * scale, held_)) {
    relative_mu_ *= 10.0;
    if (!(relative_mu_ < kLargestRelativeMu)) return false;
  }
  d = -at.g.reverse();
  factor_.solve(d);
  d.reverseInPlace();
  const double slope = at.g.dot(d);
  expected_ = -0.5 * slope + 0.5 * relative_mu_ * scale * d.squaredNorm();
  return slope < 0.0;
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
