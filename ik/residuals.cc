#include "ik/residuals.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace sinew {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// The loops below are written once for all users of residuals: `sink` decides whether only costs
// are summed (kWrenches = false) or the elastic forces of eqs. (21)-(25) go to their links as well.
struct NoWrenches {
  static constexpr bool kWrenches = false;
  void force_at(int, const Vector3d&, const Vector3d&) {}
  void moment(int, const Vector3d&) {}
};

// Collects the gradient's wrenches, each at its link's origin.
struct LinkWrenches {
  static constexpr bool kWrenches = true;
  KinematicWorkspace& ws;
  void force_at(int link, const Vector3d& p_W, const Vector3d& f) {
    Vector6d& F = ws.F[static_cast<std::size_t>(link)];
    F.head<3>() += (p_W - ws.X_WB[static_cast<std::size_t>(link)].p).cross(f);
    F.tail<3>() += f;
  }
  void moment(int link, const Vector3d& m) { ws.F[static_cast<std::size_t>(link)].head<3>() += m; }
};

Vector3d point(const KinematicWorkspace& ws, int link, const Vector3d& p_BP) {
  return ws.X_WB[static_cast<std::size_t>(link)] * p_BP;
}

template <typename Sink>
double accumulate(const IkProblem& problem, const IkTargets& targets, const KinematicWorkspace& ws,
                  Sink&& sink) {
  constexpr bool kWrenches = std::remove_reference_t<Sink>::kWrenches;
  double twice_f = 0.0;
  for (std::size_t i = 0; i < problem.positions.size(); ++i) {
    const Vector3d& target = targets.positions[i];
    if (std::isnan(target.x())) continue;
    const PositionResidual& r = problem.positions[i];
    const Vector3d p = point(ws, r.link, r.p_BP);
    const Vector3d delta = target - p;
    const Vector3d pull = position_scale(targets, i) * (r.weight * delta);
    twice_f += delta.dot(pull);
    if constexpr (kWrenches) sink.force_at(r.link, p, -pull);
  }
  for (std::size_t i = 0; i < problem.orientations.size(); ++i) {
    const Matrix3d& target = targets.orientations[i];
    if (std::isnan(target(0, 0))) continue;
    const OrientationResidual& r = problem.orientations[i];
    const Matrix3d R_WF = ws.X_WB[static_cast<std::size_t>(r.link)].R * r.R_BF;
    const Vector3d gamma = rotation_vector(target * R_WF.transpose());
    const Vector3d pull = r.weight * gamma;
    twice_f += gamma.dot(pull);
    if constexpr (kWrenches) sink.moment(r.link, -(rotation_vector_rate(gamma).transpose() * pull));
  }
  for (std::size_t i = 0; i < problem.distances.size(); ++i) {
    if (std::isnan(targets.distances[i])) continue;
    const DistanceResidual& r = problem.distances[i];
    const Vector3d pa = point(ws, r.link_a, r.p_AP), pb = point(ws, r.link_b, r.p_BQ);
    const double length = (pa - pb).norm();
    const double delta = targets.distances[i] - length;
    twice_f += r.weight * delta * delta;
    if constexpr (kWrenches) {
      if (length == 0.0) continue;  // no direction to pull in
      const Vector3d f = (-r.weight * delta / length) * (pa - pb);
      sink.force_at(r.link_a, pa, f);
      sink.force_at(r.link_b, pb, -f);
    }
  }
  for (const WireResidual& r : problem.wires) {
    const double excess = wire_length(problem, r, ws) - r.natural_length;
    if (!(excess > 0.0)) continue;
    twice_f += r.weight * excess * excess;
    if constexpr (kWrenches) {
      for_each_wire_point(problem, r, ws, [&](int i, const Vector3d& p, const Vector3d& u) {
        sink.force_at(wire_point(problem, r, i).link, p, r.weight * excess * u);
      });
    }
  }
  for (const CoincidenceResidual& r : problem.coincidences) {
    const Vector3d pa = point(ws, r.link_a, r.p_AP), pb = point(ws, r.link_b, r.p_BQ);
    const Vector3d delta = pa - pb;
    twice_f += r.weight * delta.squaredNorm();
    if constexpr (kWrenches) {
      sink.force_at(r.link_a, pa, r.weight * delta);
      sink.force_at(r.link_b, pb, -r.weight * delta);
    }
  }
  for (const AlignmentResidual& r : problem.alignments) {
    const Matrix3d R_WF = ws.X_WB[static_cast<std::size_t>(r.link_a)].R * r.R_AF;
    const Matrix3d R_WG = ws.X_WB[static_cast<std::size_t>(r.link_b)].R * r.R_BG;
    const Vector3d gamma = rotation_vector(R_WF * R_WG.transpose());
    twice_f += r.weight * gamma.squaredNorm();
    if constexpr (kWrenches) {
      sink.moment(r.link_a, r.weight * gamma);
      sink.moment(r.link_b, -r.weight * gamma);
    }
  }
  for (std::size_t i = 0; i < problem.coordinates.size(); ++i) {
    if (std::isnan(targets.coordinates[i])) continue;
    const CoordinateResidual& r = problem.coordinates[i];
    const double delta = targets.coordinates[i] - ws.q[static_cast<std::size_t>(r.q)];
    twice_f += coordinate_weight(problem, targets, i) * delta * delta;
  }
  return 0.5 * twice_f;
}

// Adds −w Δ of every coordinate target to the torque of its own v.
template <typename Add>
void add_coordinate_gradients(const IkProblem& problem, const IkTargets& targets,
                              const KinematicWorkspace& ws, const Add& add) {
  for (std::size_t i = 0; i < problem.coordinates.size(); ++i) {
    if (std::isnan(targets.coordinates[i])) continue;
    const CoordinateResidual& r = problem.coordinates[i];
    add(r.v, coordinate_weight(problem, targets, i) *
                 (ws.q[static_cast<std::size_t>(r.q)] - targets.coordinates[i]));
  }
}

}  // namespace

IkTargets::IkTargets(const IkProblem& problem)
    : positions(problem.positions.size(), Vector3d::Constant(kNaN)),
      orientations(problem.orientations.size(), Matrix3d::Constant(kNaN)),
      distances(problem.distances.size(), kNaN),
      coordinates(problem.coordinates.size(), kNaN) {}

double wire_length(const IkProblem& problem, const WireResidual& wire,
                   const KinematicWorkspace& ws) {
  const WirePoint* const points = problem.wire_points.data() + wire.first_point;
  Vector3d p = point(ws, points[0].link, points[0].p_BP);
  double length = 0.0;
  for (int i = 1; i < wire.point_count; ++i) {
    if (!is_on_path(points[i], ws)) continue;
    const Vector3d next = point(ws, points[i].link, points[i].p_BP);
    length += (next - p).norm();
    p = next;
  }
  return length;
}

Vector3d rotation_vector(const Matrix3d& R) {
  const Eigen::Quaterniond quaternion(R);
  const Vector3d v = quaternion.vec();
  const double sine = v.norm();                                    // of φ/2
  if (sine < 1e-12) return 2.0 * (quaternion.w() < 0.0 ? -v : v);  // φ = 2 sin(φ/2) to rounding
  const double phi = 2.0 * std::atan2(sine, std::abs(quaternion.w()));
  return (quaternion.w() < 0.0 ? -phi : phi) / sine * v;
}

Matrix3d rotation_vector_rate(const Vector3d& gamma) {
  const double phi = gamma.norm();
  const Matrix3d G = skew(gamma);
  // (1 − (φ/2) cot(φ/2))/φ² → 1/12 + φ²/720 + …; the series is exact to rounding below 1e-2.
  const double phi2 = phi * phi;
  const double c = phi < 1e-2 ? 1.0 / 12.0 + phi2 / 720.0 + phi2 * phi2 / 30240.0
                              : (1.0 - 0.5 * phi / std::tan(0.5 * phi)) / phi2;
  return Matrix3d::Identity() + 0.5 * G + c * G * G;
}

double cost(const KinematicTree&, const IkProblem& problem, const IkTargets& targets,
            const KinematicWorkspace& workspace) {
  return accumulate(problem, targets, workspace, NoWrenches{});
}

double decomposed_gradient(const KinematicTree& tree, const IkProblem& problem,
                           const IkTargets& targets, KinematicWorkspace& ws,
                           Eigen::Ref<Eigen::VectorXd> g) {
  std::fill(ws.F.begin(), ws.F.end(), Vector6d::Zero());
  LinkWrenches wrenches{ws};
  const double f = accumulate(problem, targets, ws, wrenches);
  joint_torques(tree, ws);
  add_coordinate_gradients(problem, targets, ws, [&](int v, double value) {
    ws.g[static_cast<std::size_t>(v)] += value;
  });
  fold_couplings(tree, ws);
  for (int x = 0; x < tree.unknown_count(); ++x) {
    g[x] = ws.g[static_cast<std::size_t>(tree.unknown_v[static_cast<std::size_t>(x)])];
  }
  return f;
}

namespace {

// Adds Jᵀf of eqs. (12)(13) column by column, without storing J where a column is used only once.
struct JacobianRows {
  static constexpr bool kWrenches = true;
  const KinematicTree& tree;
  const KinematicWorkspace& ws;
  Eigen::Matrix3Xd& J;
  Eigen::Ref<Eigen::VectorXd> g;

  // J_Bp of the point over the ancestors of its link, then g += J_Bpᵀ f.
  void force_at(int link, const Vector3d& p_W, const Vector3d& f) {
    for_each_mover(tree, ws, link, [&](int x, int b, const Vector6d& S, double scale) {
      const Vector3d r = p_W - ws.X_WB[static_cast<std::size_t>(b)].p;
      J.col(x) = scale * (S.tail<3>() + S.head<3>().cross(r));
      g[x] += J.col(x).dot(f);
    });
  }
  void moment(int link, const Vector3d& m) {
    for_each_mover(tree, ws, link, [&](int x, int, const Vector6d& S, double scale) {
      J.col(x) = scale * S.head<3>();
      g[x] += J.col(x).dot(m);
    });
  }
};

}  // namespace

double jacobian_gradient(const KinematicTree& tree, const IkProblem& problem,
                         const IkTargets& targets, const KinematicWorkspace& ws,
                         Eigen::Matrix3Xd& J, Eigen::Ref<Eigen::VectorXd> g) {
  g.setZero();
  JacobianRows rows{tree, ws, J, g};
  const double f = accumulate(problem, targets, ws, rows);
  add_coordinate_gradients(problem, targets, ws, [&](int v, double value) {
    double scale = 1.0;
    for (int c = tree.coupling_of_v[static_cast<std::size_t>(v)]; c >= 0;
         c = tree.coupling_of_v[static_cast<std::size_t>(v)]) {
      scale *= ws.coupling_slope[static_cast<std::size_t>(c)];
      v = tree.couplings[static_cast<std::size_t>(c)].independent_v;
    }
    const int x = tree.unknown_of_v[static_cast<std::size_t>(v)];
    if (x >= 0) g[x] += scale * value;
  });
  return f;
}

}  // namespace sinew
