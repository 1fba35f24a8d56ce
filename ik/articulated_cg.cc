#include "ik/articulated_cg.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "ik/curvature.h"

namespace sinew {
namespace {

using Eigen::VectorXd;

std::size_t most_row_values(const InternalRows& rows, const IkProblem& problem) {
  // Loops give three rows a support, the others one.
  std::size_t sum = 0;
  const std::size_t single = problem.distances.size() + problem.wires.size();
  for (int i = 0; i < rows.support_count(); ++i) {
    sum += rows.support(i).size() * (static_cast<std::size_t>(i) < single ? 1 : 3);
  }
  return sum;
}

}  // namespace

ArticulatedCg::ArticulatedCg(const KinematicTree& tree, const IkProblem& problem,
                             const Options& options)
    : options_(options),
      rows_(tree, problem),
      K_(tree.links.size(), Matrix6d::Zero()),
      articulated_(tree.links.size(), Matrix6d::Zero()),
      block_(tree.links.size(), Matrix6d::Zero()),
      inverse_(tree.links.size(), Matrix6d::Zero()),
      twist_(tree.links.size(), Vector6d::Zero()),
      wrench_(tree.links.size(), Vector6d::Zero()),
      gain_(static_cast<std::size_t>(tree.v_count()), Vector6d::Zero()),
      spring_(static_cast<std::size_t>(tree.unknown_count()), 0.0),
      reduced_(static_cast<std::size_t>(tree.v_count()), 0.0),
      columns_(tree.links.size()),
      r_(tree.unknown_count()),
      z_(tree.unknown_count()),
      p_(tree.unknown_count()),
      y_(tree.unknown_count()) {
  active_rows_.reserve(3 * static_cast<std::size_t>(rows_.support_count()));
  row_values_.reserve(most_row_values(rows_, problem));
  for (std::vector<int>& columns : columns_) columns.reserve(6);
  for (int v = 0; v < tree.v_count(); ++v) {
    for (int u = 0; u < v; ++u) {
      if (rows_.driver(u) >= 0 && rows_.driver(u) == rows_.driver(v)) {
        driven_together_.emplace_back(u, v);
      }
    }
  }
}

void ArticulatedCg::collect(const Iterate& at) {
  const KinematicWorkspace& ws = at.workspace;
  rows_.update(at.tree, ws);
  std::fill(K_.begin(), K_.end(), Matrix6d::Zero());
  add_link_stiffness(at.problem, *at.targets, ws, rows_.origin(), false, K_);
  std::fill(spring_.begin(), spring_.end(), 0.0);
  for (std::size_t i = 0; i < at.problem.coordinates.size(); ++i) {
    if (std::isnan(at.targets->coordinates[i])) continue;
    const CoordinateResidual& r = at.problem.coordinates[i];
    const double slope = rows_.driver_slope(r.v);
    if (rows_.driver(r.v) < 0) continue;
    spring_[static_cast<std::size_t>(rows_.driver(r.v))] +=
        coordinate_weight(at.problem, *at.targets, i) * slope * slope;
  }
  collect_rows(at);
  for (std::size_t b = 1; b < at.tree.links.size(); ++b) {
    const KinematicTree::Link& link = at.tree.links[b];
    columns_[b].clear();
    for (int v = link.first_v; v < link.first_v + link.v_count; ++v) {
      const int x = at.tree.unknown_of_v[static_cast<std::size_t>(v)];
      if (x >= 0 && !at.held[static_cast<std::size_t>(x)]) columns_[b].push_back(v);
    }
  }
}

void ArticulatedCg::collect_rows(const Iterate& at) {
  active_rows_.clear();
  row_values_.clear();
  std::fill(block_.begin(), block_.end(), Matrix6d::Zero());
  const auto v_of = [&](int x) { return at.tree.unknown_v[static_cast<std::size_t>(x)]; };
  rows_.for_each(
      at.problem, *at.targets, at.workspace,
      [&](int support, std::span<const double> row, double weight) {
        const std::span<const int> unknowns = rows_.support(support);
        active_rows_.push_back({unknowns.data(), row_values_.size(), row.size(), weight});
        row_values_.insert(row_values_.end(), row.begin(), row.end());
        for (std::size_t i = 0; i < row.size(); ++i) {
          const int v = v_of(unknowns[i]);
          const auto link =
              static_cast<std::size_t>(at.tree.link_of_v[static_cast<std::size_t>(v)]);
          const int first = at.tree.links[link].first_v;
          for (std::size_t j = i; j < row.size() && v_of(unknowns[j]) < first + 6; ++j) {
            const int u = v_of(unknowns[j]);
            if (at.tree.link_of_v[static_cast<std::size_t>(u)] != static_cast<int>(link)) break;
            const double h = weight * row[i] * row[j];
            block_[link](v - first, u - first) += h;
            if (j > i) block_[link](u - first, v - first) += h;
          }
        }
      });
}

// Of JᵀΣJ, exactly.
double ArticulatedCg::mean_diagonal(const KinematicTree& tree) {
  articulated_ = K_;  // composite for now
  for (std::size_t b = tree.links.size() - 1; b > 0; --b) {
    articulated_[static_cast<std::size_t>(tree.links[b].parent)] += articulated_[b];
  }
  const auto stiffness = [&](int v) -> const Matrix6d& {
    return articulated_[static_cast<std::size_t>(tree.link_of_v[static_cast<std::size_t>(v)])];
  };
  const std::vector<Vector6d>& S = rows_.twists();
  const auto carries = [&](int u, int v) {  // u's link is on the way from v's to the root
    int b = tree.link_of_v[static_cast<std::size_t>(v)];
    while (b > tree.link_of_v[static_cast<std::size_t>(u)]) {
      b = tree.links[static_cast<std::size_t>(b)].parent;
    }
    return b == tree.link_of_v[static_cast<std::size_t>(u)];
  };
  double trace = 0.0;
  for (int v = 0; v < tree.v_count(); ++v) {
    if (rows_.driver(v) < 0) continue;
    const double slope = rows_.driver_slope(v);
    const Vector6d& s = S[static_cast<std::size_t>(v)];
    trace += slope * slope * s.dot(stiffness(v) * s);
  }
  for (const auto& [u, v] : driven_together_) {
    if (!carries(u, v)) continue;
    trace += 2.0 * rows_.driver_slope(u) * rows_.driver_slope(v) *
             S[static_cast<std::size_t>(u)].dot(stiffness(v) * S[static_cast<std::size_t>(v)]);
  }
  for (const Row& row : active_rows_) {
    for (std::size_t i = row.first; i < row.first + row.count; ++i) {
      trace += row.weight * row_values_[i] * row_values_[i];
    }
  }
  for (const double each : spring_) trace += each;
  return trace / static_cast<double>(std::max<std::size_t>(spring_.size(), 1));
}

template <int kColumns>
bool ArticulatedCg::eliminate(std::size_t b, std::span<const int> columns) {
  constexpr int kMost = kColumns == Eigen::Dynamic ? 6 : kColumns;
  using Columns = Eigen::Matrix<double, 6, kColumns, Eigen::ColMajor, 6, kMost>;
  using Square = Eigen::Matrix<double, kColumns, kColumns, Eigen::ColMajor, kMost, kMost>;
  const auto n = static_cast<Eigen::Index>(columns.size());
  Columns S(6, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    S.col(i) = rows_.twists()[static_cast<std::size_t>(columns[static_cast<std::size_t>(i)])];
  }
  const Columns U = articulated_[b] * S;
  const Square D =
      S.transpose() * U + Square(inverse_[b].template topLeftCorner<kColumns, kColumns>(n, n));
  const Eigen::LLT<Square> llt(D);
  if (llt.info() != Eigen::Success) return false;
  const Square inverse = llt.solve(Square::Identity(n, n));
  inverse_[b].template topLeftCorner<kColumns, kColumns>(n, n) = inverse;
  const Columns gain = U * inverse;
  articulated_[b].noalias() -= U * gain.transpose();
  for (Eigen::Index i = 0; i < n; ++i) {
    gain_[static_cast<std::size_t>(columns[static_cast<std::size_t>(i)])] = gain.col(i);
  }
  return true;
}

// (N6) without the linear part: K^A, and of every joint D⁻¹ and U D⁻¹.
bool ArticulatedCg::factorize(const KinematicTree& tree) {
  articulated_ = K_;
  for (std::size_t b = tree.links.size() - 1; b > 0; --b) {
    const std::vector<int>& columns = columns_[b];
    const int first = tree.links[b].first_v;
    for (std::size_t i = 0; i < columns.size(); ++i) {  // what D has beside SᵀK^A S
      for (std::size_t j = 0; j < columns.size(); ++j) {
        inverse_[b](static_cast<int>(i), static_cast<int>(j)) =
            block_[b](columns[i] - first, columns[j] - first);
      }
      const auto x =
          static_cast<std::size_t>(tree.unknown_of_v[static_cast<std::size_t>(columns[i])]);
      inverse_[b](static_cast<int>(i), static_cast<int>(i)) += spring_[x] + mu_;
    }
    bool definite = true;
    switch (columns.size()) {
      case 0:
        break;
      case 1:
        definite = eliminate<1>(b, columns);
        break;
      case 3:
        definite = eliminate<3>(b, columns);
        break;
      case 6:
        definite = eliminate<6>(b, columns);
        break;
      default:
        definite = eliminate<Eigen::Dynamic>(b, columns);
    }
    if (!definite) return false;
    articulated_[static_cast<std::size_t>(tree.links[b].parent)] += articulated_[b];
  }
  return true;
}

// z = M⁻¹ r: inward D⁻¹(r − Sᵀp) with p_p += p + U D⁻¹(r − Sᵀp), outward (N7).
void ArticulatedCg::precondition(const KinematicTree& tree, const VectorXd& r, VectorXd& z) {
  std::fill(wrench_.begin(), wrench_.end(), Vector6d::Zero());
  const auto unknown = [&](int v) { return tree.unknown_of_v[static_cast<std::size_t>(v)]; };
  for (std::size_t b = tree.links.size() - 1; b > 0; --b) {
    const std::vector<int>& columns = columns_[b];
    double rest[6];
    Vector6d passed = wrench_[b];
    for (std::size_t i = 0; i < columns.size(); ++i) {
      const auto v = static_cast<std::size_t>(columns[i]);
      rest[i] = r[unknown(columns[i])] - rows_.twists()[v].dot(wrench_[b]);
      passed += rest[i] * gain_[v];
    }
    for (std::size_t i = 0; i < columns.size(); ++i) {
      double sum = 0.0;
      for (std::size_t j = 0; j < columns.size(); ++j) {
        sum += inverse_[b](static_cast<int>(i), static_cast<int>(j)) * rest[j];
      }
      reduced_[static_cast<std::size_t>(columns[i])] = sum;
    }
    wrench_[static_cast<std::size_t>(tree.links[b].parent)] += passed;
  }
  z.setZero();
  twist_[0].setZero();
  for (std::size_t b = 1; b < tree.links.size(); ++b) {
    const Vector6d& carried = twist_[static_cast<std::size_t>(tree.links[b].parent)];
    Vector6d twist = carried;
    for (const int each : columns_[b]) {
      const auto v = static_cast<std::size_t>(each);
      const double step = reduced_[v] - gain_[v].dot(carried);
      z[unknown(each)] = step;
      twist += step * rows_.twists()[v];
    }
    twist_[b] = twist;
  }
}

// y = (JᵀΣJ + μE) d, zero where held.
void ArticulatedCg::multiply(const Iterate& at, const VectorXd& d, VectorXd& y) {
  const KinematicTree& tree = at.tree;
  const std::vector<Vector6d>& S = rows_.twists();
  for (Eigen::Index x = 0; x < d.size(); ++x) {
    y[x] = (spring_[static_cast<std::size_t>(x)] + mu_) * d[x];
  }
  twist_[0].setZero();
  for (std::size_t b = 1; b < tree.links.size(); ++b) {
    const KinematicTree::Link& link = tree.links[b];
    Vector6d twist = twist_[static_cast<std::size_t>(link.parent)];
    for (int v = link.first_v; v < link.first_v + link.v_count; ++v) {
      const int x = rows_.driver(v);
      if (x >= 0) twist += rows_.driver_slope(v) * d[x] * S[static_cast<std::size_t>(v)];
    }
    twist_[b] = twist;
    wrench_[b] = K_[b] * twist;
  }
  for (std::size_t b = tree.links.size() - 1; b > 0; --b) {
    const KinematicTree::Link& link = tree.links[b];
    for (int v = link.first_v; v < link.first_v + link.v_count; ++v) {
      const int x = rows_.driver(v);
      if (x >= 0) {
        y[x] += rows_.driver_slope(v) * S[static_cast<std::size_t>(v)].dot(wrench_[b]);
      }
    }
    if (link.parent > 0) wrench_[static_cast<std::size_t>(link.parent)] += wrench_[b];
  }
  for (const Row& row : active_rows_) {
    const double* const values = row_values_.data() + row.first;
    double tension = 0.0;
    for (std::size_t i = 0; i < row.count; ++i) tension += values[i] * d[row.unknowns[i]];
    tension *= row.weight;
    for (std::size_t i = 0; i < row.count; ++i) y[row.unknowns[i]] += tension * values[i];
  }
  for (Eigen::Index x = 0; x < y.size(); ++x) {
    if (at.held[static_cast<std::size_t>(x)]) y[x] = 0.0;
  }
}

bool ArticulatedCg::compute(const Iterate& at, Eigen::Ref<VectorXd> d) {
  collect(at);
  mu_ = options_.damping * std::max(mean_diagonal(at.tree), 1e-300);
  if (!factorize(at.tree)) return false;
  d.setZero();
  r_ = -at.g;
  precondition(at.tree, r_, z_);
  p_ = z_;
  double rz = r_.dot(z_);
  const double goal = options_.tolerance * options_.tolerance * rz;
  for (iterations_ = 0; iterations_ < options_.max_iterations && rz > goal; ++iterations_) {
    multiply(at, p_, y_);
    const double alpha = rz / p_.dot(y_);
    d += alpha * p_;
    r_ -= alpha * y_;
    precondition(at.tree, r_, z_);
    const double next = r_.dot(z_);
    p_ = z_ + (next / rz) * p_;
    rz = next;
  }
  return at.g.dot(d) < 0.0;
}

}  // namespace sinew
