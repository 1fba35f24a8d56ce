#include "ik/curvature.h"

#include <algorithm>
#include <cmath>

#include "ik/stiffness.h"

namespace sinew {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

}  // namespace

GaussNewtonCurvature::GaussNewtonCurvature(const KinematicTree& tree)
    : K_(tree.links.size(), Matrix6d::Zero()),
      H_v_(tree.v_count(), tree.v_count()),
      diagonal_v_(tree.v_count()),
      row_(tree.unknown_count()) {}

void GaussNewtonCurvature::update(const KinematicTree& tree, const IkProblem& problem,
                                  const IkTargets& targets, const KinematicWorkspace& ws) {
  std::fill(K_.begin(), K_.end(), Matrix6d::Zero());
  for (std::size_t i = 0; i < problem.positions.size(); ++i) {
    if (std::isnan(targets.positions[i].x())) continue;
    const PositionResidual& r = problem.positions[i];
    const auto link = static_cast<std::size_t>(r.link);
    add_point_stiffness(K_[link], ws.X_WB[link].R * r.p_BP, r.weight);
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
    if (parent == 0) continue;
    add_shifted_stiffness(K_[parent], K_[b], ws.X_WB[b].p - ws.X_WB[parent].p);
  }
}

void GaussNewtonCurvature::diagonal(const KinematicTree& tree, const IkProblem& problem,
                                    const IkTargets& targets, const KinematicWorkspace& ws,
                                    Eigen::Ref<Eigen::VectorXd> diagonal) {
  for (int v = 0; v < tree.v_count(); ++v) {
    const auto i = static_cast<std::size_t>(v);
    const Vector6d& S = ws.S[i];
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
  for_each_pair_row(tree, problem, targets, ws,
                    [&](double weight) { diagonal.array() += weight * row_.array().square(); });
}

void GaussNewtonCurvature::matrix(const KinematicTree& tree, const IkProblem& problem,
                                  const IkTargets& targets, const KinematicWorkspace& ws,
                                  Eigen::MatrixXd& H) {
  H_v_.setZero();
  for (int v = 0; v < tree.v_count(); ++v) {
    int b = tree.link_of_v[static_cast<std::size_t>(v)];
    Vector6d F = K_[static_cast<std::size_t>(b)] * ws.S[static_cast<std::size_t>(v)];
    while (b > 0) {
      const KinematicTree::Link& link = tree.links[static_cast<std::size_t>(b)];
      const int last = std::min(v, link.first_v + link.v_count - 1);
      for (int u = link.first_v; u <= last; ++u) {
        H_v_(u, v) = H_v_(v, u) = ws.S[static_cast<std::size_t>(u)].dot(F);
      }
      const Vector3d r =
          ws.X_WB[static_cast<std::size_t>(b)].p - ws.X_WB[static_cast<std::size_t>(link.parent)].p;
      F.head<3>() += r.cross(F.tail<3>());
      b = link.parent;
    }
  }
  for (std::size_t i = 0; i < problem.coordinates.size(); ++i) {
    if (std::isnan(targets.coordinates[i])) continue;
    H_v_(problem.coordinates[i].v, problem.coordinates[i].v) += problem.coordinates[i].weight;
  }
  for (std::size_t i = tree.couplings.size(); i-- > 0;) {  // TᵀHT, one coupling at a time
    const int from = tree.couplings[i].independent_v, to = tree.couplings[i].dependent_v;
    const double slope = ws.coupling_slope[i];
    H_v_.row(from) += slope * H_v_.row(to);
    H_v_.col(from) += slope * H_v_.col(to);
  }
  for (int i = 0; i < tree.unknown_count(); ++i) {
    for (int j = 0; j < tree.unknown_count(); ++j) {
      H(i, j) = H_v_(tree.unknown_v[static_cast<std::size_t>(i)],
                     tree.unknown_v[static_cast<std::size_t>(j)]);
    }
  }
  for_each_pair_row(tree, problem, targets, ws, [&](double weight) {
    H.selfadjointView<Eigen::Lower>().rankUpdate(row_, weight);
  });
  H.triangularView<Eigen::StrictlyUpper>() = H.transpose();
}

void GaussNewtonCurvature::add_point_row(const KinematicTree& tree, const KinematicWorkspace& ws,
                                         int link, const Vector3d& p_W, const Vector3d& direction) {
  for_each_mover(tree, ws, link, [&](int x, int b, const Vector6d& S, double scale) {
    const Vector3d r = p_W - ws.X_WB[static_cast<std::size_t>(b)].p;
    row_[x] += scale * direction.dot(S.tail<3>() + S.head<3>().cross(r));
  });
}

void GaussNewtonCurvature::add_turn_row(const KinematicTree& tree, const KinematicWorkspace& ws,
                                        int link, const Vector3d& direction) {
  for_each_mover(tree, ws, link, [&](int x, int, const Vector6d& S, double scale) {
    row_[x] += scale * direction.dot(S.head<3>());
  });
}

template <typename Use>
void GaussNewtonCurvature::for_each_pair_row(const KinematicTree& tree, const IkProblem& problem,
                                             const IkTargets& targets, const KinematicWorkspace& ws,
                                             const Use& use) {
  const auto use_points = [&](int link_a, int link_b, const Vector3d& pa, const Vector3d& pb,
                              const Vector3d& direction, double weight) {
    row_.setZero();
    add_point_row(tree, ws, link_a, pa, direction);
    add_point_row(tree, ws, link_b, pb, -direction);
    use(weight);
  };
  for (std::size_t i = 0; i < problem.distances.size(); ++i) {
    if (std::isnan(targets.distances[i])) continue;
    const DistanceResidual& r = problem.distances[i];
    const Vector3d pa = ws.X_WB[static_cast<std::size_t>(r.link_a)] * r.p_AP;
    const Vector3d pb = ws.X_WB[static_cast<std::size_t>(r.link_b)] * r.p_BQ;
    const double length = (pa - pb).norm();
    if (length == 0.0 || (r.one_sided && length <= targets.distances[i])) continue;
    use_points(r.link_a, r.link_b, pa, pb, (pa - pb) / length, r.weight);
  }
  for (const CoincidenceResidual& r : problem.coincidences) {
    const Vector3d pa = ws.X_WB[static_cast<std::size_t>(r.link_a)] * r.p_AP;
    const Vector3d pb = ws.X_WB[static_cast<std::size_t>(r.link_b)] * r.p_BQ;
    for (int axis = 0; axis < 3; ++axis) {
      use_points(r.link_a, r.link_b, pa, pb, Vector3d::Unit(axis), r.weight);
    }
  }
  for (const AlignmentResidual& r : problem.alignments) {
    for (int axis = 0; axis < 3; ++axis) {  // γ ≈ 0 on a closed loop, so K_γ ≈ E
      row_.setZero();
      add_turn_row(tree, ws, r.link_a, Vector3d::Unit(axis));
      add_turn_row(tree, ws, r.link_b, -Vector3d::Unit(axis));
      use(r.weight);
    }
  }
}

}  // namespace sinew
