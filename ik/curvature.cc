#include "ik/curvature.h"

#include <algorithm>
#include <cmath>

#include "ik/stiffness.h"

namespace sinew {

using Eigen::Matrix3d;
using Eigen::Vector3d;

GaussNewtonCurvature::GaussNewtonCurvature(const KinematicTree& tree, const IkProblem& problem)
    : K_(tree.links.size(), Matrix6d::Zero()), rows_(tree, problem), diagonal_v_(tree.v_count()) {}

void GaussNewtonCurvature::update(const KinematicTree& tree, const IkProblem& problem,
                                  const IkTargets& targets, const KinematicWorkspace& ws) {
  rows_.update(tree, ws);
  std::fill(K_.begin(), K_.end(), Matrix6d::Zero());
  for (std::size_t i = 0; i < problem.positions.size(); ++i) {
    if (std::isnan(targets.positions[i].x())) continue;
    const PositionResidual& r = problem.positions[i];
    const auto link = static_cast<std::size_t>(r.link);
    add_point_stiffness(K_[link], ws.X_WB[link] * r.p_BP - rows_.origin(),
                        position_weight(problem, targets, i));
  }
  for (std::size_t i = 0; i < problem.orientations.size(); ++i) {
    if (std::isnan(targets.orientations[i](0, 0))) continue;
    const OrientationResidual& r = problem.orientations[i];
    const auto link = static_cast<std::size_t>(r.link);
    const Matrix3d R_WF = ws.X_WB[link].R * r.R_BF;
    const Matrix3d rate =
        rotation_vector_rate(rotation_vector(targets.orientations[i] * R_WF.transpose()));
    K_[link].topLeftCorner<3, 3>() += rate.transpose() * r.weight * rate;
  }
  for (std::size_t b = tree.links.size() - 1; b > 0; --b) {
    const auto parent = static_cast<std::size_t>(tree.links[b].parent);
    if (parent > 0) K_[parent] += K_[b];
  }
}

void GaussNewtonCurvature::diagonal(const KinematicTree& tree, const IkProblem& problem,
                                    const IkTargets& targets, const KinematicWorkspace& ws,
                                    Eigen::Ref<Eigen::VectorXd> diagonal) {
  for (int v = 0; v < tree.v_count(); ++v) {
    const auto i = static_cast<std::size_t>(v);
    const Vector6d& S = rows_.twists()[i];
    diagonal_v_[v] = std::max(0.0, S.dot(K_[static_cast<std::size_t>(tree.link_of_v[i])] * S));
  }
  for (std::size_t i = 0; i < problem.coordinates.size(); ++i) {
    if (std::isnan(targets.coordinates[i])) continue;
    diagonal_v_[problem.coordinates[i].v] += problem.coordinates[i].weight;
  }
  for (std::size_t i = tree.couplings.size(); i-- > 0;) {  // Cauchy-Schwarz
    double& from = diagonal_v_[tree.couplings[i].independent_v];
    const double root = std::sqrt(from) + std::abs(ws.coupling_slope[i]) *
                                              std::sqrt(diagonal_v_[tree.couplings[i].dependent_v]);
    from = root * root;
  }
  for (int x = 0; x < tree.unknown_count(); ++x) {
    diagonal[x] = diagonal_v_[tree.unknown_v[static_cast<std::size_t>(x)]];
  }
  rows_.for_each(problem, targets, ws,
                 [&](std::span<const int> unknowns, std::span<const double> row, double weight) {
                   for (std::size_t i = 0; i < row.size(); ++i)
                     diagonal[unknowns[i]] += weight * row[i] * row[i];
                 });
}

void GaussNewtonCurvature::matrix(const KinematicTree& tree, const IkProblem& problem,
                                  const IkTargets& targets, const KinematicWorkspace& ws,
                                  Eigen::MatrixXd& H) {
  H.setZero();
  add_reversed(tree, problem, targets, ws, H);
  H.reverseInPlace();
  H.triangularView<Eigen::StrictlyLower>() = H.transpose();
}

// Sᵀ K S of every v with itself and with those of the joints on the way to the root.
void GaussNewtonCurvature::add_composite(const KinematicTree& tree, Eigen::MatrixXd& R) const {
  const auto last = static_cast<int>(R.rows()) - 1;
  const std::vector<Vector6d>& S = rows_.twists();
  for (std::size_t b = 1; b < tree.links.size(); ++b) {
    if (K_[b].isZero(0.0)) continue;
    const KinematicTree::Link& own = tree.links[b];
    for (int v = own.first_v; v < own.first_v + own.v_count; ++v) {
      const int x = rows_.driver(v);
      if (x < 0) continue;
      const Vector6d F = rows_.driver_slope(v) * (K_[b] * S[static_cast<std::size_t>(v)]);
      for (auto a = static_cast<int>(b); a > 0;
           a = tree.links[static_cast<std::size_t>(a)].parent) {
        const KinematicTree::Link& link = tree.links[static_cast<std::size_t>(a)];
        const int end = std::min(v + 1, link.first_v + link.v_count);
        for (int u = link.first_v; u < end; ++u) {
          const int y = rows_.driver(u);
          if (y < 0) continue;
          const double h = rows_.driver_slope(u) * S[static_cast<std::size_t>(u)].dot(F);
          // One unknown may drive both: then both (u, v) and (v, u) fall on its diagonal.
          R(last - std::min(x, y), last - std::max(x, y)) += x == y && u != v ? 2.0 * h : h;
        }
      }
    }
  }
}

void GaussNewtonCurvature::add_reversed(const KinematicTree& tree, const IkProblem& problem,
                                        const IkTargets& targets, const KinematicWorkspace& ws,
                                        Eigen::MatrixXd& R) {
  const auto last = static_cast<int>(R.rows()) - 1;
  add_composite(tree, R);
  for (std::size_t i = 0; i < problem.coordinates.size(); ++i) {
    if (std::isnan(targets.coordinates[i])) continue;
    const int x = rows_.driver(problem.coordinates[i].v);
    const double slope = rows_.driver_slope(problem.coordinates[i].v);
    if (x >= 0) R(last - x, last - x) += problem.coordinates[i].weight * slope * slope;
  }
  rows_.for_each(problem, targets, ws,
                 [&](std::span<const int> unknowns, std::span<const double> row, double weight) {
                   for (std::size_t j = row.size(); j-- > 0;) {
                     const double scaled = weight * row[j];
                     if (scaled == 0.0) continue;
                     double* const column = R.col(last - unknowns[j]).data() + last;
                     for (std::size_t i = 0; i <= j; ++i) column[-unknowns[i]] += scaled * row[i];
                   }
                 });
}

std::vector<std::vector<int>> GaussNewtonCurvature::reversed_cliques(
    const KinematicTree& tree, const IkProblem& problem) const {
  const int last = tree.unknown_count() - 1;
  std::vector<char> seen(tree.links.size(), 0);  // from the world, by a residual of its subtree
  for (const PositionResidual& r : problem.positions) seen[static_cast<std::size_t>(r.link)] = 1;
  for (const OrientationResidual& r : problem.orientations) {
    seen[static_cast<std::size_t>(r.link)] = 1;
  }
  std::vector<std::vector<int>> cliques;
  for (std::size_t b = 1; b < tree.links.size(); ++b) {
    if (!seen[b]) continue;
    std::vector<int> clique;
    for (auto a = static_cast<int>(b); a > 0; a = tree.links[static_cast<std::size_t>(a)].parent) {
      const KinematicTree::Link& link = tree.links[static_cast<std::size_t>(a)];
      for (int v = link.first_v; v < link.first_v + link.v_count; ++v) {
        if (rows_.driver(v) >= 0) clique.push_back(last - rows_.driver(v));
      }
    }
    cliques.push_back(std::move(clique));
  }
  for (int i = 0; i < rows_.support_count(); ++i) {
    std::vector<int> clique;
    for (const int x : rows_.support(i)) clique.push_back(last - x);
    cliques.push_back(std::move(clique));
  }
  return cliques;
}

}  // namespace sinew
