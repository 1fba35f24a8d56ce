#include <gtest/gtest.h>

#include "ik/curvature.h"
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
  const FarProblem p;
  const KinematicWorkspace ws = p.workspace(3, 0.3);
  int taut = 0;
  for (const WireResidual& r : p.tracking.problem.wires) {
    taut += wire_length(p.tracking.problem, r, ws) > r.natural_length;
  }
  EXPECT_GT(taut, 200);
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

}  // namespace
}  // namespace sinew
