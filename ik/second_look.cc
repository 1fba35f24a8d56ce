#include "ik/second_look.h"

#include <algorithm>
#include <cmath>

namespace sinew {
namespace {

// A lower cost by less than this part is the same minimum.
constexpr double kLower = 1e-6;

// A bound is doubted where moving the coordinate 0.1 rad beyond it would, by the gradient, save
// this part of the cost: near a good minimum bounds hold against noise.
constexpr double kReach = 0.1, kWorthDoubting = 0.02;

// Costs of neighbouring frames differ by less than this factor unless markers come or go.
constexpr double kJump = 2.0;

// Costs below that of this distance on every marker [m] are good whatever they do.
constexpr double kGood = 1e-4;

// A bound that goes on holding is looked at again after so many frames.
constexpr int kPatience = 64;

double good_cost(const TrackingProblem& tracking) {
  double sum = 0.0;
  for (const TrackedMarker& marker : tracking.markers) sum += marker.weight;
  return 0.5 * sum * kGood * kGood;
}

class Doubts {
 public:
  Doubts(const TrackingResult& result, double good) : result_(result), good_(good) {}

  bool about(int frame) {
    const FrameResult& at = result_.frames[static_cast<std::size_t>(frame)];
    const bool pushed = pushes(at);
    const bool doubtful = (pushed && (!pushed_ || frame - last_look_ >= kPatience)) ||
                          jumps_beside(frame, -1) || jumps_beside(frame, 1);
    pushed_ = pushed;
    if (doubtful) last_look_ = frame;
    return doubtful;
  }

 private:
  bool pushes(const FrameResult& at) const {
    const double gain = kReach * at.bound_push;
    return gain > good_ && gain > kWorthDoubting * at.cost;
  }
  // Higher than the neighbour although it sees no more markers.
  bool jumps_beside(int frame, int step) const {
    const int other = frame + step;
    if (other < 0 || other >= static_cast<int>(result_.frames.size())) return false;
    const FrameResult& at = result_.frames[static_cast<std::size_t>(frame)];
    const FrameResult& beside = result_.frames[static_cast<std::size_t>(other)];
    return at.cost > good_ && at.cost > kJump * beside.cost &&
           at.measured_markers <= beside.measured_markers;
  }

  const TrackingResult& result_;
  const double good_;
  bool pushed_ = false;
  int last_look_ = -kPatience;
};

}  // namespace

void read_solution(const KinematicTree& tree, const TrackingResult& result, int frame,
                   std::span<double> q) {
  for (std::size_t c = 0; c < tree.q_of_coordinate.size(); ++c) {
    if (tree.q_of_coordinate[c] < 0) continue;
    q[static_cast<std::size_t>(tree.q_of_coordinate[c])] =
        result.coordinates(frame, static_cast<Eigen::Index>(c));
  }
}

int sweep(FrameSolver& solver, int from, bool backward, std::vector<double> q,
          TrackingResult& result) {
  const int step = backward ? -1 : 1, count = static_cast<int>(result.frames.size());
  solver.begin_anew();
  int frame = from;
  for (; frame >= 0 && frame < count; frame += step) {
    const double had = result.frames[static_cast<std::size_t>(frame)].cost;
    const Summary& summary = solver.solve(frame, q);
    if (!(summary.final_cost < had * (1.0 - kLower))) break;
    solver.store(frame, summary, q, result);
  }
  return frame;
}

void look_again(FrameSolver& solver, const KinematicTree& tree, const TrackingProblem& tracking,
                const std::function<bool()>& keep_going, TrackingResult& result) {
  Doubts doubts(result, good_cost(tracking));
  std::vector<double> q = tree.default_q;
  for (int frame = 0; frame < static_cast<int>(result.frames.size()); ++frame) {
    if (!doubts.about(frame)) continue;
    if (!keep_going()) return;
    ++result.looked_again;
    read_solution(tree, result, frame, q);
    const double cost = result.frames[static_cast<std::size_t>(frame)].cost;
    const Summary* lower = solver.look_again(frame, q, cost);
    if (lower == nullptr) continue;
    ++result.lowered;
    solver.store(frame, *lower, q, result);
    sweep(solver, frame - 1, true, q, result);
    sweep(solver, frame + 1, false, q, result);
  }
}

}  // namespace sinew
