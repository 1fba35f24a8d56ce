#include "ik/continuity.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <tuple>
#include <utility>
#include <variant>

namespace sinew {
namespace {

using Eigen::Vector3d;

constexpr double kPi = std::numbers::pi, kTurn = 2.0 * kPi;

// Cosines below this are rounding of axes that a file prints with six digits.
constexpr double kNormal = 1e-6;

// The other triple of normal axes is half a turn away in two angles, so that it can be nearer only
// if one of them has gone a quarter turn. Of oblique axes it may be nearer after less, but steps
// below this do not spoil a derivative.
constexpr double kWorthLooking = 0.1;  // [rad]

// Another triple is nearer only if it is so by more than rounding.
constexpr double kNearer = 1e-9;

// Moving along a pole's line by t turns the body by t sin(θ₂ − φ) or less. Beyond these no cost
// stays equal: a turn of 1e-3 is a tenth of a millimetre on a marker 0.1 m away. Small steps stay
// as they are: moved as far as the cost stays equal, a smooth passage would stick at the pole and
// slip.
constexpr double kNearPole = 0.02, kLineTurn = 1e-3;

// Of the way that the quadratic growth of the cost allows: its higher powers are not known.
constexpr double kShyOfEqual = 0.9;

// Costs that differ by less than this part are equal; a tenth of what `sinew validate` tolerates.
constexpr double kSameCost = 1e-7;
constexpr double kNoise = 1e-9;  // [m] on every marker: costs below are rounding

// Bounds are met if they are missed by rounding.
constexpr double kBoundSlack = 1e-12;  // [rad]

std::optional<LinearFunction> as_linear(const ScalarFunction& function) {
  std::optional<LinearFunction> linear;
  if (const auto* f = std::get_if<LinearFunction>(&function.kind)) {
    linear = *f;
  } else if (const auto* p = std::get_if<PolynomialFunction>(&function.kind)) {
    const std::vector<double>& c = p->coefficients;  // highest power first
    const std::size_t n = c.size();
    const auto high = c.begin() + static_cast<std::ptrdiff_t>(n < 2 ? 0 : n - 2);
    if (n >= 2 && std::all_of(c.begin(), high, [](double each) { return each == 0.0; })) {
      linear = LinearFunction{c[n - 2], c[n - 1]};
    }
  }
  if (!linear) return linear;
  linear->slope *= function.scale;
  linear->intercept *= function.scale;
  if (linear->slope == 0.0) return std::nullopt;
  return linear;
}

// The turns of a joint in succession; without a coordinate where one is not linear in it.
std::vector<FreeTurn> turns_of(const Joint& joint) {
  std::vector<FreeTurn> turns;
  const auto add = [&](std::size_t i, const Vector3d& axis) {
    turns.push_back({joint.coordinates[i], axis});
  };
  switch (joint.kind) {
    case Joint::Kind::kPin:
    case Joint::Kind::kPlanar:
      add(0, Vector3d::UnitZ());
      break;
    case Joint::Kind::kUniversal:
    case Joint::Kind::kBall:
    case Joint::Kind::kGimbal:
    case Joint::Kind::kFree:
    case Joint::Kind::kEllipsoid:
      add(0, Vector3d::UnitX());
      add(1, Vector3d::UnitY());
      if (joint.kind != Joint::Kind::kUniversal) add(2, Vector3d::UnitZ());
      break;
    case Joint::Kind::kCustom:
      for (std::size_t i = 0; i < 3; ++i) {
        const TransformAxis& axis = joint.axes[i];
        FreeTurn turn;
        turn.axis = axis.axis.normalized();
        if (const auto linear = as_linear(axis.function); linear && axis.coordinate >= 0) {
          turn.coordinate = axis.coordinate;
          turn.slope = linear->slope;
          turn.intercept = linear->intercept;
        }
        turns.push_back(turn);
      }
      break;
    case Joint::Kind::kWeld:
    case Joint::Kind::kSlider:
      break;
  }
  return turns;
}

// Which coordinates do nothing but turn their joint about one axis.
std::vector<bool> only_turning(const MusculoskeletalModel& model, const KinematicTree& tree,
                               const IkProblem& problem) {
  std::vector<bool> only(model.coordinates.size(), false);
  std::vector<int> uses(model.coordinates.size(), 0);
  for (const Joint& joint : model.joints) {
    if (joint.kind != Joint::Kind::kCustom) continue;
    for (const TransformAxis& axis : joint.axes) {
      if (axis.coordinate < 0 || CompiledFunction(axis.function).is_constant()) continue;
      ++uses[static_cast<std::size_t>(axis.coordinate)];
    }
  }
  for (std::size_t c = 0; c < only.size(); ++c) {
    const int v = tree.v_of_coordinate[c], q = tree.q_of_coordinate[c];
    only[c] = q >= 0 && tree.unknown_of_v[static_cast<std::size_t>(v)] >= 0 && uses[c] <= 1 &&
              std::none_of(tree.couplings.begin(), tree.couplings.end(),
                           [&](const auto& coupling) { return coupling.independent_v == v; }) &&
              std::none_of(problem.wire_points.begin(), problem.wire_points.end(),
                           [&](const WirePoint& point) { return point.condition_q == q; });
  }
  return only;
}

void set_bounds(const KinematicTree& tree, FreeTurn& turn) {
  const auto c = static_cast<std::size_t>(turn.coordinate);
  const auto x = static_cast<std::size_t>(
      tree.unknown_of_v[static_cast<std::size_t>(tree.v_of_coordinate[c])]);
  turn.lower = turn.slope * tree.lower[x] + turn.intercept;
  turn.upper = turn.slope * tree.upper[x] + turn.intercept;
  if (turn.slope < 0.0) std::swap(turn.lower, turn.upper);
}

TurnTriple make_triple(const std::vector<FreeTurn>& turns, int first) {
  TurnTriple triple;
  triple.turns = {first, first + 1, first + 2};
  const auto axis = [&](int i) { return turns[static_cast<std::size_t>(first + i)].axis; };
  const double C = axis(0).dot(axis(1)) * axis(1).dot(axis(2));
  triple.phi = std::atan2(axis(0).dot(axis(1).cross(axis(2))), axis(0).dot(axis(2)) - C);
  triple.has_line =
      std::abs(axis(0).dot(axis(1))) < kNormal && std::abs(axis(1).dot(axis(2))) < kNormal;
  return triple;
}

// Angle about `axis` that takes `from` to `to`.
double angle_about(const Vector3d& axis, const Vector3d& from, const Vector3d& to) {
  return std::atan2(axis.dot(from.cross(to)), from.dot(to) - axis.dot(from) * axis.dot(to));
}

// θ plus the whole turns that bring it nearest to `before` within the bounds; NaN if none does.
double nearest_turn(const FreeTurn& turn, double theta, double before) {
  const double k = std::round((before - theta) / kTurn);
  const double least = std::ceil((turn.lower - kBoundSlack - theta) / kTurn);
  const double most = std::floor((turn.upper + kBoundSlack - theta) / kTurn);
  if (!(least <= most)) return kNaN;
  return theta + kTurn * std::clamp(k, least, most);
}

}  // namespace

TurnChoices find_turn_choices(const MusculoskeletalModel& model, const KinematicTree& tree,
                              const IkProblem& problem) {
  const std::vector<bool> only = only_turning(model, tree, problem);
  TurnChoices choices;
  for (const Joint& joint : model.joints) {
    std::vector<FreeTurn> turns = turns_of(joint);
    const std::size_t count = turns.size();
    std::erase_if(turns, [&](const FreeTurn& turn) {
      return turn.coordinate < 0 || !only[static_cast<std::size_t>(turn.coordinate)];
    });
    const int first = static_cast<int>(choices.turns.size());
    for (FreeTurn& turn : turns) {
      set_bounds(tree, turn);
      choices.turns.push_back(turn);
    }
    const bool all = count == 3 && turns.size() == 3;
    if (all) choices.triples.push_back(make_triple(choices.turns, first));
    for (std::size_t i = 0; i < turns.size() && !all; ++i) {
      choices.single.push_back(first + static_cast<int>(i));
    }
  }
  return choices;
}

Vector3d other_triple(const TurnChoices& choices, const TurnTriple& triple, const Vector3d& theta) {
  const auto axis = [&](int i) -> const Vector3d& {
    return choices.turns[static_cast<std::size_t>(triple.turns[static_cast<std::size_t>(i)])].axis;
  };
  const double theta2 = 2.0 * triple.phi - theta[1];
  const Eigen::AngleAxisd R2(theta[1], axis(1)), R2_other(theta2, axis(1));
  // R(a₁,θ₁')R₂'a₃ = R(a₁,θ₁)R₂a₃ and R(a₃,−θ₃')R₂'ᵀa₁ = R(a₃,−θ₃)R₂ᵀa₁.
  return {theta[0] + angle_about(axis(0), R2_other * axis(2), R2 * axis(2)), theta2,
          theta[2] - angle_about(axis(2), R2_other.inverse() * axis(0), R2.inverse() * axis(0))};
}

namespace {

// Goes through the frames in order.
class Continuation {
 public:
  Continuation(const MusculoskeletalModel& model, const KinematicTree& tree,
               const TrackingProblem& tracking, const MarkerTrajectories& markers, int first,
               TrackingResult& result)
      : model_(model),
        tree_(tree),
        tracking_(tracking),
        markers_(markers),
        first_(first),
        result_(result),
        choices_(find_turn_choices(model, tree, tracking.problem)),
        has_task_(model.coordinates.size(), false),
        before_(choices_.turns.size()),
        workspace_(tree),
        targets_(tracking.problem) {
    for (const TrackedCoordinate& task : tracking.coordinates) {
      has_task_[static_cast<std::size_t>(task.coordinate)] = true;
    }
    for (std::size_t i = 0; i < before_.size(); ++i) {
      const FreeTurn& turn = choices_.turns[i];
      const auto c = static_cast<std::size_t>(turn.coordinate);
      const double q = tree.default_q[static_cast<std::size_t>(tree.q_of_coordinate[c])];
      before_[i] = turn.slope * q + turn.intercept;
    }
    double weights = 0.0;
    for (const TrackedMarker& marker : tracking.markers) weights += marker.weight;
    cost_noise_ = 0.5 * weights * kNoise * kNoise;
  }

  void run() {
    for (frame_ = 0; frame_ < static_cast<int>(result_.frames.size()); ++frame_) {
      has_targets_ = false;
      for (const int i : choices_.single) settle_single(i);
      for (const TurnTriple& triple : choices_.triples) settle_triple(triple);
      for (std::size_t i = 0; i < before_.size(); ++i) before_[i] = theta(static_cast<int>(i));
    }
  }

 private:
  const FreeTurn& turn(int i) const { return choices_.turns[static_cast<std::size_t>(i)]; }
  double before(int i) const { return before_[static_cast<std::size_t>(i)]; }
  double& value(int i) { return result_.coordinates(frame_, turn(i).coordinate); }
  double theta(int i) { return turn(i).slope * value(i) + turn(i).intercept; }
  double frame_cost() const { return result_.frames[static_cast<std::size_t>(frame_)].cost; }
  double same_cost() const { return kSameCost * std::max(frame_cost(), 0.0) + cost_noise_; }

  // Differences are added, so that what does not move keeps its bits.
  void move(int i, double difference) {
    if (difference != 0.0) value(i) += difference / turn(i).slope;
  }

  const IkTargets& targets() {
    if (!has_targets_) set_targets(tracking_, markers_, first_ + frame_, targets_);
    has_targets_ = true;
    return targets_;
  }

  // What tasks add to the cost if a turn goes on by `difference`.
  double task_cost(int i, double difference) {
    const int coordinate = turn(i).coordinate;
    if (difference == 0.0 || !has_task_[static_cast<std::size_t>(coordinate)]) return 0.0;
    const double step = difference / turn(i).slope;
    double added = 0.0;
    for (std::size_t k = 0; k < tracking_.coordinates.size(); ++k) {
      if (tracking_.coordinates[k].coordinate != coordinate) continue;
      const double off = value(i) - targets().coordinates[k];
      if (std::isnan(off)) continue;
      added += coordinate_weight(tracking_.problem, targets_, k) * step * (off + 0.5 * step);
    }
    return added;
  }

  void settle_single(int i) {
    if (std::abs(theta(i) - before(i)) <= kPi) return;
    const double nearest = nearest_turn(turn(i), theta(i), before(i));
    if (std::isnan(nearest)) return;
    const double difference = nearest - theta(i);
    if (std::abs(task_cost(i, difference)) <= same_cost()) move(i, difference);
  }

  // Distance of a triple to the frame before, each angle first turned as near as it can be; NaN
  // where that costs or a bound is in the way.
  double approach(const TurnTriple& triple, const Vector3d& from, Vector3d& to) {
    double extra = 0.0, distance = 0.0;
    for (int k = 0; k < 3; ++k) {
      const int i = triple.turns[static_cast<std::size_t>(k)];
      to[k] = nearest_turn(turn(i), to[k], before(i));
      if (std::isnan(to[k])) return kNaN;
      extra += task_cost(i, to[k] - from[k]);
      distance += (to[k] - before(i)) * (to[k] - before(i));
    }
    return std::abs(extra) <= same_cost() ? distance : kNaN;
  }

  void settle_triple(const TurnTriple& triple) {
    Vector3d now, was;
    for (int k = 0; k < 3; ++k) {
      now[k] = theta(triple.turns[static_cast<std::size_t>(k)]);
      was[k] = before(triple.turns[static_cast<std::size_t>(k)]);
    }
    if ((now - was).cwiseAbs().maxCoeff() > kWorthLooking) {
      double least = (now - was).squaredNorm();
      Vector3d best = now;
      for (Vector3d candidate : {now, other_triple(choices_, triple, now)}) {
        const double distance = approach(triple, now, candidate);
        if (!(distance < least - kNearer)) continue;
        least = distance;
        best = candidate;
      }
      for (int k = 0; k < 3; ++k) move(triple.turns[static_cast<std::size_t>(k)], best[k] - now[k]);
      now = best;
    }
    if (triple.has_line) settle_line(triple, now, was);
  }

  // At a pole θ₁ + t + 2πk, θ₃ − σt is the same orientation: the one nearest to the frame before.
  void settle_line(const TurnTriple& triple, const Vector3d& now, const Vector3d& was) {
    const double sine = std::abs(std::sin(now[1] - triple.phi));
    if (sine > kNearPole) return;
    const FreeTurn &first = turn(triple.turns[0]), &third = turn(triple.turns[2]);
    const double sigma = std::cos(now[1] - triple.phi) < 0.0 ? -1.0 : 1.0;
    const double d1 = was[0] - now[0], d3 = was[2] - now[2];
    double k = std::round((d1 + sigma * d3) / kTurn);
    // Bounds of t.
    double low = third.lower - now[2], high = third.upper - now[2];
    if (sigma > 0.0) std::tie(low, high) = std::pair(-high, -low);
    if (first.lower - now[0] - kTurn * k > high || first.upper - now[0] - kTurn * k < low) k = 0.0;
    low = std::max(low, first.lower - now[0] - kTurn * k);
    high = std::min(high, first.upper - now[0] - kTurn * k);
    if (!(low <= high)) return;
    const double t = std::clamp(0.5 * (d1 - kTurn * k - sigma * d3), low, high);
    if (std::abs(t) < kWorthLooking || std::abs(t) * sine > kLineTurn) return;
    slide(triple, t, sigma, k);
  }

  // Moves along the line as far as the cost stays equal. It has its minimum where the frame is, so
  // that it grows with the square of the way.
  void slide(const TurnTriple& triple, double t, double sigma, double k) {
    const Eigen::RowVectorXd from = result_.coordinates.row(frame_);
    for (int attempt = 0; attempt < 2; ++attempt) {
      move(triple.turns[0], t + kTurn * k);
      move(triple.turns[2], -sigma * t);
      const double excess = cost_here() - frame_cost();
      if (excess <= same_cost()) {
        measure_again();
        return;
      }
      result_.coordinates.row(frame_) = from;
      if (k != 0.0) return;
      t *= kShyOfEqual * std::sqrt(same_cost() / excess);
    }
  }

  double cost_here() {
    for (std::size_t c = 0; c < tree_.q_of_coordinate.size(); ++c) {
      workspace_.q[static_cast<std::size_t>(tree_.q_of_coordinate[c])] =
          result_.coordinates(frame_, static_cast<Eigen::Index>(c));
    }
    update_poses(tree_, workspace_);
    return cost(tree_, tracking_.problem, targets(), workspace_);
  }

  void measure_again() {
    const RowMatrix q = result_.coordinates.row(frame_);
    const TrackingResult now =
        evaluate_coordinates(model_, tree_, tracking_, markers_, first_ + frame_, q);
    FrameResult& frame = result_.frames[static_cast<std::size_t>(frame_)];
    frame.cost = now.frames[0].cost;
    frame.marker_rms = now.frames[0].marker_rms;
    frame.marker_max = now.frames[0].marker_max;
    frame.worst_marker = now.frames[0].worst_marker;
    result_.marker_errors.row(frame_) = now.marker_errors.row(0);
    result_.wire_lengths.row(frame_) = now.wire_lengths.row(0);
    result_.furcations.row(frame_) = now.furcations.row(0);
  }

  const MusculoskeletalModel& model_;
  const KinematicTree& tree_;
  const TrackingProblem& tracking_;
  const MarkerTrajectories& markers_;
  const int first_;
  TrackingResult& result_;
  const TurnChoices choices_;
  std::vector<bool> has_task_;  // coordinates
  std::vector<double> before_;  // turns: θ of the frame before
  KinematicWorkspace workspace_;
  IkTargets targets_;
  double cost_noise_ = 0.0;
  int frame_ = 0;
  bool has_targets_ = false;
};

}  // namespace

void make_continuous(const MusculoskeletalModel& model, const KinematicTree& tree,
                     const TrackingProblem& tracking, const MarkerTrajectories& markers,
                     int first_frame, TrackingResult& result) {
  Continuation(model, tree, tracking, markers, first_frame, result).run();
}

}  // namespace sinew
