#include "ik/gradient_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <vector>

#include "data/numbers.h"

namespace sinew {
namespace {

// From steps at which rounding is far below the quotient down to steps that pass between q and a
// nearby corner of a spline or a piecewise linear function: 1e-2 to 3e-7.
constexpr double kFirstStep = 1e-2;
constexpr double kShrink = 2.0;
constexpr int kSteps = 16;
// Errors of orders h² and h⁴ are removed; more orders gain nothing beside rounding, and reach back
// to more of the large steps.
constexpr int kOrders = 3;

// Cost along one unknown, with bounds taken away.
class CostAlong {
 public:
  CostAlong(const KinematicTree& tree, const IkProblem& problem, const IkTargets& targets,
            std::span<const double> q)
      : tree_(tree), problem_(problem), targets_(targets), q_(q), workspace_(tree) {
    tree_.lower.assign(tree.lower.size(), -std::numeric_limits<double>::infinity());
    tree_.upper.assign(tree.upper.size(), std::numeric_limits<double>::infinity());
    step_.assign(static_cast<std::size_t>(tree.unknown_count()), 0.0);
  }

  struct Difference {
    double quotient, rounding;
  };
  Difference central(int x, double h) {
    const double ahead = at(x, h), behind = at(x, -h);
    constexpr double kEpsilon = std::numeric_limits<double>::epsilon();
    return {(ahead - behind) / (2.0 * h), kEpsilon * (ahead + behind) / (2.0 * h)};
  }

 private:
  double at(int x, double h) {
    step_[static_cast<std::size_t>(x)] = h;
    advance(tree_, q_, step_, workspace_.q);
    step_[static_cast<std::size_t>(x)] = 0.0;
    update_poses(tree_, workspace_);
    return cost(tree_, problem_, targets_, workspace_);
  }

  KinematicTree tree_;
  const IkProblem& problem_;
  const IkTargets& targets_;
  std::span<const double> q_;
  KinematicWorkspace workspace_;
  std::vector<double> step_;
};

struct Quotient {
  double value = kNaN;
  double uncertainty = std::numeric_limits<double>::infinity();
};

// Neville's table of quotients at shrinking steps, of which only the last row is kept: entry k has
// the errors of orders h² … h^(2k) removed. The best entry is the one that its two ancestors agree
// with best, rounding included.
Quotient extrapolate(CostAlong& cost_along, int x) {
  std::array<double, kOrders> row{}, last{};
  Quotient best;
  double h = kFirstStep;
  for (int i = 0; i < kSteps; ++i, h /= kShrink, last = row) {
    const CostAlong::Difference difference = cost_along.central(x, h);
    row[0] = difference.quotient;
    double factor = 1.0;
    for (std::size_t k = 1; k < kOrders && k <= static_cast<std::size_t>(i); ++k) {
      factor *= kShrink * kShrink;
      row[k] = (row[k - 1] * factor - last[k - 1]) / (factor - 1.0);
      const double uncertainty = difference.rounding + std::max(std::abs(row[k] - row[k - 1]),
                                                                std::abs(row[k] - last[k - 1]));
      if (uncertainty < best.uncertainty) best = {row[k], uncertainty};
    }
  }
  return best;
}

}  // namespace

double GradientCheck::worst_relative() const {
  return worst < 0 ? 0.0 : std::abs(difference[worst]) / scale;
}

GradientCheck check_gradient(const KinematicTree& tree, const IkProblem& problem,
                             const IkTargets& targets, std::span<const double> q) {
  validate(tree, problem, targets);
  if (q.size() != tree.default_q.size()) {
    throw std::invalid_argument(fmt::format("check_gradient got {} values of q; the tree has {}",
                                            q.size(), tree.default_q.size()));
  }
  const int n = tree.unknown_count();
  GradientCheck check;
  check.gradient.resize(n);
  check.quotient.resize(n);
  check.uncertainty.resize(n);
  KinematicWorkspace workspace(tree);
  std::copy(q.begin(), q.end(), workspace.q.begin());
  update_kinematics(tree, workspace);
  decomposed_gradient(tree, problem, targets, workspace, check.gradient);
  CostAlong cost_along(tree, problem, targets, q);
  for (int x = 0; x < n; ++x) {
    const Quotient quotient = extrapolate(cost_along, x);
    check.quotient[x] = quotient.value;
    check.uncertainty[x] = quotient.uncertainty;
  }
  check.difference = check.gradient - check.quotient;
  if (n == 0) return check;
  check.difference.cwiseAbs().maxCoeff<Eigen::PropagateNaN>(&check.worst);
  check.scale =
      std::max(check.gradient.cwiseAbs().maxCoeff(), check.quotient.cwiseAbs().maxCoeff());
  return check;
}

}  // namespace sinew
