#include "ik/box_quadratic.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <stdexcept>
#include <vector>

namespace sinew {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

enum class Held { kNot, kBelow, kAbove };

void check(const Eigen::MatrixXd& H, const VectorXd& g, const VectorXd& lower,
           const VectorXd& upper) {
  const Index n = g.size();
  if (H.rows() != n || H.cols() != n || lower.size() != n || upper.size() != n) {
    throw std::invalid_argument(fmt::format(
        "minimize_in_box: H is {} × {}, bounds have {} and {} numbers; expected {} of each",
        H.rows(), H.cols(), lower.size(), upper.size(), n));
  }
  for (Index i = 0; i < n; ++i) {
    if (lower[i] <= 0.0 && upper[i] >= 0.0) continue;
    throw std::invalid_argument(fmt::format(
        "minimize_in_box: bounds {} are {} and {}; expected 0 within", i, lower[i], upper[i]));
  }
}

// The minimum over the free unknowns, the others as they are.
VectorXd newton_point(const Eigen::MatrixXd& H, const VectorXd& gradient, const VectorXd& p,
                      const std::vector<Index>& free) {
  VectorXd to = p;
  if (free.empty()) return to;
  const VectorXd step = H(free, free).ldlt().solve(gradient(free));
  for (std::size_t i = 0; i < free.size(); ++i) {
    to[free[i]] -= step[static_cast<Index>(i)];
  }
  return to;
}

}  // namespace

VectorXd minimize_in_box(const Eigen::MatrixXd& H, const VectorXd& g, const VectorXd& lower,
                         const VectorXd& upper) {
  check(H, g, lower, upper);
  const Index n = g.size();
  VectorXd p = VectorXd::Zero(n);
  std::vector<Held> held(static_cast<std::size_t>(n), Held::kNot);
  // Bounds hold and let go about once each; rounding alone could make them do it for ever.
  for (Index round = 0; round < 20 * n + 20; ++round) {
    const VectorXd gradient = g + H * p;
    std::vector<Index> free;
    for (Index i = 0; i < n; ++i) {
      if (held[static_cast<std::size_t>(i)] == Held::kNot) free.push_back(i);
    }
    const VectorXd to = newton_point(H, gradient, p, free);
    double length = 1.0;
    Index meets = -1;
    for (const Index i : free) {
      const double bound = to[i] < lower[i] ? lower[i] : upper[i];
      if (to[i] >= lower[i] && to[i] <= upper[i]) continue;
      const double at = (bound - p[i]) / (to[i] - p[i]);
      if (at >= length) continue;
      length = at;
      meets = i;
    }
    for (const Index i : free) p[i] += length * (to[i] - p[i]);
    if (meets >= 0) {
      const bool below = to[meets] < lower[meets];
      p[meets] = below ? lower[meets] : upper[meets];
      held[static_cast<std::size_t>(meets)] = below ? Held::kBelow : Held::kAbove;
      continue;
    }
    // At the minimum of this face: the bound that pulls inwards most lets go.
    const VectorXd slope = g + H * p;
    Index freed = -1;
    double most = 1e-12 * (1.0 + g.cwiseAbs().maxCoeff());
    for (Index i = 0; i < n; ++i) {
      const Held side = held[static_cast<std::size_t>(i)];
      const double inwards = side == Held::kBelow ? -slope[i] : side == Held::kAbove ? slope[i] : 0;
      if (inwards <= most) continue;
      most = inwards;
      freed = i;
    }
    if (freed < 0) break;
    held[static_cast<std::size_t>(freed)] = Held::kNot;
  }
  return p;
}

}  // namespace sinew
