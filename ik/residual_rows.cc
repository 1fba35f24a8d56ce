#include "ik/residual_rows.h"

#include <Eigen/Cholesky>
#include <cmath>

namespace sinew {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// T with Σ = TᵀT, for weights that may be semidefinite.
Matrix3d root(const Matrix3d& weight) {
  const Eigen::LDLT<Matrix3d> ldlt(weight);
  Matrix3d T = ldlt.transpositionsP() * Matrix3d::Identity();
  T = ldlt.matrixU() * T;
  return ldlt.vectorD().cwiseMax(0.0).cwiseSqrt().asDiagonal() * T;
}

// Writes rows one residual after the other.
class Writer {
 public:
  Writer(ResidualRows& rows, const KinematicTree& tree, const KinematicWorkspace& ws)
      : rows_(rows), tree_(tree), ws_(ws) {
    rows_.count = 0;
    rows_.A.setZero();
  }

  const RigidTransform& X_WB(int link) const { return ws_.X_WB[static_cast<std::size_t>(link)]; }

  // T e in the next rows; their A is still zero.
  template <int kRows>
  void residual(const Eigen::Matrix<double, kRows, 1>& weighted) {
    row_ = rows_.count;
    rows_.count += kRows;
    rows_.b.segment<kRows>(row_) = weighted;
  }
  // A += T · (derivative of a point of the link).
  template <int kRows>
  void point(int link, const Vector3d& p_W, const Eigen::Matrix<double, kRows, 3>& T) {
    for_each_mover(tree_, ws_, link, [&](int x, int b, const Vector6d& S, double scale) {
      const Vector3d r = p_W - X_WB(b).p;
      rows_.A.block<kRows, 1>(row_, x) += scale * T * (S.tail<3>() + S.head<3>().cross(r));
    });
  }
  // A += T · (angular velocity of the link).
  void turn(int link, const Matrix3d& T) {
    for_each_mover(tree_, ws_, link, [&](int x, int, const Vector6d& S, double scale) {
      rows_.A.block<3, 1>(row_, x) += scale * T * S.head<3>();
    });
  }
  // A += slope · (derivative of v by the unknown that drives it).
  void coordinate(int v, double slope) {
    for (int c = tree_.coupling_of_v[static_cast<std::size_t>(v)]; c >= 0;
         c = tree_.coupling_of_v[static_cast<std::size_t>(v)]) {
      slope *= ws_.coupling_slope[static_cast<std::size_t>(c)];
      v = tree_.couplings[static_cast<std::size_t>(c)].independent_v;
    }
    const int x = tree_.unknown_of_v[static_cast<std::size_t>(v)];
    if (x >= 0) rows_.A(row_, x) += slope;
  }

 private:
  ResidualRows& rows_;
  const KinematicTree& tree_;
  const KinematicWorkspace& ws_;
  int row_ = 0;
};

void write_positions(const IkProblem& problem, const IkTargets& targets, Writer& out) {
  for (std::size_t i = 0; i < problem.positions.size(); ++i) {
    if (std::isnan(targets.positions[i].x())) continue;
    const PositionResidual& r = problem.positions[i];
    const Matrix3d T = root(position_weight(problem, targets, i));
    const Vector3d p = out.X_WB(r.link) * r.p_BP;
    out.residual<3>(T * (targets.positions[i] - p));  // (1)
    out.point<3>(r.link, p, -T);                      // (13)
  }
}

void write_orientations(const IkProblem& problem, const IkTargets& targets, Writer& out) {
  for (std::size_t i = 0; i < problem.orientations.size(); ++i) {
    if (std::isnan(targets.orientations[i](0, 0))) continue;
    const OrientationResidual& r = problem.orientations[i];
    const Matrix3d T = root(r.weight);
    const Matrix3d R_WF = out.X_WB(r.link).R * r.R_BF;
    const Vector3d gamma = rotation_vector(targets.orientations[i] * R_WF.transpose());
    out.residual<3>(T * gamma);                            // (2)
    out.turn(r.link, -(T * rotation_vector_rate(gamma)));  // (14)
  }
}

void write_distances(const IkProblem& problem, const IkTargets& targets, Writer& out) {
  for (std::size_t i = 0; i < problem.distances.size(); ++i) {
    if (std::isnan(targets.distances[i])) continue;
    const DistanceResidual& r = problem.distances[i];
    const Vector3d pa = out.X_WB(r.link_a) * r.p_AP, pb = out.X_WB(r.link_b) * r.p_BQ;
    const double length = (pa - pb).norm();
    const double T = std::sqrt(r.weight);
    // Between coincident points there is no direction; the residual then has a zero row.
    const Vector3d direction = length > 0.0 ? Vector3d((pa - pb) / length) : Vector3d::Zero();
    out.residual<1>(Eigen::Matrix<double, 1, 1>(T * (targets.distances[i] - length)));  // (3)
    out.point<1>(r.link_a, pa, -T * direction.transpose());                             // (15)
    out.point<1>(r.link_b, pb, T * direction.transpose());
  }
}

void write_wires(const IkProblem& problem, const KinematicWorkspace& ws, Writer& out) {
  for (const WireResidual& r : problem.wires) {
    const double excess = wire_length(problem, r, ws) - r.natural_length;
    if (!(excess > 0.0)) continue;
    const double T = std::sqrt(r.weight);
    out.residual<1>(Eigen::Matrix<double, 1, 1>(-T * excess));  // (38)
    for_each_wire_point(problem, r, ws, [&](int i, const Vector3d& p, const Vector3d& u) {
      out.point<1>(wire_point(problem, r, i).link, p, -T * u.transpose());
    });
  }
}

void write_loops(const IkProblem& problem, Writer& out) {
  for (const CoincidenceResidual& r : problem.coincidences) {
    const Matrix3d T = std::sqrt(r.weight) * Matrix3d::Identity();
    const Vector3d pa = out.X_WB(r.link_a) * r.p_AP, pb = out.X_WB(r.link_b) * r.p_BQ;
    out.residual<3>(T * (pa - pb));
    out.point<3>(r.link_a, pa, T);
    out.point<3>(r.link_b, pb, -T);
  }
  for (const AlignmentResidual& r : problem.alignments) {
    const Matrix3d T = std::sqrt(r.weight) * Matrix3d::Identity();
    const Matrix3d R_WF = out.X_WB(r.link_a).R * r.R_AF;
    const Matrix3d R_WG = out.X_WB(r.link_b).R * r.R_BG;
    out.residual<3>(T * rotation_vector(R_WF * R_WG.transpose()));
    out.turn(r.link_a, T);  // γ ≈ 0 on a closed loop, so K_γ ≈ E; and K_γᵀγ = γ anywhere
    out.turn(r.link_b, -T);
  }
}

void write_coordinates(const IkProblem& problem, const IkTargets& targets,
                       const KinematicWorkspace& ws, Writer& out) {
  for (std::size_t i = 0; i < problem.coordinates.size(); ++i) {
    if (std::isnan(targets.coordinates[i])) continue;
    const CoordinateResidual& r = problem.coordinates[i];
    const double T = std::sqrt(coordinate_weight(problem, targets, i));
    const double e = targets.coordinates[i] - ws.q[static_cast<std::size_t>(r.q)];
    out.residual<1>(Eigen::Matrix<double, 1, 1>(T * e));
    out.coordinate(r.v, -T);
  }
}

}  // namespace

int row_count(const IkProblem& problem) {
  return static_cast<int>(3 * (problem.positions.size() + problem.orientations.size() +
                               problem.coincidences.size() + problem.alignments.size()) +
                          problem.distances.size() + problem.wires.size() +
                          problem.coordinates.size());
}

ResidualRows::ResidualRows(const KinematicTree& tree, const IkProblem& problem)
    : A(row_count(problem), tree.unknown_count()), b(row_count(problem)) {}

void ResidualRows::update(const KinematicTree& tree, const IkProblem& problem,
                          const IkTargets& targets, const KinematicWorkspace& ws) {
  Writer out(*this, tree, ws);
  write_positions(problem, targets, out);
  write_orientations(problem, targets, out);
  write_distances(problem, targets, out);
  write_wires(problem, ws, out);
  write_loops(problem, out);
  write_coordinates(problem, targets, ws, out);
}

}  // namespace sinew
