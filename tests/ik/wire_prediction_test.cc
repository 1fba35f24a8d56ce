#include "ik/wire_prediction.h"

#include <gtest/gtest.h>

#include "ik/minimizer.h"
#include "tests/ik/small_model.h"
#include "tests/ik/whole_body_problem.h"

namespace sinew {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;

TEST(WirePrediction, IsTheDerivativeOfAllLengths) {
  const WholeBodyProblem body;
  const IkProblem& problem = body.tracking.problem;
  const KinematicWorkspace ws = body.workspace(1, 0.2);
  InternalRows rows(body.tree, problem);
  WirePrediction prediction(body.tree, problem);
  rows.update(body.tree, ws);
  prediction.update(problem, ws, rows.origin());
  const VectorXd d = VectorXd::Random(body.tree.unknown_count());
  const std::span<const double> predicted = prediction.predict(body.tree, problem, rows, d);
  constexpr double kStep = 1e-6;
  KinematicWorkspace ahead(body.tree), behind(body.tree);
  ahead.q = behind.q = ws.q;
  for (int x = 0; x < body.tree.unknown_count(); ++x) {
    const auto q = static_cast<std::size_t>(
        body.tree
            .q_of_v[static_cast<std::size_t>(body.tree.unknown_v[static_cast<std::size_t>(x)])]);
    ahead.q[q] += kStep * d[x];
    behind.q[q] -= kStep * d[x];
  }
  update_poses(body.tree, ahead);
  update_poses(body.tree, behind);
  for (std::size_t i = 0; i < problem.wires.size(); ++i) {
    const WireResidual& r = problem.wires[i];
    const double excess = wire_length(problem, r, ws) - r.natural_length;
    const double rate =
        (wire_length(problem, r, ahead) - wire_length(problem, r, behind)) / (2.0 * kStep);
    EXPECT_NEAR(prediction.excess()[i], excess, 1e-14);
    EXPECT_NEAR(predicted[i], excess + rate, 1e-7) << body.tracking.wires[i].name;
  }
}

struct SmallProblem {
  MusculoskeletalModel model = empty_model();
  KinematicTree tree;
  IkProblem problem;

  Summary solve(double target, std::vector<double>& q) {
    IkTargets targets(problem);
    targets.positions[0] = {target, 0.0, 0.0};
    for (double& each : targets.coordinates) each = 0.0;
    return Minimizer(tree, problem, {}).minimize(targets, q);
  }
};

// A marker draws a slider at 0.5 m towards 3 m, and a wire of 1 m and weight 10 holds it: the first
// direction knows that the wire will be taut, and no step has to be cut.
TEST(GaussNewton, KnowsWhichWiresAStepPullsTaut) {
  SmallProblem p;
  add_body(p.model, 0, Joint::Kind::kSlider, "t");
  p.model.coordinates[0].default_value = 0.5;
  p.tree = compile_tree(p.model);
  p.problem.positions = {{1, Vector3d::Zero()}};
  p.problem.wires = {{0, 2, 1.0, 10.0}};
  p.problem.wire_points = {{0, Vector3d::Zero()}, {1, Vector3d::Zero()}};
  std::vector<double> q = p.tree.default_q;
  const Summary summary = p.solve(3.0, q);
  EXPECT_TRUE(summary.converged());
  EXPECT_NEAR(q[0], 13.0 / 11.0, 1e-8);
  EXPECT_LE(summary.iterations, 3);
  EXPECT_EQ(summary.evaluations, summary.iterations + 1);
}

// Two sliders in a row, the first within 0.1 m and the second on a spring of 1: what the first
// cannot do, the second has to, in the same direction.
TEST(GaussNewton, StopsAtBoundsAndGoesOnWithTheRest) {
  SmallProblem p;
  add_body(p.model, 0, Joint::Kind::kSlider, "t");
  add_body(p.model, 1, Joint::Kind::kSlider, "t");
  clamp(p.model.coordinates[0], -0.1, 0.1);
  p.tree = compile_tree(p.model);
  p.problem.positions = {{2, Vector3d::Zero()}};
  p.problem.coordinates = {{1, 1, 1.0}};
  std::vector<double> q = p.tree.default_q;
  const Summary summary = p.solve(1.1, q);
  EXPECT_TRUE(summary.converged());
  EXPECT_EQ(q[0], 0.1);
  EXPECT_NEAR(q[1], 0.5, 1e-8);
  EXPECT_LE(summary.iterations, 2);
  EXPECT_EQ(summary.evaluations, summary.iterations + 1);
  EXPECT_EQ(summary.held, 1);
}

}  // namespace
}  // namespace sinew
