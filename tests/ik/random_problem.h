#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "ik/residuals.h"
#include "tests/model/random_model.h"

/// Random problems on random models: residuals of every kind with full weights, on every link, with
/// a few of them not measured. The same seed gives the same problem.
namespace sinew {

enum class ResidualKind {
  kPosition,
  kOrientation,
  kDistance,
  kWire,
  kCoordinate,
  kCoincidence,
  kAlignment,
  kAll
};

inline constexpr ResidualKind kResidualKinds[] = {
    ResidualKind::kPosition,  ResidualKind::kOrientation, ResidualKind::kDistance,
    ResidualKind::kWire,      ResidualKind::kCoordinate,  ResidualKind::kCoincidence,
    ResidualKind::kAlignment, ResidualKind::kAll};

class RandomValues {
 public:
  explicit RandomValues(unsigned seed) : random_(seed) {}
  double uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }
  int integer(int low, int high) { return std::uniform_int_distribution<int>(low, high)(random_); }
  Eigen::Vector3d vector(double size) {
    return {uniform(-size, size), uniform(-size, size), uniform(-size, size)};
  }
  Eigen::Matrix3d rotation(double largest_angle) {
    return Eigen::AngleAxisd(uniform(0.0, largest_angle), vector(1.0).normalized())
        .toRotationMatrix();
  }
  // Positive definite, its axes turned anywhere.
  Eigen::Matrix3d weight() {
    const Eigen::Matrix3d R = rotation(3.0);
    const Eigen::Vector3d d(uniform(0.2, 1.0), uniform(1.0, 3.0), uniform(3.0, 5.0));
    const Eigen::Matrix3d W = R * d.asDiagonal() * R.transpose();
    return 0.5 * (W + W.transpose());
  }

 private:
  std::mt19937 random_;
};

struct RandomProblem {
  MusculoskeletalModel model;
  KinematicTree tree;
  std::vector<double> q;  // where to evaluate
  IkProblem problem;
  IkTargets targets{IkProblem{}};

  // Kinematics of q.
  KinematicWorkspace workspace() const {
    KinematicWorkspace ws(tree);
    ws.q = q;
    update_kinematics(tree, ws);
    return ws;
  }
};

// A pose away from the default one, stepped on the manifold.
inline std::vector<double> random_q(const KinematicTree& tree, RandomValues& values, double size) {
  std::vector<double> step(static_cast<std::size_t>(tree.unknown_count()));
  for (double& each : step) each = values.uniform(-size, size);
  std::vector<double> q = tree.default_q;
  advance(tree, tree.default_q, step, q);
  return q;
}

inline void add_random_points(RandomProblem& p, RandomValues& values) {
  const auto link = [&] { return values.integer(0, p.tree.link_count() - 1); };
  for (int i = 0; i < 20; ++i) {
    p.problem.positions.push_back({link(), values.vector(0.4), values.weight()});
    p.targets.positions.push_back(i == 3 ? Eigen::Vector3d::Constant(kNaN) : values.vector(2.0));
  }
  for (int i = 0; i < 24; ++i) {
    p.problem.distances.push_back(
        {link(), link(), values.vector(0.4), values.vector(0.4), values.uniform(0.1, 9.0)});
    p.targets.distances.push_back(i == 4 ? kNaN : values.uniform(0.0, 2.0));
  }
  for (int i = 0; i < 5; ++i) {
    p.problem.coincidences.push_back(
        {link(), link(), values.vector(0.4), values.vector(0.4), values.uniform(0.1, 9.0)});
  }
}

// Polylines of two to five points, some on the path only in a range of a coordinate; two thirds of
// them taut.
inline void add_random_wires(RandomProblem& p, RandomValues& values) {
  const KinematicWorkspace ws = p.workspace();
  for (int i = 0; i < 24; ++i) {
    WireResidual wire;
    wire.first_point = static_cast<int>(p.problem.wire_points.size());
    wire.point_count = values.integer(2, 5);
    for (int k = 0; k < wire.point_count; ++k) {
      WirePoint point{values.integer(0, p.tree.link_count() - 1), values.vector(0.4)};
      if (k > 0 && k + 1 < wire.point_count && values.integer(0, 1) == 1) {
        point.condition_q = values.integer(0, p.tree.q_count() - 1);
        const double q = p.q[static_cast<std::size_t>(point.condition_q)];
        const double shift = values.integer(0, 1) == 1 ? 0.1 : 3.0;  // on the path or off it
        point.condition_min = q - 1.0 + shift;
        point.condition_max = q + 1.0 + shift;
      }
      p.problem.wire_points.push_back(point);
    }
    wire.natural_length = values.uniform(0.5, 1.25) * wire_length(p.problem, wire, ws);
    wire.weight = values.uniform(0.1, 9.0);
    p.problem.wires.push_back(wire);
  }
}

// Orientations up to 2.6 rad off, clear of the half turn where the rotation vector jumps.
inline void add_random_frames(RandomProblem& p, RandomValues& values) {
  const KinematicWorkspace ws = p.workspace();
  const auto R_WB = [&](int link) { return ws.X_WB[static_cast<std::size_t>(link)].R; };
  for (int i = 0; i < 10; ++i) {
    const int link = values.integer(0, p.tree.link_count() - 1);
    p.problem.orientations.push_back({link, values.rotation(3.0), values.weight()});
    const Eigen::Matrix3d R_WF = R_WB(link) * p.problem.orientations.back().R_BF;
    p.targets.orientations.push_back(i == 2 ? Eigen::Matrix3d::Constant(kNaN)
                                            : Eigen::Matrix3d(values.rotation(2.6) * R_WF));
  }
  for (int i = 0; i < 5; ++i) {
    const int a = values.integer(0, p.tree.link_count() - 1);
    const int b = values.integer(0, p.tree.link_count() - 1);
    const Eigen::Matrix3d R_AF = values.rotation(3.0);
    const Eigen::Matrix3d R_BG = R_WB(b).transpose() * values.rotation(2.6) * R_WB(a) * R_AF;
    p.problem.alignments.push_back({a, b, R_AF, R_BG, values.uniform(0.1, 9.0)});
  }
}

// On every coordinate that has a q of its own: free, dependent and locked ones.
inline void add_random_coordinate_targets(RandomProblem& p, RandomValues& values) {
  for (std::size_t c = 0; c < p.model.coordinates.size(); ++c) {
    const int q = p.tree.q_of_coordinate[c];
    if (q < 0) continue;
    p.problem.coordinates.push_back({q, p.tree.v_of_coordinate[c], values.uniform(0.1, 5.0)});
    p.targets.coordinates.push_back(c == 5 ? kNaN : values.uniform(-1.0, 1.0));
    p.targets.coordinate_scales.push_back(0.25 * static_cast<double>(1 + c % 5));
  }
}

inline RandomProblem random_problem(unsigned seed, bool quaternions) {
  RandomProblem p;
  p.model = random_model(seed, {.for_quaternions = quaternions});
  p.tree = compile_tree(p.model, {.quaternions = quaternions});
  RandomValues values(seed + 1000);
  p.q = random_q(p.tree, values, 0.8);
  add_random_points(p, values);
  add_random_wires(p, values);
  add_random_frames(p, values);
  add_random_coordinate_targets(p, values);
  validate(p.tree, p.problem, p.targets);
  return p;
}

// Residuals of one kind only.
inline RandomProblem only(RandomProblem p, ResidualKind kind) {
  using enum ResidualKind;
  if (kind == kAll) return p;
  const auto clear = [](auto& residuals, auto& targets) {
    residuals.clear();
    targets.clear();
  };
  if (kind != kPosition) clear(p.problem.positions, p.targets.positions);
  if (kind != kOrientation) clear(p.problem.orientations, p.targets.orientations);
  if (kind != kCoordinate) {
    clear(p.problem.coordinates, p.targets.coordinates);
    p.targets.coordinate_scales.clear();
  }
  if (kind != kCoincidence) p.problem.coincidences.clear();
  if (kind != kAlignment) p.problem.alignments.clear();
  if (kind != kDistance) clear(p.problem.distances, p.targets.distances);
  if (kind != kWire) p.problem.wires.clear();
  return p;
}

}  // namespace sinew
