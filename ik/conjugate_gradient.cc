#include "ik/conjugate_gradient.h"

namespace sinew {

ConjugateGradient::ConjugateGradient(const KinematicTree& tree, const Options& options)
    : t_(options.t), held_(static_cast<std::size_t>(tree.unknown_count()), 0) {}

bool ConjugateGradient::compute(const Iterate& at, Eigen::Ref<Eigen::VectorXd> d) {
  // cos∠(d, −g) below this is rounding, not descent.
  constexpr double kSmallestCosine = 1e-10;
  const bool fresh = at.iteration == 0 || at.held != held_;
  held_ = at.held;  // same size: copies without allocating
  d = -at.g;
  if (fresh) return true;
  const double dy = at.previous_d.dot(at.y);
  if (!(dy > 0.0)) return true;
  const double beta = std::max(at.g.dot(at.y) / dy, 0.0) - t_ * at.g.dot(at.s) / dy;  // (37)
  d += beta * at.previous_d;                                                          // (36)
  // Held entries of previous_d are zero: they were held then too.
  if (!(-at.g.dot(d) > kSmallestCosine * at.g.norm() * d.norm())) d = -at.g;
  return true;
}

}  // namespace sinew
