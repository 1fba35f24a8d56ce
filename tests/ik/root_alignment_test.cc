#include "ik/root_alignment.h"

#include <gtest/gtest.h>

#include <random>

#include "tests/ik/walker.h"

namespace sinew {
namespace {

using Eigen::Matrix3Xd;
using Eigen::Vector3d;
using Eigen::VectorXd;

Matrix3Xd cloud(int count, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> value(-1.0, 1.0);
  Matrix3Xd points(3, count);
  for (Eigen::Index i = 0; i < points.size(); ++i) points.data()[i] = value(random);
  return points;
}

RigidTransform some_motion(double angle) {
  return {Eigen::AngleAxisd(angle, Vector3d(0.3, -0.8, 0.5).normalized()).toRotationMatrix(),
          Vector3d(1.0, -2.0, 0.5)};
}

TEST(RigidFit, FindsTheMotionThatMovedThePoints) {
  for (const double angle : {0.0, 0.5, 3.0, M_PI}) {
    const RigidTransform X = some_motion(angle);
    const Matrix3Xd points = cloud(5, 1);
    const Matrix3Xd moved = (X.R * points).colwise() + X.p;
    const auto found = rigid_fit(points, moved, VectorXd::LinSpaced(5, 1.0, 3.0));
    ASSERT_TRUE(found);
    EXPECT_LE((found->R - X.R).cwiseAbs().maxCoeff(), 1e-12) << angle;
    EXPECT_LE((found->p - X.p).cwiseAbs().maxCoeff(), 1e-12) << angle;
  }
}

// At the least sum of squares no small turn or shift lowers it: its derivatives vanish.
TEST(RigidFit, IsWhereTheWeightedSumOfSquaresIsStationary) {
  const Matrix3Xd points = cloud(6, 2), measured = cloud(6, 3);
  const VectorXd weights = VectorXd::LinSpaced(6, 0.5, 4.0);
  const RigidTransform X = rigid_fit(points, measured, weights).value();
  EXPECT_NEAR(X.R.determinant(), 1.0, 1e-12);
  Vector3d force = Vector3d::Zero(), moment = Vector3d::Zero();
  for (int i = 0; i < 6; ++i) {
    const Vector3d at = X * points.col(i), pull = weights[i] * (measured.col(i) - at);
    force += pull;
    moment += at.cross(pull);
  }
  EXPECT_LE(force.norm(), 1e-12);
  EXPECT_LE(moment.norm(), 1e-12);
}

TEST(RigidFit, GivesNoMirrorImageForMirroredPoints) {
  const Matrix3Xd points = cloud(6, 4);
  const Matrix3Xd mirrored = Vector3d(-1.0, 1.0, 1.0).asDiagonal() * points;
  EXPECT_NEAR(rigid_fit(points, mirrored, VectorXd::Ones(6))->R.determinant(), 1.0, 1e-12);
}

TEST(RigidFit, SaysNothingWherePointsLeaveATurnOpen) {
  const Matrix3Xd line = Vector3d(1.0, 2.0, 3.0) * Eigen::RowVector3d(0.0, 0.5, 1.0);
  EXPECT_FALSE(rigid_fit(line, line, VectorXd::Ones(3)));
  const Matrix3Xd two = cloud(2, 5);
  EXPECT_FALSE(rigid_fit(two, two, VectorXd::Ones(2)));
  const Matrix3Xd three = cloud(3, 6);
  EXPECT_TRUE(rigid_fit(three, three, VectorXd::Ones(3)));
}

class AlignRoots : public testing::TestWithParam<bool> {};
INSTANTIATE_TEST_SUITE_P(Quaternions, AlignRoots, testing::Bool());

// The walker as it stands is moved as a whole: the root alone has to follow.
TEST_P(AlignRoots, MeetsABodyThatWasMovedAsAWhole) {
  const Walker walker(GetParam());
  for (const double angle : {0.4, 2.0, 3.1}) {
    IkTargets targets = walker.targets_at(walker.tree.default_q);
    const RigidTransform X = some_motion(angle);
    for (Vector3d& p : targets.positions) p = X * p;
    std::vector<double> q = walker.tree.default_q;
    align_roots(walker.tree, walker.problem, targets, {}, q);
    const IkTargets met = walker.targets_at(q);
    for (std::size_t i = 0; i < met.positions.size(); ++i) {
      EXPECT_LE((met.positions[i] - targets.positions[i]).norm(), 1e-12) << angle;
    }
  }
}

TEST(AlignRoots, TakesAnyOrderAndHandOfTheAxes) {
  for (const bool left_handed : {false, true}) {
    MusculoskeletalModel model = empty_model();
    const int body = add_body(model, 0, Joint::Kind::kCustom, "rrrttt", {0, 0, 0});
    Joint& joint = model.joints[static_cast<std::size_t>(body) - 1];
    const Vector3d turns[] = {Vector3d::UnitZ(), Vector3d::UnitX(),
                              (left_handed ? -1.0 : 1.0) * Vector3d::UnitY()};
    for (int i = 0; i < 3; ++i) {
      joint.axes[i] = {
          turns[i], joint.coordinates[static_cast<std::size_t>(i)], {LinearFunction{1.0, 0.0}}};
      joint.axes[i + 3] = {Vector3d::Unit((i + 1) % 3),
                           joint.coordinates[static_cast<std::size_t>(i) + 3],
                           {LinearFunction{1.0, 0.0}}};
    }
    const KinematicTree tree = compile_tree(model);
    const Matrix3Xd points = cloud(4, 7);
    IkProblem problem;
    for (int i = 0; i < 4; ++i) problem.positions.push_back({body, points.col(i)});
    IkTargets targets(problem);
    const RigidTransform X = some_motion(2.5);
    for (int i = 0; i < 4; ++i) {
      targets.positions[static_cast<std::size_t>(i)] = X * Vector3d(points.col(i));
    }
    std::vector<double> q = tree.default_q;
    align_roots(tree, problem, targets, {}, q);
    KinematicWorkspace ws(tree);
    ws.q = q;
    update_poses(tree, ws);
    EXPECT_LE((ws.X_WB[1].R - X.R).cwiseAbs().maxCoeff(), 1e-12) << left_handed;
    EXPECT_LE((ws.X_WB[1].p - X.p).cwiseAbs().maxCoeff(), 1e-12) << left_handed;
  }
}

// A planar root reaches what lies in its plane, from half a turn away too.
TEST(AlignRoots, GoesAsNearAsAPlanarJointCan) {
  MusculoskeletalModel model = empty_model();
  const int body = add_body(model, 0, Joint::Kind::kPlanar, "rtt", {0, 0, 0});
  const KinematicTree tree = compile_tree(model);
  const Matrix3Xd points = cloud(4, 8);
  IkProblem problem;
  for (int i = 0; i < 4; ++i) problem.positions.push_back({body, points.col(i)});
  IkTargets targets(problem);
  const RigidTransform X{Eigen::AngleAxisd(3.1, Vector3d::UnitZ()).toRotationMatrix(),
                         Vector3d(0.7, -0.4, 0.0)};
  for (int i = 0; i < 4; ++i) {
    targets.positions[static_cast<std::size_t>(i)] = X * Vector3d(points.col(i));
  }
  std::vector<double> q = tree.default_q;
  align_roots(tree, problem, targets, {}, q);
  EXPECT_NEAR(std::remainder(q[0] - 3.1, 2.0 * M_PI), 0.0, 1e-6);
  EXPECT_NEAR(q[1], 0.7, 1e-6);
  EXPECT_NEAR(q[2], -0.4, 1e-6);
}

TEST(AlignRoots, LeavesARootWhoseMarkersAreTooFew) {
  const Walker walker;
  IkTargets targets = walker.targets_at(walker.pose(1, 0.5));
  for (std::size_t i = 2; i < targets.positions.size(); ++i) targets.positions[i].setConstant(kNaN);
  std::vector<double> q = walker.tree.default_q;
  align_roots(walker.tree, walker.problem, targets, {}, q);
  EXPECT_EQ(q, walker.tree.default_q);
}

TEST(AlignRoots, CountsOnlyTheLinksItIsGiven) {
  const Walker walker;
  const std::vector<double> pose = walker.pose(3, 0.6);
  const IkTargets targets = walker.targets_at(pose);
  std::vector<char> pelvis(walker.tree.links.size(), 0);
  pelvis[1] = 1;
  std::vector<double> q = walker.tree.default_q;
  align_roots(walker.tree, walker.problem, targets, pelvis, q);
  for (int i = 0; i < 6; ++i) {
    EXPECT_NEAR(q[static_cast<std::size_t>(i)], pose[static_cast<std::size_t>(i)], 1e-12);
  }
}

}  // namespace
}  // namespace sinew
