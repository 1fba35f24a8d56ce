#include <gtest/gtest.h>

#include "ik/curvature.h"
#include "ik/supernodal_cholesky.h"
#include "tests/ik/whole_body_problem.h"

namespace sinew {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

// The detailed whole body far from its targets, with residuals of every kind that Newton's
// curvature has exactly, across any joints.
struct FarProblem : WholeBodyProblem {
  IkTargets targets{IkProblem{}};

  FarProblem() {
    IkProblem& problem = tracking.problem;
    for (const int link : {3, 17, 40, 61}) {
      problem.orientations.push_back(
          {link, Eigen::Matrix3d::Identity(), (0.5 + 0.01 * link) * Eigen::Matrix3d::Identity()});
      problem.distances.push_back({link, 70 - link, {0.1, 0.2, -0.1}, {0.0, 0.1, 0.2}, 2.0});
    }
    targets = targets_at(4, 0.3);
    for (std::size_t i = 0; i < problem.orientations.size(); ++i) {
      targets.orientations[i] =
          Eigen::AngleAxisd(0.7, Vector3d(1.0, -2.0, 0.5).normalized()).toRotationMatrix();
      targets.distances[i] = 0.3;
    }
  }

  // By differences of decomposed gradients, with the bounds left aside.
  MatrixXd hessian_by_differences(const KinematicWorkspace& at) const {
    constexpr double kStep = 1e-6;
    const int n = tree.unknown_count();
    MatrixXd H(n, n);
    VectorXd ahead(n), behind(n);
    KinematicWorkspace ws(tree);
    for (int x = 0; x < n; ++x) {
      const auto q = static_cast<std::size_t>(
          tree.q_of_v[static_cast<std::size_t>(tree.unknown_v[static_cast<std::size_t>(x)])]);
      for (const double side : {-1.0, 1.0}) {
        ws.q = at.q;
        ws.q[q] += side * kStep;
        update_kinematics(tree, ws);
        decomposed_gradient(tree, tracking.problem, targets, ws, side < 0.0 ? behind : ahead);
      }
      H.col(x) = (ahead - behind) / (2.0 * kStep);
    }
    return H;
  }
};

TEST(NewtonCurvature, IsThatOfTheGradientsDifferences) {
  FarProblem p;
  p.tracking.problem.wires.clear();
  const KinematicWorkspace ws = p.workspace(3, 0.3);
  const MatrixXd expected = p.hessian_by_differences(ws);
  CostCurvature curvature(p.tree, p.tracking.problem);
  MatrixXd newton(expected.rows(), expected.cols()), gauss_newton = newton;
  curvature.update(p.tree, p.tracking.problem, p.targets, ws, true);
  curvature.matrix(p.tracking.problem, p.targets, ws, newton);
  curvature.update(p.tree, p.tracking.problem, p.targets, ws);
  curvature.matrix(p.tracking.problem, p.targets, ws, gauss_newton);
  const double scale = expected.cwiseAbs().maxCoeff();
  EXPECT_LT((newton - expected).cwiseAbs().maxCoeff(), 1e-7 * scale);
  EXPECT_GT((gauss_newton - expected).cwiseAbs().maxCoeff(), 1e-3 * scale);
}

// What keeps a wire under tension from being turned is the rest of its curvature, exactly so for
// shifts of the virtual links that only wires hold.
TEST(TensionStiffness, IsWhatGaussNewtonLeavesOut) {
  const FarProblem p;
  const IkProblem& problem = p.tracking.problem;
  const KinematicWorkspace ws = p.workspace(3, 0.3);
  const int n = p.tree.unknown_count();
  CostCurvature apart(p.tree, problem, CostCurvature::Wires::kApart);
  apart.update(p.tree, problem, p.targets, ws);
  SupernodalCholesky factor(n, apart.reversed_cliques(p.tree, problem));
  std::vector<int> offsets;
  for (const CostCurvature::Entry& entry : apart.entries()) {
    offsets.push_back(factor.offset(entry.row, entry.column));
  }
  int taut = 0;
  for (std::size_t i = 0; i < problem.wires.size(); ++i) {
    const WireResidual& r = problem.wires[i];
    const double excess = wire_length(problem, r, ws) - r.natural_length;
    if (!(excess > 0.0)) continue;
    ++taut;
    apart.add_tension(problem, i, ws, r.weight * excess, offsets, factor.values());
  }
  EXPECT_GT(taut, 200);
  MatrixXd gauss_newton(n, n);
  CostCurvature curvature(p.tree, problem);
  curvature.update(p.tree, problem, p.targets, ws);
  curvature.matrix(problem, p.targets, ws, gauss_newton);
  const MatrixXd expected = p.hessian_by_differences(ws) - gauss_newton;

  std::vector<int> shifts;
  for (int x = 0; x < n; ++x) {
    const int v = p.tree.unknown_v[static_cast<std::size_t>(x)];
    const int link = p.tree.link_of_v[static_cast<std::size_t>(v)];
    const bool is_virtual =
        std::find(p.tracking.virtual_links.begin(), p.tracking.virtual_links.end(), link) !=
        p.tracking.virtual_links.end();
    if (is_virtual && ws.S[static_cast<std::size_t>(v)].head<3>().isZero(0.0)) shifts.push_back(x);
  }
  EXPECT_EQ(shifts.size(), 3 * p.tracking.virtual_links.size());
  double largest = 0.0;
  for (const int x : shifts) {
    for (const int y : shifts) {
      const int offset = factor.offset(n - 1 - std::min(x, y), n - 1 - std::max(x, y));
      const double added = offset < 0 ? 0.0 : factor.values()[static_cast<std::size_t>(offset)];
      largest = std::max(largest, std::abs(added));
      EXPECT_NEAR(added, expected(x, y), 1e-6) << x << ", " << y;
    }
  }
  EXPECT_GT(largest, 1.0);
}

}  // namespace
}  // namespace sinew
