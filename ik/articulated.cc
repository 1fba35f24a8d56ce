#include "ik/articulated.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "ik/curvature.h"
#include "ik/stiffness.h"

namespace sinew {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// [m× f×; f× 0] s for the wrench [m; f], see (N5).
Vector6d commutator(const Vector6d& wrench, const Vector6d& s) {
  const Vector3d m = wrench.head<3>(), f = wrench.tail<3>();
  Vector6d result;
  result << m.cross(s.head<3>()) + f.cross(s.tail<3>()), f.cross(s.head<3>());
  return result;
}

// (N4) of a loaded point at r from the link's origin.
void add_geometric_stiffness(Matrix6d& K, const Vector3d& r, const Vector3d& f) {
  const Matrix3d F = skew(f), R = skew(r);
  const Matrix3d FR = F * R;
  K.topLeftCorner<3, 3>() += 0.5 * (FR + FR.transpose());
  K.topRightCorner<3, 3>() -= 0.5 * F;
  K.bottomLeftCorner<3, 3>() += 0.5 * F;
}

// Sizes known at run time only, on the stack: one instance serves what is rare.
using SmallMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, 6, 6>;

double lowest_eigenvalue(const SmallMatrix& D) {
  return Eigen::SelfAdjointEigenSolver<SmallMatrix>(D, Eigen::EigenvaluesOnly).eigenvalues()[0];
}

// What active_ says of a v: nothing to move, free, or to end at its bound, its step in −offset_.
constexpr char kHeld = 0, kFree = 1, kStopped = 2;

// Stops what the step carries over a bound there. Returns whether there was any.
bool stop_at_bounds(const Iterate& at, const Eigen::Ref<const Eigen::VectorXd>& d,
                    std::vector<char>& active, std::vector<double>& offset) {
  bool changed = false;
  for (Eigen::Index x = 0; x < d.size(); ++x) {
    const auto i = static_cast<std::size_t>(x);
    const auto v = static_cast<std::size_t>(at.tree.unknown_v[i]);
    if (at.tree.q_of_v[v] < 0 || active[v] != kFree) continue;
    const double q = at.workspace.q[static_cast<std::size_t>(at.tree.q_of_v[v])];
    const double lower = at.tree.lower[i] - q, upper = at.tree.upper[i] - q;
    if (d[x] >= lower && d[x] <= upper) continue;
    active[v] = kStopped;
    offset[v] = d[x] < lower ? -lower : -upper;
    changed = true;
  }
  return changed;
}

// μ beyond this multiple of the stiffness leaves no step worth taking.
constexpr double kLargestMu = 1e8;

// Of a factorization beside the square of a column's height: Sᵀ K S, clearing, copying, solving.
constexpr double kOperationsPerEntry = 16.0;

// Of the sweep, in what a factorization does in the same time. In tests/bench/results.md a chain of
// 40 links with 3 unknowns each takes 99 µs an iteration by the factorization, 700 thousand
// operations by this count, and 12.5 µs by the sweep, kinematics included.
constexpr double kOperationsPerLink = 600.0, kOperationsPerColumn = 400.0;

// How much less the sweep has to cost: it cannot stop at bounds within an iteration, and takes a
// few more.
constexpr double kWorthTheSweep = 2.0;

// μ below this multiple cannot make a joint definite that no residual sees.
constexpr double kLeastMu = 1e-12;

}  // namespace

bool articulated_sweep_fits(const KinematicTree& tree, const IkProblem& problem) {
  if (!tree.couplings.empty()) return false;
  const InternalRows rows(tree, problem);
  const auto link_of = [&](int x) {
    return tree.link_of_v[static_cast<std::size_t>(tree.unknown_v[static_cast<std::size_t>(x)])];
  };
  for (int i = 0; i < rows.support_count(); ++i) {
    for (const int x : rows.support(i)) {
      if (link_of(x) != link_of(rows.support(i).front())) return false;
    }
  }
  return true;
}

bool articulated_sweep_is_faster(const KinematicTree& tree, const IkProblem& problem) {
  const std::vector<char> seen = seen_from_the_world(tree, problem);
  std::vector<double> unknowns(tree.links.size(), 0.0);  // from the link to the root
  double factorization = 0.0, sweep = 0.0;
  for (std::size_t b = 1; b < tree.links.size(); ++b) {
    const KinematicTree::Link& link = tree.links[b];
    unknowns[b] = unknowns[static_cast<std::size_t>(link.parent)];
    for (int v = link.first_v; v < link.first_v + link.v_count; ++v) {
      if (tree.unknown_of_v[static_cast<std::size_t>(v)] < 0) continue;
      const double height = ++unknowns[b];
      if (seen[b]) factorization += height * (height + kOperationsPerEntry);
      sweep += kOperationsPerColumn;
    }
    sweep += kOperationsPerLink;
  }
  return factorization > kWorthTheSweep * sweep && articulated_sweep_fits(tree, problem);
}

Articulated::Articulated(const KinematicTree& tree, const IkProblem& problem, Model model,
                         const Options& options)
    : model_(model),
      options_(options),
      rows_(tree, problem),
      joint_stiffness_(tree.links.size(), Matrix6d::Zero()),
      stiffness_(tree.links.size(), Matrix6d::Zero()),
      K_(tree.links.size(), Matrix6d::Zero()),
      p_(tree.links.size(), Vector6d::Zero()),
      twist_(tree.links.size(), Vector6d::Zero()),
      gain_(static_cast<std::size_t>(tree.v_count()), Vector6d::Zero()),
      offset_(static_cast<std::size_t>(tree.v_count()), 0.0),
      torque_(static_cast<std::size_t>(tree.v_count()), 0.0),
      spring_(static_cast<std::size_t>(tree.v_count()), 0.0),
      active_(static_cast<std::size_t>(tree.v_count()), 0) {}

void Articulated::start() {
  mu_ = kNaN;
  growth_ = 2.0;
  rejected_ = 0;
  near_ = model_ == Model::kAutomatic;
  newton_ = near_ || model_ == Model::kNewton;
}

void Articulated::collect_stiffness(const Iterate& at, bool newton) {
  const KinematicWorkspace& ws = at.workspace;
  std::fill(stiffness_.begin(), stiffness_.end(), Matrix6d::Zero());
  for (std::size_t i = 0; i < at.problem.positions.size(); ++i) {
    const Vector3d& target = at.targets->positions[i];
    if (std::isnan(target.x())) continue;
    const PositionResidual& r = at.problem.positions[i];
    const auto link = static_cast<std::size_t>(r.link);
    const Vector3d arm = ws.X_WB[link].R * r.p_BP;
    const Matrix3d weight = position_weight(at.problem, *at.targets, i);
    add_point_stiffness(stiffness_[link], arm, weight);
    if (newton) {
      add_geometric_stiffness(stiffness_[link], arm, -(weight * (target - ws.X_WB[link].p - arm)));
    }
  }
  for (std::size_t i = 0; i < at.problem.orientations.size(); ++i) {
    const Matrix3d& target = at.targets->orientations[i];
    if (std::isnan(target(0, 0))) continue;
    const OrientationResidual& r = at.problem.orientations[i];
    const auto link = static_cast<std::size_t>(r.link);
    const Vector3d gamma = rotation_vector(target * (ws.X_WB[link].R * r.R_BF).transpose());
    if (newton && is_isotropic(r.weight)) {
      stiffness_[link].topLeftCorner<3, 3>() += orientation_curvature(r.weight(0, 0), gamma);
    } else {
      const Matrix3d rate = rotation_vector_rate(gamma);
      stiffness_[link].topLeftCorner<3, 3>() += rate.transpose() * r.weight * rate;
    }
  }
  if (rows_.support_count() > 0) collect_joint_stiffness(at);
  scale_ = 0.0;
  for (const Matrix6d& K : stiffness_) scale_ = std::max(scale_, K.trace() / 6.0);
  for (const Matrix6d& K : joint_stiffness_) scale_ = std::max(scale_, K.trace() / 6.0);
  std::fill(torque_.begin(), torque_.end(), 0.0);
  std::fill(spring_.begin(), spring_.end(), 0.0);
  for (std::size_t i = 0; i < at.problem.coordinates.size(); ++i) {
    const double target = at.targets->coordinates[i];
    if (std::isnan(target)) continue;
    const CoordinateResidual& r = at.problem.coordinates[i];
    const auto v = static_cast<std::size_t>(r.v);
    const double weight = coordinate_weight(at.problem, *at.targets, i);
    torque_[v] += weight * (ws.q[static_cast<std::size_t>(r.q)] - target);
    spring_[v] += weight;
    scale_ = std::max(scale_, weight);
  }
}

// Residuals across one joint: every unknown of a row belongs to the same link.
void Articulated::collect_joint_stiffness(const Iterate& at) {
  rows_.update(at.tree, at.workspace);
  std::fill(joint_stiffness_.begin(), joint_stiffness_.end(), Matrix6d::Zero());
  rows_.for_each(at.problem, *at.targets, at.workspace,
                 [&](int support, std::span<const double> row, double weight) {
                   const std::span<const int> unknowns = rows_.support(support);
                   if (unknowns.empty()) return;
                   const auto v_of = [&](std::size_t i) {
                     return at.tree.unknown_v[static_cast<std::size_t>(unknowns[i])];
                   };
                   const int link = at.tree.link_of_v[static_cast<std::size_t>(v_of(0))];
                   const int first = at.tree.links[static_cast<std::size_t>(link)].first_v;
                   Matrix6d& K = joint_stiffness_[static_cast<std::size_t>(link)];
                   for (std::size_t i = 0; i < row.size(); ++i) {
                     for (std::size_t j = 0; j < row.size(); ++j) {
                       K(v_of(i) - first, v_of(j) - first) += weight * row[i] * row[j];
                     }
                   }
                 });
}

// C_k of (N2): steps i before j of one joint do not commute, and functions are curved.
template <typename Matrix>
void Articulated::add_joint_curvature(const Iterate& at, int link_index,
                                      std::span<const int> columns, Matrix& D) const {
  const KinematicTree::Link& link = at.tree.links[static_cast<std::size_t>(link_index)];
  const KinematicWorkspace& ws = at.workspace;
  const Vector6d& f = ws.f[static_cast<std::size_t>(link_index)];
  if (link.kind == KinematicTree::Kind::kFree) {
    // The shift comes before the turn, whose exponential needs nothing within itself.
    const auto shifts = [&](Eigen::Index i) {
      return columns[static_cast<std::size_t>(i)] - link.first_v >= 3;
    };
    const auto twist = [&](Eigen::Index i) -> const Vector6d& {
      return ws.S[static_cast<std::size_t>(columns[static_cast<std::size_t>(i)])];
    };
    for (Eigen::Index i = 0; i < D.cols(); ++i) {
      if (!shifts(i)) continue;
      const Vector6d moved = commutator(f, twist(i));
      for (Eigen::Index j = 0; j < D.cols(); ++j) {
        if (shifts(j)) continue;
        const double h = 0.5 * twist(j).dot(moved);
        D(i, j) += h;
        D(j, i) += h;
      }
    }
    return;
  }
  if (link.kind != KinematicTree::Kind::kSteps) return;
  const auto column_of = [&](int v) {
    for (int i = 0; i < static_cast<int>(columns.size()); ++i) {
      if (columns[static_cast<std::size_t>(i)] == v) return i;
    }
    return -1;
  };
  // Shifts first, then turns: the order in which they carry each other.
  const int steps = link.rotation_count + link.translation_count;
  const auto step_at = [&](int order) {
    return static_cast<std::size_t>(link.first_step + (order < link.translation_count
                                                           ? link.rotation_count + order
                                                           : order - link.translation_count));
  };
  for (int i = 0; i < steps; ++i) {
    const std::size_t si = step_at(i);
    const int vi = at.tree.steps[si].v;
    const int ci = vi < 0 ? -1 : column_of(vi);
    if (ci < 0) continue;
    D(ci, ci) += ws.step_curvature[si] * ws.step_twist[si].dot(f);
    const Vector6d moved = commutator(f, ws.step_slope[si] * ws.step_twist[si]);
    for (int j = std::max(i + 1, link.translation_count); j < steps; ++j) {
      const std::size_t sj = step_at(j);
      const int vj = at.tree.steps[sj].v;
      const int cj = vj < 0 ? -1 : column_of(vj);
      if (cj < 0) continue;
      const double h = 0.5 * ws.step_slope[sj] * ws.step_twist[sj].dot(moved);
      D(ci, cj) += h;
      D(cj, ci) += h;
    }
  }
}

// (N6) for the active columns of one joint. False if D is not positive definite.
template <int kColumns>
bool Articulated::eliminate(const Iterate& at, int link_index, std::span<const int> columns,
                            bool newton) {
  constexpr int kMost = kColumns == Eigen::Dynamic ? 6 : kColumns;
  const auto n = static_cast<Eigen::Index>(columns.size());
  const auto b = static_cast<std::size_t>(link_index);
  const KinematicWorkspace& ws = at.workspace;
  using Columns = Eigen::Matrix<double, 6, kColumns, Eigen::ColMajor, 6, kMost>;
  using Square = Eigen::Matrix<double, kColumns, kColumns, Eigen::ColMajor, kMost, kMost>;
  using Vector = Eigen::Matrix<double, kColumns, 1, Eigen::ColMajor, kMost, 1>;
  Columns S(6, n);
  for (Eigen::Index i = 0; i < n; ++i)
    S.col(i) = ws.S[static_cast<std::size_t>(columns[static_cast<std::size_t>(i)])];
  Columns U = K_[b] * S;
  Square D = S.transpose() * U;
  Vector z = S.transpose() * p_[b];
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto v = static_cast<std::size_t>(columns[static_cast<std::size_t>(i)]);
    z[i] += torque_[v];
    D(i, i) += spring_[v];
  }
  if (rows_.support_count() > 0) {
    const int first = at.tree.links[b].first_v;
    for (Eigen::Index i = 0; i < n; ++i) {
      for (Eigen::Index j = 0; j < n; ++j) {
        D(i, j) += joint_stiffness_[b](columns[static_cast<std::size_t>(i)] - first,
                                       columns[static_cast<std::size_t>(j)] - first);
      }
    }
  }
  if (newton) {
    add_joint_curvature(at, link_index, columns, D);
    for (Eigen::Index i = 0; i < n; ++i) U.col(i) -= 0.5 * commutator(ws.f[b], S.col(i));  // Bᵀ
  }
  D.diagonal().array() += mu_;
  const Eigen::LLT<Square> llt(D);
  if (llt.info() != Eigen::Success) {
    needed_mu_ = mu_ - 2.0 * lowest_eigenvalue(D);
    return false;
  }
  const Columns gain = llt.solve(U.transpose()).transpose();
  const Vector offset = llt.solve(z);
  K_[b].noalias() -= U * gain.transpose();
  p_[b].noalias() -= U * offset;
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto v = static_cast<std::size_t>(columns[static_cast<std::size_t>(i)]);
    gain_[v] = gain.col(i);
    offset_[v] = offset[i];
  }
  return true;
}

bool Articulated::dispatch(const Iterate& at, int link_index, bool newton) {
  const KinematicTree::Link& link = at.tree.links[static_cast<std::size_t>(link_index)];
  int columns[6];
  int count = 0;
  for (int v = link.first_v; v < link.first_v + link.v_count; ++v) {
    const auto i = static_cast<std::size_t>(v);
    if (active_[i] == kFree) columns[count++] = v;
    if (active_[i] != kStopped) continue;
    const auto b = static_cast<std::size_t>(link_index);  // its step is known, and moves the link
    p_[b] -= offset_[i] * (K_[b] * at.workspace.S[i]);
  }
  switch (count) {  // the common joints unrolled, the rest by one instance
    case 0:
      return true;
    case 1:
      return eliminate<1>(at, link_index, {columns, 1}, newton);
    case 3:
      return eliminate<3>(at, link_index, {columns, 3}, newton);
    default:
      return eliminate<Eigen::Dynamic>(at, link_index, {columns, static_cast<std::size_t>(count)},
                                       newton);
  }
}

void Articulated::add_to_parent(const Iterate& at, int link_index) {
  const auto b = static_cast<std::size_t>(link_index);
  const auto parent = static_cast<std::size_t>(at.tree.links[b].parent);
  const Vector3d r = at.workspace.X_WB[b].p - at.workspace.X_WB[parent].p;
  add_shifted_stiffness(K_[parent], K_[b], r);
  p_[parent].head<3>() += p_[b].head<3>() + r.cross(p_[b].tail<3>());
  p_[parent].tail<3>() += p_[b].tail<3>();
}

bool Articulated::sweep_inward(const Iterate& at, bool newton) {
  K_ = stiffness_;  // same sizes: copies without allocating
  p_ = at.workspace.F;
  for (int b = at.tree.link_count() - 1; b > 0; --b) {
    if (!dispatch(at, b, newton)) return false;
    if (at.tree.links[static_cast<std::size_t>(b)].parent > 0) add_to_parent(at, b);
  }
  return true;
}

void Articulated::sweep_outward(const Iterate& at, Eigen::Ref<Eigen::VectorXd> d) {
  d.setZero();
  twist_[0].setZero();
  for (std::size_t b = 1; b < at.tree.links.size(); ++b) {
    const KinematicTree::Link& link = at.tree.links[b];
    const auto parent = static_cast<std::size_t>(link.parent);
    const Vector3d r = at.workspace.X_WB[b].p - at.workspace.X_WB[parent].p;
    Vector6d moved = twist_[parent];  // X_k v_p
    moved.tail<3>() += moved.head<3>().cross(r);
    twist_[b] = moved;
    for (int i = link.first_v; i < link.first_v + link.v_count; ++i) {
      const auto v = static_cast<std::size_t>(i);
      if (!active_[v]) continue;
      const double step = (active_[v] == kFree ? -gain_[v].dot(moved) : 0.0) - offset_[v];
      d[at.tree.unknown_of_v[v]] = step;
      twist_[b] += step * at.workspace.S[v];
    }
  }
}

bool Articulated::sweep(const Iterate& at, Eigen::Ref<Eigen::VectorXd> d) {
  collect_stiffness(at, newton_);
  if (std::isnan(mu_)) mu_ = options_.damping * scale_;
  mu_ = std::max(mu_, kLeastMu * scale_);
  while (!sweep_inward(at, newton_)) {
    if (near_) return false;  // no minimum near, then
    mu_ = std::max(10.0 * mu_, needed_mu_);
    if (!(mu_ < kLargestMu * scale_)) return false;
  }
  sweep_outward(at, d);
  step_ = d.cwiseAbs().maxCoeff();
  return !near_ || step_ < kSmallStep;
}

bool Articulated::compute(const Iterate& at, Eigen::Ref<Eigen::VectorXd> d) {
  if (at.g.size() == 0) return false;
  for (std::size_t v = 0; v < active_.size(); ++v) {
    const int x = at.tree.unknown_of_v[v];
    active_[v] = x >= 0 && !at.held[static_cast<std::size_t>(x)] ? kFree : kHeld;
  }
  if (!sweep(at, d)) {
    if (!near_) return false;
    near_ = newton_ = false;
    if (!sweep(at, d)) return false;
  }
  const auto slope = [&] { return at.g.dot(d); };
  if (stop_at_bounds(at, d, active_, offset_)) {
    const bool swept = sweep(at, d);
    if (swept && slope() < 0.0) {
      expected_ = -slope();  // less what stiffness stores on the way
      for (std::size_t b = 1; b < twist_.size(); ++b) {
        expected_ -= 0.5 * twist_[b].dot(stiffness_[b] * twist_[b]);
      }
      return true;
    }
    std::replace(active_.begin(), active_.end(), kStopped, kFree);
    near_ = false;
    if (!sweep(at, d)) return false;
  }
  expected_ = -0.5 * slope() + 0.5 * mu_ * d.squaredNorm();
  return slope() < 0.0;
}

void Articulated::learn(double accepted_length, double actual_decrease) {
  const double ratio = expected_ > 0.0 ? actual_decrease / expected_ : 0.0;
  const bool accepted = accepted_length == 1.0 && ratio > 0.0;
  if (accepted) {
    const double r = 2.0 * ratio - 1.0;
    mu_ *= std::max(1.0 / 3.0, 1.0 - r * r * r);
    growth_ = 2.0;
  } else {
    mu_ = std::max(mu_ * growth_, 1e-8 * scale_);
    growth_ *= 2.0;
  }
  near_ = model_ == Model::kAutomatic && accepted && step_ < kSmallStep;
  newton_ = newton_ || near_;
  rejected_ = accepted ? 0 : rejected_ + 1;
  // Gauss-Newton's model misses curvature if it promises ten times what it keeps, or twice in a row
  // what it does not keep at all.
  if (model_ == Model::kAutomatic && (rejected_ >= 2 || (accepted && ratio < 0.1))) newton_ = true;
}

}  // namespace sinew
