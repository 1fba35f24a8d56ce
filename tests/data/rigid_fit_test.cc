#include "data/rigid_fit.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

namespace sinew {
namespace {

using Eigen::Matrix3d;
using Eigen::Matrix3Xd;
using Eigen::Vector3d;
using Eigen::VectorXd;

Matrix3Xd cloud() {
  Matrix3Xd points(3, 4);
  points << 0.0, 0.3, 0.0, 0.1,  //
      0.0, 0.0, 0.2, 0.1,        //
      0.0, 0.0, 0.0, 0.4;
  return points;
}

TEST(RigidFit, FindsATurnAndAShift) {
  const Matrix3d R = Eigen::AngleAxisd(2.1, Vector3d(1.0, -2.0, 0.5).normalized()).matrix();
  const Vector3d t(0.4, -1.0, 2.0);
  const Matrix3Xd measured = (R * cloud()).colwise() + t;
  const RigidFit fit = fit_rigidly(cloud(), measured, VectorXd::Ones(4));
  EXPECT_LT((fit.R - R).norm(), 1e-12);
  EXPECT_LT((fit.t - t).norm(), 1e-12);
  EXPECT_LT(fit.misfit, 1e-12);
}

// Where a point weighs nothing, it may be anywhere.
TEST(RigidFit, FollowsTheWeights) {
  Matrix3Xd measured = cloud();
  measured.col(3) += Vector3d(1.0, 1.0, 1.0);
  VectorXd weights = VectorXd::Ones(4);
  weights[3] = 0.0;
  const RigidFit fit = fit_rigidly(cloud(), measured, weights);
  EXPECT_LT((fit.R - Matrix3d::Identity()).norm(), 1e-12);
  EXPECT_LT(fit.misfit, 1e-12);
}

// The optimum is stationary: no small turn or shift makes the sum of squares less.
TEST(RigidFit, IsTheLeast) {
  Matrix3Xd measured = cloud();
  measured.col(0) += Vector3d(0.02, -0.01, 0.03);
  measured.col(2) += Vector3d(-0.03, 0.02, 0.01);
  const VectorXd weights = Vector3d(1.0, 2.0, 0.5).homogeneous();
  const RigidFit fit = fit_rigidly(cloud(), measured, weights);
  const auto cost = [&](const Matrix3d& R, const Vector3d& t) -> double {
    const Matrix3Xd left = ((R * cloud()).colwise() + t) - measured;
    return left.colwise().squaredNorm().dot(weights.transpose());
  };
  const double least = cost(fit.R, fit.t);
  EXPECT_NEAR(fit.misfit, std::sqrt(least / weights.sum()), 1e-12);
  for (int axis = 0; axis < 3; ++axis) {
    for (const double step : {-1e-4, 1e-4}) {
      const Vector3d unit = Vector3d::Unit(axis);
      EXPECT_GT(cost(fit.R, fit.t + step * unit), least);
      EXPECT_GT(cost(Eigen::AngleAxisd(step, unit) * fit.R, fit.t), least);
    }
  }
}

// Of a mirror image the best rotation, which meets it badly.
TEST(RigidFit, NeverReflects) {
  Matrix3Xd mirrored = cloud();
  mirrored.row(0) *= -1.0;
  const RigidFit fit = fit_rigidly(cloud(), mirrored, VectorXd::Ones(4));
  EXPECT_NEAR(fit.R.determinant(), 1.0, 1e-12);
  EXPECT_GT(fit.misfit, 0.01);
}

TEST(RigidFit, TellsPointsOnOneLine) {
  Matrix3Xd line(3, 3);
  line << 0.0, 0.1, 0.2, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0;
  const RigidFit fit = fit_rigidly(line, line, VectorXd::Ones(3));
  EXPECT_NEAR(fit.length, std::sqrt(0.02), 1e-12);
  EXPECT_LT(fit.width, 1e-12);
}

}  // namespace
}  // namespace sinew
