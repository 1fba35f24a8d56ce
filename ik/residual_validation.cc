#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "ik/residuals.h"

namespace sinew {
namespace {

using Eigen::Matrix3d;

[[noreturn]] void reject(const char* kind, std::size_t i, const std::string& problem) {
  throw std::invalid_argument(fmt::format("{} residual {} {}", kind, i, problem));
}

void check_link(const KinematicTree& tree, const char* kind, std::size_t i, int link) {
  if (link < 0 || link >= tree.link_count()) {
    reject(kind, i, fmt::format("is on link {}; expected 0 to {}", link, tree.link_count() - 1));
  }
}

void check_coordinate(const KinematicTree& tree, std::size_t i, const CoordinateResidual& r) {
  if (r.v < 0 || r.v >= tree.v_count() || r.q < 0 ||
      tree.q_of_v[static_cast<std::size_t>(r.v)] != r.q) {
    reject("coordinate", i,
           fmt::format("is on coordinate {} with direction {}; expected one of the tree's own", r.q,
                       r.v));
  }
}

void check_weight(const char* kind, std::size_t i, double weight) {
  if (!std::isfinite(weight) || weight < 0.0) {
    reject(kind, i, fmt::format("has weight {}; expected a finite number, 0 or more", weight));
  }
}

void check_weight(const char* kind, std::size_t i, const Matrix3d& weight) {
  if (!weight.allFinite() || !weight.isApprox(weight.transpose(), 1e-12) ||
      Eigen::SelfAdjointEigenSolver<Matrix3d>(weight).eigenvalues().minCoeff() <
          -1e-12 * weight.norm()) {
    reject(kind, i,
           "has an unusable weight; expected a symmetric matrix without negative eigenvalues");
  }
}

void check_wire(const KinematicTree& tree, const IkProblem& problem, std::size_t i) {
  const WireResidual& wire = problem.wires[i];
  check_weight("wire", i, wire.weight);
  if (!std::isfinite(wire.natural_length) || wire.natural_length < 0.0) {
    reject("wire", i,
           fmt::format("has natural length {}; expected a finite number, 0 or more",
                       wire.natural_length));
  }
  const auto end = static_cast<std::size_t>(wire.first_point) +
                   static_cast<std::size_t>(std::max(wire.point_count, 0));
  if (wire.first_point < 0 || wire.point_count < 2 || end > problem.wire_points.size()) {
    reject("wire", i,
           fmt::format("has points {} to {} of {}; expected two or more of them", wire.first_point,
                       wire.first_point + wire.point_count - 1, problem.wire_points.size()));
  }
  for (auto k = static_cast<std::size_t>(wire.first_point); k < end; ++k) {
    const WirePoint& point = problem.wire_points[k];
    check_link(tree, "wire", i, point.link);
    if (point.condition_q < -1 || point.condition_q >= tree.q_count()) {
      reject("wire", i,
             fmt::format("has a point with a condition on q {}; expected -1 to {}",
                         point.condition_q, tree.q_count() - 1));
    }
    const bool at_an_end = k == static_cast<std::size_t>(wire.first_point) || k + 1 == end;
    if (at_an_end && point.condition_q >= 0) {
      reject("wire", i, "has a condition on its first or last point; expected it in between");
    }
  }
}

void check_size(const char* kind, std::size_t residuals, std::size_t targets) {
  if (residuals != targets) {
    throw std::invalid_argument(
        fmt::format("{} {} residuals have {} targets; expected as many", residuals, kind, targets));
  }
}

}  // namespace

void validate(const KinematicTree& tree, const IkProblem& problem, const IkTargets& targets) {
  check_size("position", problem.positions.size(), targets.positions.size());
  if (!targets.position_scales.empty()) {
    check_size("position", problem.positions.size(), targets.position_scales.size());
  }
  check_size("orientation", problem.orientations.size(), targets.orientations.size());
  check_size("distance", problem.distances.size(), targets.distances.size());
  check_size("coordinate", problem.coordinates.size(), targets.coordinates.size());
  if (!targets.coordinate_scales.empty()) {
    check_size("coordinate", problem.coordinates.size(), targets.coordinate_scales.size());
  }
  for (std::size_t i = 0; i < problem.positions.size(); ++i) {
    check_link(tree, "position", i, problem.positions[i].link);
    check_weight("position", i, problem.positions[i].weight);
    check_weight("position", i, position_scale(targets, i));
  }
  for (std::size_t i = 0; i < problem.orientations.size(); ++i) {
    check_link(tree, "orientation", i, problem.orientations[i].link);
    check_weight("orientation", i, problem.orientations[i].weight);
  }
  for (std::size_t i = 0; i < problem.distances.size(); ++i) {
    check_link(tree, "distance", i, problem.distances[i].link_a);
    check_link(tree, "distance", i, problem.distances[i].link_b);
    check_weight("distance", i, problem.distances[i].weight);
  }
  for (std::size_t i = 0; i < problem.wires.size(); ++i) check_wire(tree, problem, i);
  for (std::size_t i = 0; i < problem.coordinates.size(); ++i) {
    check_coordinate(tree, i, problem.coordinates[i]);
    check_weight("coordinate", i, problem.coordinates[i].weight);
    check_weight("coordinate", i, coordinate_weight(problem, targets, i));
  }
  for (std::size_t i = 0; i < problem.coincidences.size(); ++i) {
    check_link(tree, "coincidence", i, problem.coincidences[i].link_a);
    check_link(tree, "coincidence", i, problem.coincidences[i].link_b);
    check_weight("coincidence", i, problem.coincidences[i].weight);
  }
  for (std::size_t i = 0; i < problem.alignments.size(); ++i) {
    check_link(tree, "alignment", i, problem.alignments[i].link_a);
    check_link(tree, "alignment", i, problem.alignments[i].link_b);
    check_weight("alignment", i, problem.alignments[i].weight);
  }
}

}  // namespace sinew
