#include "ik/curvature.h"

#include <gtest/gtest.h>

#include "tests/ik/random_problem.h"

namespace sinew {
namespace {

using Eigen::Matrix3d;
using Eigen::Matrix3Xd;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr unsigned kSeeds = 12;
constexpr double kTolerance = 1e-11;  // relative: sums of the same terms in other orders

// JᵀΣJ, residual by residual from Jacobians. Frames of alignments must be parallel.
MatrixXd explicit_curvature(const RandomProblem& p, const KinematicWorkspace& ws) {
  const int n = p.tree.unknown_count();
  MatrixXd H = MatrixXd::Zero(n, n);
  const auto place = [&](int link, const Vector3d& p_BP) -> Vector3d {
    return ws.X_WB[static_cast<std::size_t>(link)] * p_BP;
  };
  const auto J_Bp = [&](int link, const Vector3d& p_BP) {
    Matrix3Xd J(3, n);
    station_jacobian(p.tree, ws, link, p_BP, J);
    return J;
  };
  const auto J_Bw = [&](int link) {
    Matrix3Xd J(3, n);
    rotation_jacobian(p.tree, ws, link, J);
    return J;
  };
  for (std::size_t i = 0; i < p.problem.positions.size(); ++i) {
    if (!p.targets.positions[i].allFinite()) continue;
    const PositionResidual& r = p.problem.positions[i];
    H += J_Bp(r.link, r.p_BP).transpose() * r.weight * J_Bp(r.link, r.p_BP);
  }
  for (std::size_t i = 0; i < p.problem.orientations.size(); ++i) {
    if (!p.targets.orientations[i].allFinite()) continue;
    const OrientationResidual& r = p.problem.orientations[i];
    const Matrix3d R_WF = ws.X_WB[static_cast<std::size_t>(r.link)].R * r.R_BF;
    const MatrixXd J =
        rotation_vector_rate(rotation_vector(p.targets.orientations[i] * R_WF.transpose())) *
        J_Bw(r.link);
    H += J.transpose() * r.weight * J;
  }
  for (std::size_t i = 0; i < p.problem.distances.size(); ++i) {
    const DistanceResidual& r = p.problem.distances[i];
    const Vector3d d = place(r.link_a, r.p_AP) - place(r.link_b, r.p_BQ);
    if (std::isnan(p.targets.distances[i])) continue;
    const MatrixXd J =
        d.normalized().transpose() * (J_Bp(r.link_a, r.p_AP) - J_Bp(r.link_b, r.p_BQ));
    H += r.weight * J.transpose() * J;
  }
  for (const WireResidual& r : p.problem.wires) {
    if (wire_length(p.problem, r, ws) <= r.natural_length) continue;
    MatrixXd J = MatrixXd::Zero(1, n);
    for_each_wire_point(p.problem, r, ws, [&](int k, const Vector3d&, const Vector3d& u) {
      const WirePoint& point = wire_point(p.problem, r, k);
      J += u.transpose() * J_Bp(point.link, point.p_BP);
    });
    H += r.weight * J.transpose() * J;
  }
  for (const CoincidenceResidual& r : p.problem.coincidences) {
    const MatrixXd J = J_Bp(r.link_a, r.p_AP) - J_Bp(r.link_b, r.p_BQ);
    H += r.weight * J.transpose() * J;
  }
  for (const AlignmentResidual& r : p.problem.alignments) {
    const MatrixXd J = J_Bw(r.link_a) - J_Bw(r.link_b);
    H += r.weight * J.transpose() * J;
  }
  return H;
}

// Row of the derivative of every coordinate target with respect to x, by the couplings' slopes.
void add_coordinate_curvature(const RandomProblem& p, const KinematicWorkspace& ws, MatrixXd& H) {
  for (std::size_t i = 0; i < p.problem.coordinates.size(); ++i) {
    if (std::isnan(p.targets.coordinates[i])) continue;
    double slope = 1.0;
    int v = p.problem.coordinates[i].v;
    for (int c = p.tree.coupling_of_v[static_cast<std::size_t>(v)]; c >= 0;
         c = p.tree.coupling_of_v[static_cast<std::size_t>(v)]) {
      slope *= ws.coupling_slope[static_cast<std::size_t>(c)];
      v = p.tree.couplings[static_cast<std::size_t>(c)].independent_v;
    }
    const int x = p.tree.unknown_of_v[static_cast<std::size_t>(v)];
    if (x >= 0)
      H(x, x) += p.targets.coordinate_scales[i] * p.problem.coordinates[i].weight * slope * slope;
  }
}

void make_alignments_parallel(RandomProblem& p, const KinematicWorkspace& ws) {
  for (AlignmentResidual& r : p.problem.alignments) {
    r.R_BG = ws.X_WB[static_cast<std::size_t>(r.link_b)].R.transpose() *
             ws.X_WB[static_cast<std::size_t>(r.link_a)].R * r.R_AF;
  }
}

class Curvature : public testing::TestWithParam<bool> {};

TEST_P(Curvature, IsThatOfTheExplicitJacobians) {
  for (unsigned seed = 0; seed < kSeeds; ++seed) {
    RandomProblem p = random_problem(seed, GetParam());
    const KinematicWorkspace ws = p.workspace();
    make_alignments_parallel(p, ws);
    MatrixXd expected = explicit_curvature(p, ws);
    add_coordinate_curvature(p, ws, expected);
    CostCurvature curvature(p.tree, p.problem);
    MatrixXd H(expected.rows(), expected.cols());
    curvature.update(p.tree, p.problem, p.targets, ws);
    curvature.matrix(p.problem, p.targets, ws, H);
    EXPECT_LE((H - expected).cwiseAbs().maxCoeff(), kTolerance * expected.cwiseAbs().maxCoeff())
        << seed;
    EXPECT_EQ(H, H.transpose());
  }
}

// An unknown that couplers make move others has an upper bound in its place.
TEST_P(Curvature, HasTheDiagonalOfItsMatrix) {
  int bounds = 0;
  for (unsigned seed = 0; seed < kSeeds; ++seed) {
    const RandomProblem p = random_problem(seed, GetParam());
    const KinematicWorkspace ws = p.workspace();
    CostCurvature curvature(p.tree, p.problem);
    MatrixXd H(p.tree.unknown_count(), p.tree.unknown_count());
    VectorXd diagonal(p.tree.unknown_count());
    curvature.update(p.tree, p.problem, p.targets, ws);
    curvature.matrix(p.problem, p.targets, ws, H);
    curvature.diagonal(p.tree, p.problem, p.targets, ws, diagonal);
    std::vector<bool> drives(static_cast<std::size_t>(p.tree.v_count()), false);
    for (const KinematicTree::Coupling& c : p.tree.couplings) {
      drives[static_cast<std::size_t>(c.independent_v)] = true;
    }
    const double rounding = kTolerance * H.cwiseAbs().maxCoeff();
    for (int x = 0; x < diagonal.size(); ++x) {
      EXPECT_GE(diagonal[x], H(x, x) - rounding) << seed << ": " << x;
      if (drives[static_cast<std::size_t>(p.tree.unknown_v[static_cast<std::size_t>(x)])]) {
        ++bounds;
      } else {
        EXPECT_NEAR(diagonal[x], H(x, x), rounding) << seed << ": " << x;
      }
    }
  }
  EXPECT_GE(bounds, 10);
}

// Where all residuals vanish the cost has no other curvature.
TEST_P(Curvature, IsThatOfTheGradientsDifferencesAtZeroResidual) {
  constexpr double kStep = 1e-6;
  for (unsigned seed = 0; seed < kSeeds; ++seed) {
    RandomProblem p = only(random_problem(seed, GetParam()), ResidualKind::kPosition);
    const KinematicWorkspace at = p.workspace();
    for (std::size_t i = 0; i < p.targets.positions.size(); ++i) {
      const PositionResidual& r = p.problem.positions[i];
      p.targets.positions[i] = at.X_WB[static_cast<std::size_t>(r.link)] * r.p_BP;
    }
    CostCurvature curvature(p.tree, p.problem);
    MatrixXd H(p.tree.unknown_count(), p.tree.unknown_count());
    curvature.update(p.tree, p.problem, p.targets, at);
    curvature.matrix(p.problem, p.targets, at, H);
    KinematicWorkspace ws(p.tree);
    VectorXd ahead(H.rows()), behind(H.rows());
    std::vector<double> step(static_cast<std::size_t>(H.rows()), 0.0);
    const auto gradient_after = [&](int x, double h, VectorXd& g) {
      step[static_cast<std::size_t>(x)] = h;
      advance(p.tree, p.q, step, ws.q);
      step[static_cast<std::size_t>(x)] = 0.0;
      update_kinematics(p.tree, ws);
      decomposed_gradient(p.tree, p.problem, p.targets, ws, g);
    };
    for (int x = 0; x < H.cols(); ++x) {
      gradient_after(x, kStep, ahead);
      gradient_after(x, -kStep, behind);
      // Differences of a gradient that is zero in between leave its third derivatives times h.
      EXPECT_LE((H.col(x) - (ahead - behind) / (2.0 * kStep)).cwiseAbs().maxCoeff(),
                1e-8 * H.cwiseAbs().maxCoeff())
          << seed << ": " << x;
    }
  }
}

std::string name_of(const testing::TestParamInfo<bool>& info) {
  return info.param ? "Quaternions" : "Angles";
}

INSTANTIATE_TEST_SUITE_P(Both, Curvature, testing::Bool(), name_of);

}  // namespace
}  // namespace sinew
