#include "ik/gradient_check.h"

#include <gtest/gtest.h>

#include "tests/ik/small_model.h"

namespace sinew {
namespace {

// A pin at the origin with a point 2 m out on x and a target at 1 m on y: f = ½|target − p|², whose
// derivative is −2·1·cos(q).
struct Pin {
  MusculoskeletalModel model = empty_model();
  KinematicTree tree;
  IkProblem problem;
  IkTargets targets{IkProblem{}};

  Pin() {
    add_body(model, 0, Joint::Kind::kPin, "r");
    clamp(model.coordinates[0], -1.0, 0.3);
    tree = compile_tree(model);
    problem.positions = {{1, {2, 0, 0}, Eigen::Matrix3d::Identity()}};
    targets.positions = {{0, 1, 0}};
  }
};

TEST(GradientCheck, AgreesWithTheClosedForm) {
  const Pin pin;
  const GradientCheck check =
      check_gradient(pin.tree, pin.problem, pin.targets, std::vector<double>{0.1});
  EXPECT_NEAR(check.gradient[0], -2.0 * std::cos(0.1), 1e-15);
  EXPECT_NEAR(check.quotient[0], -2.0 * std::cos(0.1), 1e-11);
  EXPECT_EQ(check.difference[0], check.gradient[0] - check.quotient[0]);
  EXPECT_LE(std::abs(check.difference[0]), 10.0 * check.uncertainty[0] + 1e-13);
  EXPECT_EQ(check.worst, 0);
  EXPECT_EQ(check.scale, std::max(std::abs(check.gradient[0]), std::abs(check.quotient[0])));
  EXPECT_LE(check.worst_relative(), 1e-11);
}

TEST(GradientCheck, StepsThroughBounds) {
  const Pin pin;
  const GradientCheck check =
      check_gradient(pin.tree, pin.problem, pin.targets, std::vector<double>{0.3});
  EXPECT_NEAR(check.quotient[0], -2.0 * std::cos(0.3), 1e-11);
}

// A coupler that jumps: its slope is zero on both sides, and the cost jumps with it.
TEST(GradientCheck, FindsAGradientThatIsNotThatOfTheCost) {
  Pin pin;
  const int b = add_body(pin.model, 1, Joint::Kind::kPin, "r");
  pin.model.couplers.resize(1);
  pin.model.couplers[0].independent = 0;
  pin.model.couplers[0].dependent = 1;
  pin.model.couplers[0].function = {PiecewiseConstantFunction{{-9.0, 0.1}, {0.0, 0.01}}};
  pin.tree = compile_tree(pin.model);
  pin.problem.positions[0].link = b;
  const GradientCheck check =
      check_gradient(pin.tree, pin.problem, pin.targets, std::vector<double>{0.1, 0.0});
  EXPECT_EQ(check.worst, 0);
  EXPECT_GE(check.worst_relative(), 0.1);
}

TEST(GradientCheck, SaysNothingOfATreeWithoutUnknowns) {
  Pin pin;
  pin.model.coordinates[0].locked = true;
  pin.tree = compile_tree(pin.model);
  const GradientCheck check =
      check_gradient(pin.tree, pin.problem, pin.targets, std::vector<double>{0.1});
  EXPECT_EQ(check.worst, -1);
  EXPECT_EQ(check.worst_relative(), 0.0);
}

TEST(GradientCheck, RejectsWhatDoesNotFit) {
  const Pin pin;
  try {
    check_gradient(pin.tree, pin.problem, pin.targets, std::vector<double>{0.1, 0.2});
    ADD_FAILURE() << "two values for one coordinate were taken";
  } catch (const std::invalid_argument& error) {
    EXPECT_STREQ(error.what(), "check_gradient got 2 values of q; the tree has 1");
  }
  EXPECT_THROW(
      check_gradient(pin.tree, pin.problem, IkTargets(IkProblem{}), std::vector<double>{0.1}),
      std::invalid_argument);
}

}  // namespace
}  // namespace sinew
