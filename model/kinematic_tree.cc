#include "model/kinematic_tree.h"

#include <algorithm>
#include <cmath>

namespace sinew {
namespace {

using Link = KinematicTree::Link;
using Step = KinematicTree::Step;
using Kind = KinematicTree::Kind;

// Turn by `angle` about the unit vector `axis` (Rodrigues).
Eigen::Matrix3d turn(const Eigen::Vector3d& axis, double angle) {
  const double s = std::sin(angle), c = std::cos(angle);
  const Eigen::Vector3d a = (1.0 - c) * axis;
  Eigen::Matrix3d R;
  R << c + a.x() * axis.x(), a.x() * axis.y() - s * axis.z(), a.x() * axis.z() + s * axis.y(),
      a.y() * axis.x() + s * axis.z(), c + a.y() * axis.y(), a.y() * axis.z() - s * axis.x(),
      a.z() * axis.x() - s * axis.y(), a.z() * axis.y() + s * axis.x(), c + a.z() * axis.z();
  return R;
}

// R ← R·turn(axis, angle). Most axes are coordinate axes, which leave a column as it is.
inline void turn_on(Eigen::Matrix3d& R, const Eigen::Vector3d& axis, double angle) {
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    if (axis[j] != 0.0 || axis[k] != 0.0) continue;
    const double s = axis[i] * std::sin(angle), c = std::cos(angle);
    const Eigen::Vector3d before = R.col(j);
    R.col(j) = c * before + s * R.col(k);
    R.col(k) = c * R.col(k) - s * before;
    return;
  }
  R = R * turn(axis, angle);
}

Eigen::Matrix3d rotation_of(const double* q) {
  return Eigen::Quaterniond(q[0], q[1], q[2], q[3]).toRotationMatrix();
}

struct StepValue {
  double value, slope, curvature;
};

inline StepValue evaluate(const KinematicTree& tree, const Step& step,
                          const std::vector<double>& q) {
  if (step.q < 0) return {step.constant, 0.0, 0.0};
  const double x = q[static_cast<std::size_t>(step.q)];
  if (step.function < 0) return {x, 1.0, 0.0};
  const auto d = tree.functions[static_cast<std::size_t>(step.function)].evaluate(x);
  return {d.f, d.df, d.ddf};
}

void couple(const KinematicTree& tree, KinematicWorkspace& ws) {
  for (std::size_t i = 0; i < tree.couplings.size(); ++i) {
    const KinematicTree::Coupling& c = tree.couplings[i];
    const auto d = tree.functions[static_cast<std::size_t>(c.function)].evaluate(
        ws.q[static_cast<std::size_t>(c.independent_q)]);
    ws.q[static_cast<std::size_t>(c.dependent_q)] = d.f;
    ws.coupling_slope[i] = d.df;
  }
}

// Adds the angular column w (world axes) of a turn about M's origin.
void add_turn(Vector6d& column, const Eigen::Vector3d& w, const Eigen::Vector3d& p_MB) {
  column.head<3>() += w;
  column.tail<3>() += w.cross(p_MB);
}

// Keeps a step's own column and adds its share to the column of the coordinate that drives it.
inline void record_step(KinematicWorkspace& ws, std::size_t index, const Step& step,
                        const StepValue& at, const Eigen::Vector3d& w, const Eigen::Vector3d& v) {
  Vector6d& twist = ws.step_twist[index];
  twist << w, v;
  ws.step_slope[index] = at.slope;
  ws.step_curvature[index] = at.curvature;
  ws.S[static_cast<std::size_t>(step.v)] += at.slope * twist;
}

template <bool kWithColumns>
void pose_of_steps(const KinematicTree& tree, KinematicWorkspace& ws, const Link& link,
                   const RigidTransform& X_WF, RigidTransform& X_WM) {
  const auto first = static_cast<std::size_t>(link.first_step);
  const auto turns = static_cast<std::size_t>(link.rotation_count);
  const auto all = turns + static_cast<std::size_t>(link.translation_count);
  Eigen::Vector3d axis_W[3];
  StepValue angle[3];
  X_WM = X_WF;
  for (std::size_t i = 0; i < turns; ++i) {
    const Step& step = tree.steps[first + i];
    angle[i] = evaluate(tree, step, ws.q);
    if constexpr (kWithColumns) axis_W[i] = X_WM.R * step.axis;
    turn_on(X_WM.R, step.axis, angle[i].value);
  }
  for (std::size_t i = turns; i < all; ++i) {
    const Step& step = tree.steps[first + i];
    const StepValue length = evaluate(tree, step, ws.q);
    const Eigen::Vector3d direction = X_WF.R * step.axis;
    X_WM.p += length.value * direction;
    if constexpr (kWithColumns) {
      if (step.v >= 0) record_step(ws, first + i, step, length, Eigen::Vector3d::Zero(), direction);
    }
  }
  if constexpr (kWithColumns) {
    const Eigen::Vector3d p_MB = X_WM.R * link.X_MB.p;
    for (std::size_t i = 0; i < turns; ++i) {
      const Step& step = tree.steps[first + i];
      if (step.v < 0) continue;
      record_step(ws, first + i, step, angle[i], axis_W[i], axis_W[i].cross(p_MB));
    }
  }
}

// M's origin sits on the ellipsoid where its outward normal is M's z axis... scaled by the radii:
// p_FM = radii ∘ R_FM ẑ, as Simbody's Ellipsoid mobilizer has it.
template <bool kWithColumns>
void pose_of_ellipsoid(const KinematicTree& tree, KinematicWorkspace& ws, const Link& link,
                       const RigidTransform& X_WF, RigidTransform& X_WM) {
  const Step* step = tree.steps.data() + link.first_step;
  Eigen::Matrix3d R_FM = Eigen::Matrix3d::Identity();
  Eigen::Vector3d axis_F[3];
  for (int i = 0; i < 3; ++i) {
    axis_F[i] = R_FM * step[i].axis;
    turn_on(R_FM, step[i].axis, evaluate(tree, step[i], ws.q).value);
  }
  const Eigen::Vector3d normal_F = R_FM.col(2);
  X_WM.R = X_WF.R * R_FM;
  X_WM.p = X_WF.p + X_WF.R * link.radii.cwiseProduct(normal_F);
  if constexpr (kWithColumns) {
    const Eigen::Vector3d p_MB = X_WM.R * link.X_MB.p;
    for (int i = 0; i < 3; ++i) {
      Vector6d& column = ws.S[static_cast<std::size_t>(step[i].v)];
      add_turn(column, X_WF.R * axis_F[i], p_MB);
      column.tail<3>() += X_WF.R * link.radii.cwiseProduct(axis_F[i].cross(normal_F));
    }
  }
}

template <bool kWithColumns>
void pose_of_quaternion(KinematicWorkspace& ws, const Link& link, const RigidTransform& X_WF,
                        RigidTransform& X_WM) {
  const double* q = ws.q.data() + link.first_q;
  X_WM.R = X_WF.R * rotation_of(q);
  X_WM.p = X_WF.p;
  const bool shifts = link.kind == Kind::kFree;
  if (shifts) X_WM.p += X_WF.R * Eigen::Vector3d(q[4], q[5], q[6]);
  if constexpr (kWithColumns) {
    const Eigen::Vector3d p_MB = X_WM.R * link.X_MB.p;
    for (int i = 0; i < 3; ++i) {
      const auto v = static_cast<std::size_t>(link.first_v + i);
      add_turn(ws.S[v], X_WF.R.col(i), p_MB);
      if (shifts) ws.S[v + 3].tail<3>() += X_WF.R.col(i);
    }
  }
}

template <bool kWithColumns>
void update(const KinematicTree& tree, KinematicWorkspace& ws) {
  couple(tree, ws);
  if constexpr (kWithColumns) std::fill(ws.S.begin(), ws.S.end(), Vector6d::Zero());
  for (std::size_t b = 1; b < tree.links.size(); ++b) {
    const Link& link = tree.links[b];
    const RigidTransform X_WF = ws.X_WB[static_cast<std::size_t>(link.parent)] * link.X_PF;
    RigidTransform X_WM;
    switch (link.kind) {
      case Kind::kWeld:
        X_WM = X_WF;
        break;
      case Kind::kSteps:
        pose_of_steps<kWithColumns>(tree, ws, link, X_WF, X_WM);
        break;
      case Kind::kEllipsoid:
        pose_of_ellipsoid<kWithColumns>(tree, ws, link, X_WF, X_WM);
        break;
      case Kind::kBall:
      case Kind::kFree:
        pose_of_quaternion<kWithColumns>(ws, link, X_WF, X_WM);
        break;
    }
    ws.X_WB[b] = X_WM * link.X_MB;
  }
}

}  // namespace

KinematicWorkspace::KinematicWorkspace(const KinematicTree& tree)
    : q(tree.default_q),
      X_WB(tree.links.size()),
      S(static_cast<std::size_t>(tree.v_count()), Vector6d::Zero()),
      step_twist(tree.steps.size(), Vector6d::Zero()),
      step_slope(tree.steps.size(), 0.0),
      step_curvature(tree.steps.size(), 0.0),
      coupling_slope(tree.couplings.size(), 0.0),
      F(tree.links.size(), Vector6d::Zero()),
      f(tree.links.size(), Vector6d::Zero()),
      g(static_cast<std::size_t>(tree.v_count()), 0.0) {}

void prescribe(const KinematicTree& tree, double time, std::span<double> q) {
  for (const KinematicTree::Prescribed& p : tree.prescribed) {
    q[static_cast<std::size_t>(p.q)] =
        tree.functions[static_cast<std::size_t>(p.function)].value(time);
  }
}

void update_kinematics(const KinematicTree& tree, KinematicWorkspace& workspace) {
  update<true>(tree, workspace);
}

void update_poses(const KinematicTree& tree, KinematicWorkspace& workspace) {
  update<false>(tree, workspace);
}

void joint_torques(const KinematicTree& tree, KinematicWorkspace& ws) {
  ws.f = ws.F;  // same size: copies without allocating
  for (std::size_t b = tree.links.size() - 1; b > 0; --b) {
    const Link& link = tree.links[b];
    const Vector6d& f = ws.f[b];
    for (int i = 0; i < link.v_count; ++i) {
      const auto v = static_cast<std::size_t>(link.first_v + i);
      ws.g[v] = ws.S[v].dot(f);
    }
    const auto parent = static_cast<std::size_t>(link.parent);
    const Eigen::Vector3d r = ws.X_WB[b].p - ws.X_WB[parent].p;
    ws.f[parent].head<3>() += f.head<3>() + r.cross(f.tail<3>());
    ws.f[parent].tail<3>() += f.tail<3>();
  }
}

void fold_couplings(const KinematicTree& tree, KinematicWorkspace& ws) {
  for (std::size_t i = tree.couplings.size(); i-- > 0;) {
    const KinematicTree::Coupling& c = tree.couplings[i];
    ws.g[static_cast<std::size_t>(c.independent_v)] +=
        ws.coupling_slope[i] * ws.g[static_cast<std::size_t>(c.dependent_v)];
  }
}

namespace {

// Turns the quaternion at q by the rotation vector w, given in F: q ← exp(w) q, normalized.
void turn_quaternion(const double* q, const Eigen::Vector3d& w, double* q_out) {
  const double half = 0.5 * w.norm();
  const double scale = half < 1e-8 ? 0.5 : 0.5 * std::sin(half) / half;  // sin(h)/h = 1 − O(1e-17)
  const Eigen::Quaterniond delta(std::cos(half), scale * w.x(), scale * w.y(), scale * w.z());
  const Eigen::Quaterniond turned =
      (delta * Eigen::Quaterniond(q[0], q[1], q[2], q[3])).normalized();
  q_out[0] = turned.w();
  q_out[1] = turned.x();
  q_out[2] = turned.y();
  q_out[3] = turned.z();
}

}  // namespace

void advance(const KinematicTree& tree, std::span<const double> q, std::span<const double> step,
             std::span<double> q_out) {
  std::copy(q.begin(), q.end(), q_out.begin());
  for (std::size_t x = 0; x < tree.unknown_v.size(); ++x) {
    const int entry = tree.q_of_v[static_cast<std::size_t>(tree.unknown_v[x])];
    if (entry < 0) continue;
    const auto i = static_cast<std::size_t>(entry);
    q_out[i] = std::clamp(q[i] + step[x], tree.lower[x], tree.upper[x]);
  }
  for (const Link& link : tree.links) {
    if (link.kind != Kind::kBall && link.kind != Kind::kFree) continue;
    const int x = tree.unknown_of_v[static_cast<std::size_t>(link.first_v)];
    const double* w = step.data() + x;
    turn_quaternion(q.data() + link.first_q, {w[0], w[1], w[2]}, q_out.data() + link.first_q);
  }
}

void station_jacobian(const KinematicTree& tree, const KinematicWorkspace& ws, int link,
                      const Eigen::Vector3d& p_BQ, Eigen::Ref<Eigen::Matrix3Xd> J) {
  J.setZero();
  const Eigen::Vector3d p_WQ = ws.X_WB[static_cast<std::size_t>(link)] * p_BQ;
  for_each_mover(tree, ws, link, [&](int x, int b, const Vector6d& S, double scale) {
    const Eigen::Vector3d r = p_WQ - ws.X_WB[static_cast<std::size_t>(b)].p;
    J.col(x) += scale * (S.tail<3>() + S.head<3>().cross(r));
  });
}

void rotation_jacobian(const KinematicTree& tree, const KinematicWorkspace& ws, int link,
                       Eigen::Ref<Eigen::Matrix3Xd> J) {
  J.setZero();
  for_each_mover(tree, ws, link, [&](int x, int, const Vector6d& S, double scale) {
    J.col(x) += scale * S.head<3>();
  });
}

}  // namespace sinew
