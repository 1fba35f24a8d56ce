#pragma once

#include <random>
#include <vector>

#include "ik/residuals.h"
#include "tests/ik/small_model.h"

namespace sinew {

/// A small body that stands for a gait model: a free root, two branches, joints of several kinds, a
/// coupled coordinate, a locked one, four markers on every body but the last, which no marker sees.
struct Walker {
  MusculoskeletalModel model = empty_model();
  KinematicTree tree;
  IkProblem problem;
  int unseen = -1;     // coordinate of the last body
  int locked = -1;     // coordinate
  int dependent = -1;  // coordinate

  explicit Walker(bool quaternions = false) {
    using Kind = Joint::Kind;
    const int pelvis = add_body(model, 0, Kind::kFree, "rrrttt", {0, 1, 0});
    const int trunk = add_body(model, pelvis, Kind::kBall, "rrr", {0, 0.2, 0});
    const int arm = add_body(model, trunk, Kind::kUniversal, "rr", {0, 0.4, 0.2});
    add_body(model, arm, Kind::kPin, "r", {0, -0.3, 0});
    const int thigh = add_body(model, pelvis, Kind::kGimbal, "rrr", {0, -0.1, 0.1});
    const int shank = add_body(model, thigh, Kind::kPin, "r", {0, -0.4, 0});
    const int patella = add_body(model, thigh, Kind::kPin, "r", {0.05, -0.4, 0});
    dependent = coordinate_of(patella);
    const int foot = add_body(model, shank, Kind::kPin, "r", {0, -0.4, 0});
    locked = coordinate_of(add_body(model, foot, Kind::kPin, "r", {0.1, 0, 0}));
    model.coordinates[static_cast<std::size_t>(locked)].locked = true;
    model.coordinates[static_cast<std::size_t>(locked)].default_value = 0.2;
    unseen = coordinate_of(add_body(model, trunk, Kind::kPin, "r", {0, 0.5, 0}));
    CoordinateCoupler& coupler = model.couplers.emplace_back();
    coupler.name = "patella";
    coupler.dependent = dependent;
    coupler.independent = coordinate_of(shank);
    coupler.function = {PolynomialFunction{{0.2, 0.5, 0.1}}};
    add_markers();
    compile(quaternions);
  }

  // Of the only coordinate of a body's joint.
  int coordinate_of(int body) const {
    return model.joints[static_cast<std::size_t>(body) - 1].coordinates[0];
  }

  void compile(bool quaternions = false) {
    validate(model);
    tree = compile_tree(model, {.quaternions = quaternions});
    problem = {};
    for (const Marker& m : model.markers) problem.positions.push_back({m.body, m.p_BM});
  }

  // A pose that many steps away from the default one, clipped by the bounds.
  std::vector<double> pose(unsigned seed, double size) const {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> value(-size, size);
    std::vector<double> step(static_cast<std::size_t>(tree.unknown_count()));
    for (double& each : step) each = value(random);
    std::vector<double> q = tree.default_q;
    advance(tree, tree.default_q, step, q);
    return q;
  }

  // Where the markers are at q.
  IkTargets targets_at(const std::vector<double>& q) const {
    KinematicWorkspace ws(tree);
    ws.q = q;
    update_poses(tree, ws);
    IkTargets targets(problem);
    for (std::size_t i = 0; i < problem.positions.size(); ++i) {
      const PositionResidual& r = problem.positions[i];
      targets.positions[i] = ws.X_WB[static_cast<std::size_t>(r.link)] * r.p_BP;
    }
    return targets;
  }

  double& value(std::vector<double>& q, int coordinate) const {
    return q[static_cast<std::size_t>(tree.q_of_coordinate[static_cast<std::size_t>(coordinate)])];
  }

 private:
  void add_markers() {
    const Eigen::Vector3d places[] = {
        {0.1, 0.05, 0.0}, {-0.1, 0.05, 0.05}, {0.0, -0.1, 0.1}, {0.05, 0.1, -0.1}};
    for (std::size_t b = 1; b + 1 < model.bodies.size(); ++b) {
      for (const Eigen::Vector3d& place : places) {
        Marker& marker = model.markers.emplace_back();
        marker.name = "m" + std::to_string(model.markers.size());
        marker.body = static_cast<int>(b);
        marker.p_BM = place;
      }
    }
  }
};

}  // namespace sinew
