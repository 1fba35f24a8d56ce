#include "ik/newton_raphson.h"

#include <gtest/gtest.h>

#include <Eigen/QR>
#include <cmath>

#include "ik/minimizer.h"
#include "ik/residual_rows.h"
#include "tests/ik/random_problem.h"
#include "tests/ik/small_model.h"

namespace sinew {
namespace {

using Eigen::Vector3d;

// Shoulder, elbow and wrist with six coordinates, for the hand's six equations.
struct Arm {
  MusculoskeletalModel model = empty_model();
  KinematicTree tree;
  IkProblem problem;

  explicit Arm(bool quaternions) {
    const int upper = add_body(model, 0, Joint::Kind::kBall, "rrr");
    const int lower = add_body(model, upper, Joint::Kind::kPin, "r", {0.3, 0, 0});
    const int hand = add_body(model, lower, Joint::Kind::kUniversal, "rr", {0.25, 0, 0});
    tree = compile_tree(model, {.quaternions = quaternions});
    problem.positions = {{hand, Vector3d::Zero()}};
    problem.orientations = {{hand}};
  }

  // The shoulder turned anyhow, the elbow by `elbow`, the wrist bent.
  std::vector<double> pose(double elbow, double change = 0.0) const {
    const std::vector<double> step = {0.3 + change, -0.2 - change, 0.5 + change,
                                      elbow,        0.4 + change,  0.6 - change};
    std::vector<double> q = tree.default_q;
    advance(tree, tree.default_q, step, q);
    return q;
  }

  IkTargets targets_at(const std::vector<double>& q) const {
    KinematicWorkspace ws(tree);
    ws.q = q;
    update_poses(tree, ws);
    const RigidTransform& X_WH = ws.X_WB.back();
    IkTargets targets(problem);
    targets.positions[0] = X_WH.p;
    targets.orientations[0] = X_WH.R;
    return targets;
  }
};

class NewtonRaphsonOf : public testing::TestWithParam<std::tuple<bool, bool>> {
 protected:
  Arm arm{std::get<0>(GetParam())};
  NewtonRaphson::Options options{.line_search = std::get<1>(GetParam()), .record_iterations = true};
};
INSTANTIATE_TEST_SUITE_P(QuaternionsLineSearch, NewtonRaphsonOf,
                         testing::Combine(testing::Bool(), testing::Bool()));

TEST_P(NewtonRaphsonOf, ConvergesQuadraticallyAtRegularPostures) {
  NewtonRaphson newton(arm.tree, arm.problem, options);
  const IkTargets targets = arm.targets_at(arm.pose(0.8));
  std::vector<double> q = arm.pose(0.8, 0.15);
  const Summary& summary = newton.solve(targets, q);
  EXPECT_EQ(summary.termination, Termination::kSolved) << summary.message();
  EXPECT_EQ(summary.detail, "KIN_SUCCESS");
  EXPECT_LE(summary.iterations, 7);
  EXPECT_LE(summary.final_cost, 1e-24);
  ASSERT_EQ(static_cast<int>(summary.rows.size()), summary.iterations);
  double before = std::sqrt(2.0 * summary.initial_cost);
  for (const IterationRow& row : summary.rows) {
    const double e = std::sqrt(2.0 * row.f);
    EXPECT_LE(e, 20.0 * before * before + 1e-15);  // measured: 5 to 16
    EXPECT_NEAR(row.step_length, 1.0, 1e-8);       // full steps all the way
    before = e;
  }
}

TEST_P(NewtonRaphsonOf, SaysThatAnOutstretchedArmIsSingular) {
  NewtonRaphson newton(arm.tree, arm.problem, options);
  const IkTargets targets = arm.targets_at(arm.pose(0.8));
  const std::vector<double> straight = arm.pose(0.0);
  std::vector<double> q = straight;
  const Summary& summary = newton.solve(targets, q);
  EXPECT_EQ(summary.termination, Termination::kSingular);
  EXPECT_FALSE(summary.converged());
  EXPECT_EQ(summary.iterations, 0);
  EXPECT_EQ(summary.message().find("the Jacobian is singular after 0 iterations; the cost is "), 0u)
      << summary.message();
  EXPECT_NE(summary.message().find("(KIN_LSETUP_FAIL: "), std::string::npos) << summary.message();
  for (std::size_t i = 0; i < q.size(); ++i) EXPECT_NEAR(q[i], straight[i], 1e-15);
}

// Where the solution itself is singular, what was quadratic is linear at best: e halves.
TEST_P(NewtonRaphsonOf, CreepsTowardsAnOutstretchedSolution) {
  NewtonRaphson newton(arm.tree, arm.problem, options);
  const IkTargets targets = arm.targets_at(arm.pose(0.0));
  std::vector<double> q = arm.pose(0.3, 0.02);
  const Summary& summary = newton.solve(targets, q);
  EXPECT_GE(summary.iterations, 15) << summary.message();
}

TEST_P(NewtonRaphsonOf, FailsBeyondReachWhereLeastSquaresDoNot) {
  IkTargets targets = arm.targets_at(arm.pose(0.0));
  targets.positions[0] *= 1.05;
  NewtonRaphson newton(arm.tree, arm.problem, options);
  std::vector<double> q = arm.pose(0.3);
  const Summary& summary = newton.solve(targets, q);
  EXPECT_FALSE(summary.converged());
  EXPECT_FALSE(summary.detail.empty());
  q = arm.pose(0.3);
  Minimizer minimizer(arm.tree, arm.problem, {});
  const Summary& found = minimizer.minimize(targets, q);
  EXPECT_TRUE(found.converged()) << found.message();
  EXPECT_NEAR(found.final_cost, 0.5 * std::pow(0.05 * 0.55, 2), 1e-4);
}

TEST_P(NewtonRaphsonOf, HasNothingToDoAtTheSolution) {
  const std::vector<double> there = arm.pose(0.8);
  NewtonRaphson newton(arm.tree, arm.problem, options);
  std::vector<double> q = there;
  const Summary& summary = newton.solve(arm.targets_at(there), q);
  EXPECT_EQ(summary.termination, Termination::kSolved);
  EXPECT_EQ(summary.iterations, 0);
  EXPECT_EQ(summary.detail, "KIN_INITIAL_GUESS_OK");
  EXPECT_TRUE(summary.rows.empty());
}

TEST_P(NewtonRaphsonOf, EndsAtOnceWhereTheEquationsAreNoNumbers) {
  NewtonRaphson newton(arm.tree, arm.problem, options);
  const IkTargets targets = arm.targets_at(arm.pose(0.8));
  std::vector<double> q = arm.pose(0.7);
  q[4] = kNaN;
  EXPECT_EQ(newton.solve(targets, q).termination, Termination::kNotFinite);
  q = arm.pose(0.7);
  EXPECT_EQ(newton.solve(targets, q).termination, Termination::kSolved);  // and goes on after
}

// Fewer equations than unknowns: the hand's position alone.
TEST_P(NewtonRaphsonOf, TakesStepsOfLeastNormWhereUnknownsAreLeftOver) {
  arm.problem.orientations.clear();
  const IkTargets targets = [&] {
    IkTargets t(arm.problem);
    t.positions[0] = Vector3d(0.2, 0.3, -0.1);
    return t;
  }();
  const std::vector<double> start = arm.pose(0.8);
  KinematicWorkspace ws(arm.tree);
  ws.q = start;
  update_kinematics(arm.tree, ws);
  ResidualRows rows(arm.tree, arm.problem);
  rows.update(arm.tree, arm.problem, targets, ws);
  const Eigen::VectorXd expected =
      -rows.A.transpose() * (rows.A * rows.A.transpose()).inverse() * rows.b;
  std::vector<double> q = start;
  const Summary summary = NewtonRaphson(arm.tree, arm.problem, options).solve(targets, q);
  EXPECT_EQ(summary.termination, Termination::kSolved) << summary.message();
  EXPECT_NEAR(summary.rows[0].step_norm, summary.rows[0].step_length * expected.norm(), 1e-12);
}

// More equations than unknowns, all of which can hold: least-squares steps are Gauss-Newton's.
TEST_P(NewtonRaphsonOf, TakesLeastSquaresStepsWhereEquationsAreLeftOver) {
  arm.problem.positions.push_back({2, Vector3d(0.1, 0.05, 0)});
  const std::vector<double> there = arm.pose(0.8);
  IkTargets targets = arm.targets_at(there);
  KinematicWorkspace ws(arm.tree);
  ws.q = there;
  update_poses(arm.tree, ws);
  targets.positions.resize(2);
  targets.positions[1] = ws.X_WB[2] * arm.problem.positions[1].p_BP;
  std::vector<double> q = arm.pose(0.8, 0.15);
  const Summary summary = NewtonRaphson(arm.tree, arm.problem, options).solve(targets, q);
  EXPECT_EQ(summary.termination, Termination::kSolved) << summary.message();
  EXPECT_LE(summary.iterations, 7);
}

TEST(NewtonRaphson, DoesNotKeepBounds) {
  Arm arm(false);
  clamp(arm.model.coordinates[3], 0.0, 0.5);
  arm.tree = compile_tree(arm.model);
  Arm free(false);
  std::vector<double> q = free.pose(0.45);
  const Summary summary =
      NewtonRaphson(arm.tree, arm.problem, {}).solve(free.targets_at(free.pose(0.55)), q);
  EXPECT_EQ(summary.termination, Termination::kSolved) << summary.message();
  EXPECT_NEAR(q[3], 0.55, 1e-10);
}

TEST(NewtonRaphson, RejectsOptionsByFieldValueAndBound) {
  const auto error_of = [](const NewtonRaphson::Options& options) -> std::string {
    try {
      options.validate();
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "no error";
  };
  EXPECT_EQ(error_of({}), "no error");
  EXPECT_EQ(error_of({.tolerance = 0.0}),
            "NewtonRaphson::Options.tolerance is 0; expected more than 0");
  EXPECT_EQ(error_of({.max_iterations = 0}),
            "NewtonRaphson::Options.max_iterations is 0; expected 1 or more");
  EXPECT_EQ(error_of({.largest_step = kNaN}),
            "NewtonRaphson::Options.largest_step is nan; expected more than 0");
}

}  // namespace
}  // namespace sinew
