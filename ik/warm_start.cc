#include "ik/warm_start.h"

#include <algorithm>
#include <cmath>

namespace sinew {
namespace {

// What is left of an error's square after a frame: two or three frames tell.
constexpr double kMemory = 0.5;

// A higher order has to have been nearer by this factor. After a jump all orders were off by the
// same, and the lowest is the one that does not jump again.
constexpr double kWorthIt = 0.7;

// Of the cost at the last solution that all unknowns' going on together has to come below: it
// doubles the noise of what markers hold weakly. On the whole body walking it leaves 0.003 of the
// cost and saves an iteration in four; with markers 1 mm and skin 10 mm off it took 10.6 iterations
// in place of 7.2.
constexpr double kWorthGoingOn = 0.1;

}  // namespace

WarmStart::WarmStart(const KinematicTree& tree, const IkProblem& problem)
    : histories_(static_cast<std::size_t>(tree.unknown_count())),
      measured_(problem.positions.size() + problem.orientations.size() + problem.distances.size(),
                0) {
  if (!problem.wires.empty()) together_.emplace(tree);
}

// Whether something is not measured any more, and what is now.
bool WarmStart::misses_some(const IkTargets& targets) {
  bool misses = false;
  auto before = measured_.begin();
  const auto note = [&](double value) {
    const bool now = !std::isnan(value);
    misses = misses || (*before && !now);
    *before++ = now;
  };
  for (const Eigen::Vector3d& p : targets.positions) note(p.x());
  for (const Eigen::Matrix3d& R : targets.orientations) note(R(0, 0));
  for (const double length : targets.distances) note(length);
  return misses;
}

double WarmStart::extrapolate(const History& h, int order) {
  switch (order) {
    case 0:
      return h.past[0];
    case 1:
      return 2.0 * h.past[0] - h.past[1];
    default:
      return 3.0 * (h.past[0] - h.past[1]) + h.past[2];
  }
}

int WarmStart::best_order(const History& h) const {
  int best = 0;
  for (int order = 1; order < std::min(known_ - 1, kOrders); ++order) {
    if (h.error[order] < kWorthIt * kWorthIt * h.error[best]) best = order;
  }
  return best;
}

void WarmStart::advance(const KinematicTree& tree, const IkProblem& problem,
                        const IkTargets& targets, std::vector<double>& q) {
  for (std::size_t x = 0; x < histories_.size(); ++x) {
    const int entry = tree.q_of_v[static_cast<std::size_t>(tree.unknown_v[x])];
    if (entry < 0) continue;
    const double value = q[static_cast<std::size_t>(entry)];
    History& h = histories_[x];
    for (int order = 0; order < kOrders; ++order) {
      if (order >= known_) {
        h.error[order] = 0.0;
        continue;
      }
      const double off = value - extrapolate(h, order);
      h.error[order] = kMemory * h.error[order] + off * off;
    }
    std::copy_backward(h.past, h.past + kOrders - 1, h.past + kOrders);
    h.past[0] = value;
  }
  known_ = std::min(known_ + 1, kOrders + 1);
  if (misses_some(targets)) {
    known_ = 1;
  } else if (!together_) {
    go_on(tree, q, [this](const History& h) { return best_order(h); });
  } else if (known_ > 1) {
    const double stay = cost_at(tree, problem, targets, q);
    last_ = q;  // the same size: copies without allocating
    go_on(tree, q, [](const History&) { return 1; });
    if (!(cost_at(tree, problem, targets, q) < kWorthGoingOn * stay)) q = last_;
  }
}

template <typename Order>
void WarmStart::go_on(const KinematicTree& tree, std::vector<double>& q, const Order& order) const {
  for (std::size_t x = 0; x < histories_.size(); ++x) {
    const int entry = tree.q_of_v[static_cast<std::size_t>(tree.unknown_v[x])];
    if (entry < 0) continue;
    const History& h = histories_[x];
    q[static_cast<std::size_t>(entry)] =
        std::clamp(extrapolate(h, order(h)), tree.lower[x], tree.upper[x]);
  }
}

double WarmStart::cost_at(const KinematicTree& tree, const IkProblem& problem,
                          const IkTargets& targets, const std::vector<double>& q) {
  std::copy(q.begin(), q.end(), together_->q.begin());
  update_poses(tree, *together_);
  return cost(tree, problem, targets, *together_);
}

}  // namespace sinew
