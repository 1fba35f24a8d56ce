#include "ik/curvature.h"

#include <algorithm>
#include <cmath>

#include "ik/stiffness.h"

namespace sinew {

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

// What turning a load f at r does: see CostCurvature.
void add_turning(Matrix6d& K, const Vector3d& r, const Vector3d& f) {
  K.topLeftCorner<3, 3>() += turned_load(r, f);
  K.topRightCorner<3, 3>() -= skew(f);
}

}  // namespace

void add_link_stiffness(const IkProblem& problem, const IkTargets& targets,
                        const KinematicWorkspace& ws, const Vector3d& origin, bool newton,
                        std::vector<Matrix6d>& K) {
  for (std::size_t i = 0; i < problem.positions.size(); ++i) {
    if (std::isnan(targets.positions[i].x())) continue;
    const PositionResidual& r = problem.positions[i];
    const auto link = static_cast<std::size_t>(r.link);
    const Vector3d arm = ws.X_WB[link] * r.p_BP - origin;
    if (is_isotropic(r.weight)) {
      const double weight = position_scale(targets, i) * r.weight(0, 0);
      add_point_stiffness(K[link], arm, weight);
      if (newton) add_turning(K[link], arm, weight * (arm + origin - targets.positions[i]));
    } else {
      const Matrix3d weight = position_weight(problem, targets, i);
      add_point_stiffness(K[link], arm, weight);
      if (newton) add_turning(K[link], arm, weight * (arm + origin - targets.positions[i]));
    }
  }
  for (std::size_t i = 0; i < problem.orientations.size(); ++i) {
    if (std::isnan(targets.orientations[i](0, 0))) continue;
    const OrientationResidual& r = problem.orientations[i];
    const auto link = static_cast<std::size_t>(r.link);
    const Matrix3d R_WF = ws.X_WB[link].R * r.R_BF;
    const Vector3d gamma = rotation_vector(targets.orientations[i] * R_WF.transpose());
    const Matrix3d rate = rotation_vector_rate(gamma);
    if (newton && is_isotropic(r.weight)) {
      K[link].topLeftCorner<3, 3>() += orientation_curvature(r.weight(0, 0), gamma);
    } else {
      K[link].topLeftCorner<3, 3>() += rate.transpose() * r.weight * rate;
    }
    if (newton) K[link].topLeftCorner<3, 3>() += 0.5 * skew(rate.transpose() * r.weight * gamma);
  }
}

std::vector<char> seen_from_the_world(const KinematicTree& tree, const IkProblem& problem) {
  std::vector<char> seen(tree.links.size(), 0);
  for (const PositionResidual& r : problem.positions) seen[static_cast<std::size_t>(r.link)] = 1;
  for (const OrientationResidual& r : problem.orientations) {
    seen[static_cast<std::size_t>(r.link)] = 1;
  }
  for (std::size_t b = tree.links.size() - 1; b > 0; --b) {
    if (seen[b]) seen[static_cast<std::size_t>(tree.links[b].parent)] = 1;
  }
  return seen;
}

CostCurvature::CostCurvature(const KinematicTree& tree, const IkProblem& problem, Wires wires)
    : wires_(wires),
      K_(tree.links.size(), Matrix6d::Zero()),
      rows_(tree, problem),
      diagonal_v_(tree.v_count()) {
  find_loose_slots(tree, problem);
  list_entries(tree, problem);
}

void CostCurvature::find_loose_slots(const KinematicTree& tree, const IkProblem& problem) {
  first_loose_.assign(1, 0);
  std::vector<char> loose(static_cast<std::size_t>(tree.unknown_count()), 1);
  const std::vector<char> seen = seen_from_the_world(tree, problem);
  for (int v = 0; v < tree.v_count(); ++v) {
    const int x = rows_.driver(v);
    const auto link = static_cast<std::size_t>(tree.link_of_v[static_cast<std::size_t>(v)]);
    if (x >= 0 && seen[link]) loose[static_cast<std::size_t>(x)] = 0;
  }
  for (int i = 0; i < rows_.support_count(); ++i) {
    if (wires_ == Wires::kApart && rows_.is_wire(i)) {
      const std::span<const int> unknowns = rows_.support(i);
      for (std::size_t k = 0; k < unknowns.size(); ++k) {
        if (loose[static_cast<std::size_t>(unknowns[k])]) {
          loose_slots_.push_back(static_cast<int>(k));
        }
      }
    }
    first_loose_.push_back(loose_slots_.size());
  }
}

void CostCurvature::list_entries(const KinematicTree& tree, const IkProblem& problem) {
  const int last = tree.unknown_count() - 1;
  const auto add_entry = [&](int x, int y) {
    entries_.push_back({last - std::min(x, y), last - std::max(x, y)});
  };
  const std::vector<char> seen = seen_from_the_world(tree, problem);
  for (std::size_t b = 1; b < tree.links.size(); ++b) {
    if (!seen[b]) continue;
    const KinematicTree::Link& own = tree.links[b];
    for (int v = own.first_v; v < own.first_v + own.v_count; ++v) {
      if (rows_.driver(v) < 0) continue;
      Column column{v, static_cast<int>(b), static_cast<int>(partners_.size()), 0, 0};
      for (auto a = static_cast<int>(b); a > 0;
           a = tree.links[static_cast<std::size_t>(a)].parent) {
        const KinematicTree::Link& link = tree.links[static_cast<std::size_t>(a)];
        const int end = std::min(v + 1, link.first_v + link.v_count);
        for (int u = link.first_v; u < end; ++u) {
          if (rows_.driver(u) < 0) continue;
          partners_.push_back(u);
          ++column.partner_count;
          if (a == static_cast<int>(b)) ++column.own_count;
          add_entry(rows_.driver(v), rows_.driver(u));
        }
      }
      columns_.push_back(column);
    }
  }
  for (const CoordinateResidual& r : problem.coordinates) {
    if (rows_.driver(r.v) >= 0) add_entry(rows_.driver(r.v), rows_.driver(r.v));
  }
  for (int i = 0; i < rows_.support_count(); ++i) {
    row_entry_.push_back(entries_.size());
    const std::span<const int> unknowns = rows_.support(i);
    if (wires_ == Wires::kApart && rows_.is_wire(i)) {
      const std::span<const int> slots = loose_slots(i);
      for (std::size_t j = 0; j < slots.size(); ++j) {
        for (std::size_t k = 0; k <= j; ++k) {
          add_entry(unknowns[static_cast<std::size_t>(slots[j])],
                    unknowns[static_cast<std::size_t>(slots[k])]);
        }
      }
      continue;
    }
    for (std::size_t j = 0; j < unknowns.size(); ++j) {
      for (std::size_t k = 0; k <= j; ++k) add_entry(unknowns[j], unknowns[k]);
    }
  }
}

void CostCurvature::update(const KinematicTree& tree, const IkProblem& problem,
                           const IkTargets& targets, const KinematicWorkspace& ws, bool newton) {
  newton_ = newton;
  rows_.update(tree, ws);
  std::fill(K_.begin(), K_.end(), Matrix6d::Zero());
  add_link_stiffness(problem, targets, ws, rows_.origin(), newton, K_);
  for (std::size_t b = tree.links.size() - 1; b > 0; --b) {
    const auto parent = static_cast<std::size_t>(tree.links[b].parent);
    if (parent > 0) K_[parent] += K_[b];
  }
}

void CostCurvature::diagonal(const KinematicTree& tree, const IkProblem& problem,
                             const IkTargets& targets, const KinematicWorkspace& ws,
                             Eigen::Ref<Eigen::VectorXd> diagonal) {
  for (int v = 0; v < tree.v_count(); ++v) {
    const auto i = static_cast<std::size_t>(v);
    const Vector6d& S = rows_.twists()[i];
    diagonal_v_[v] = std::max(0.0, S.dot(K_[static_cast<std::size_t>(tree.link_of_v[i])] * S));
  }
  for (std::size_t i = 0; i < problem.coordinates.size(); ++i) {
    if (std::isnan(targets.coordinates[i])) continue;
    diagonal_v_[problem.coordinates[i].v] += coordinate_weight(problem, targets, i);
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
                 [&](int support, std::span<const double> row, double weight) {
                   const std::span<const int> unknowns = rows_.support(support);
                   for (std::size_t i = 0; i < row.size(); ++i)
                     diagonal[unknowns[i]] += weight * row[i] * row[i];
                 });
}

// ∂g_u/∂q_v of two columns of one joint from `forward`, S_uᵀK S_v: whichever comes first stands on
// the left.
double CostCurvature::within_joint(int v, int u, const Matrix6d& K, double forward) const {
  if (rows_.order(u) < rows_.order(v)) return forward;
  const std::vector<Vector6d>& S = rows_.twists();
  const double backward = rows_.driver_slope(v) *
                          S[static_cast<std::size_t>(v)].dot(K * S[static_cast<std::size_t>(u)]);
  return rows_.order(u) > rows_.order(v) ? backward : 0.5 * (forward + backward);
}

template <typename Place>
void CostCurvature::add(const IkProblem& problem, const IkTargets& targets,
                        const KinematicWorkspace& ws, const Place& place) {
  const std::vector<Vector6d>& S = rows_.twists();
  std::size_t k = 0;
  for (const Column& column : columns_) {  // Sᵀ K S
    const auto v = static_cast<std::size_t>(column.v);
    const Matrix6d& K = K_[static_cast<std::size_t>(column.link)];
    const Vector6d F = rows_.driver_slope(column.v) * (K * S[v]);
    const int* const partners = partners_.data() + column.first_partner;
    const int x = rows_.driver(column.v);
    for (int i = 0; i < column.partner_count; ++i, ++k) {
      const auto u = static_cast<std::size_t>(partners[i]);
      double h = S[u].dot(F);
      if (newton_ && i < column.own_count) h = within_joint(column.v, partners[i], K, h);
      h *= rows_.driver_slope(partners[i]);
      // One unknown may drive both: then both (u, v) and (v, u) fall on its diagonal.
      place(k) += partners[i] != column.v && rows_.driver(partners[i]) == x ? 2.0 * h : h;
    }
  }
  for (std::size_t i = 0; i < problem.coordinates.size(); ++i) {
    const CoordinateResidual& r = problem.coordinates[i];
    if (rows_.driver(r.v) < 0) continue;
    const double slope = rows_.driver_slope(r.v);
    double& entry = place(k++);
    if (std::isnan(targets.coordinates[i])) continue;
    entry += coordinate_weight(problem, targets, i) * slope * slope;
  }
  const auto add_row = [&](int support, std::span<const double> row, double weight) {
    std::size_t entry = row_entry_[static_cast<std::size_t>(support)];
    for (std::size_t j = 0; j < row.size(); ++j) {
      const double scaled = weight * row[j];
      for (std::size_t i = 0; i <= j; ++i) place(entry++) += scaled * row[i];
    }
  };
  if (wires_ == Wires::kApart) {
    rows_.for_each_but_wires(problem, targets, ws, add_row);
  } else {
    rows_.for_each(problem, targets, ws, add_row);
  }
  if (!newton_) return;
  rows_.for_each_second(problem, targets, ws, add_row, [&](int support, int entry, double h) {
    place(row_entry_[static_cast<std::size_t>(support)] + static_cast<std::size_t>(entry)) += h;
  });
}

void CostCurvature::add_reversed(const IkProblem& problem, const IkTargets& targets,
                                 const KinematicWorkspace& ws, std::span<const int> offsets,
                                 std::span<double> values) {
  add(problem, targets, ws,
      [&](std::size_t k) -> double& { return values[static_cast<std::size_t>(offsets[k])]; });
}

void CostCurvature::add_tension(const IkProblem& problem, std::size_t wire,
                                const KinematicWorkspace& ws, double force,
                                std::span<const int> offsets, std::span<double> values) {
  const int support = rows_.support_of_wire(wire);
  const std::span<const int> slots = loose_slots(support);
  if (slots.empty()) return;
  rows_.for_each_across(problem, wire, ws, force,
                        [&](int, std::span<const double> row, double weight) {
                          std::size_t k = row_entry_[static_cast<std::size_t>(support)];
                          for (std::size_t j = 0; j < slots.size(); ++j) {
                            const double scaled = weight * row[static_cast<std::size_t>(slots[j])];
                            for (std::size_t i = 0; i <= j; ++i, ++k) {
                              values[static_cast<std::size_t>(offsets[k])] +=
                                  scaled * row[static_cast<std::size_t>(slots[i])];
                            }
                          }
                        });
}

void CostCurvature::matrix(const IkProblem& problem, const IkTargets& targets,
                           const KinematicWorkspace& ws, Eigen::MatrixXd& H) {
  H.setZero();
  add(problem, targets, ws,
      [&](std::size_t k) -> double& { return H(entries_[k].row, entries_[k].column); });
  H.reverseInPlace();
  H.triangularView<Eigen::StrictlyLower>() = H.transpose();
}

std::vector<std::vector<int>> CostCurvature::reversed_cliques(const KinematicTree& tree,
                                                              const IkProblem& problem) const {
  const int last = tree.unknown_count() - 1;
  const std::vector<char> seen = seen_from_the_world(tree, problem);
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
    const std::span<const int> unknowns = rows_.support(i);
    if (wires_ == Wires::kApart && rows_.is_wire(i)) {
      for (const int slot : loose_slots(i)) {
        clique.push_back(last - unknowns[static_cast<std::size_t>(slot)]);
      }
    } else {
      for (const int x : unknowns) clique.push_back(last - x);
    }
    cliques.push_back(std::move(clique));
  }
  return cliques;
}

}  // namespace sinew
