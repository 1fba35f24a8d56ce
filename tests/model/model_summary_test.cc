#include "model/model_summary.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/model/leg_model.h"

namespace sinew {
namespace {

TEST(ModelSummary, CountsWhatTheModelHas) {
  MusculoskeletalModel model = leg_model();
  model.coordinates[0].locked = true;
  model.couplers.push_back({"knees",
                            model.find_coordinate("knee_l"),
                            model.find_coordinate("knee_r"),
                            {LinearFunction{}},
                            {}});
  model.paths[0].natural_length = kNaN;
  model.paths[1].kind = PathElement::Kind::kTendon;
  model.paths[2].kind = PathElement::Kind::kLigament;
  model.paths[3].kind = PathElement::Kind::kActuator;
  const ModelSummary summary = summarize(model);
  EXPECT_EQ(summary.dof, 8);
  EXPECT_EQ(summary.coupled, 1);
  EXPECT_EQ(summary.locked, 1);
  EXPECT_EQ(summary.bodies, 7);
  EXPECT_EQ(summary.virtual_links, 0);
  EXPECT_EQ(summary.wires, 7);
  EXPECT_EQ(summary.muscles, 5);
  EXPECT_EQ(summary.tendons, 1);
  EXPECT_EQ(summary.ligaments, 1);
  EXPECT_EQ(summary.actuators, 1);
  EXPECT_EQ(summary.markers, 4);
  EXPECT_DOUBLE_EQ(summary.mass, 28.0);
  EXPECT_EQ(summary.depth, (std::vector<int>{0, 1, 2, 3, 1, 2, 3}));
  // Root, hip, knee, ankle: flexor; two gastrocnemii; these and the soleus.
  EXPECT_EQ(summary.crossing_paths, (std::vector<int>{0, 1, 2, 3, 1, 2, 3}));
}

TEST(ModelSummary, CrossesTheJointsBetweenTwoBranches) {
  MusculoskeletalModel model = leg_model();
  PathElement across = model.paths[0];
  across.points[0].body = model.find_body("tibia_r");
  across.points[1].body = model.find_body("femur_l");
  EXPECT_EQ(joints_crossed(model, across),
            (std::vector<bool>{false, true, true, false, true, false, false}));
}

// From (a, 0) on the pelvis to b below the hip: l² = a² + b² − 2ab sin θ, so −∂l/∂θ = ab cos θ / l.
TEST(ModelSummary, TabulatesMomentArmsOverTheRange) {
  const MomentArmTable table = moment_arm_table(leg_model(), "hip_r", 5);
  ASSERT_EQ(table.rows.size(), 1u);
  EXPECT_EQ(table.rows[0].path, 0);
  ASSERT_EQ(table.values.size(), 5u);
  constexpr double a = 0.1, b = 0.2;
  for (int i = 0; i < 5; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const double theta = -1.0 + 0.5 * i;
    EXPECT_DOUBLE_EQ(table.values[k], theta);
    const double length = std::sqrt(a * a + b * b - 2 * a * b * std::sin(theta));
    EXPECT_NEAR(table.rows[0].lengths[k], length, 1e-15);
    EXPECT_NEAR(table.rows[0].arms[k], a * b * std::cos(theta) / length, 1e-15);
  }
}

TEST(ModelSummary, SweepsLockedCoordinatesAndThoseWithoutRange) {
  MusculoskeletalModel model = leg_model();
  Coordinate& knee = model.coordinates[static_cast<std::size_t>(model.find_coordinate("knee_r"))];
  knee.locked = true;
  knee.range_min = -std::numeric_limits<double>::infinity();
  knee.range_max = std::numeric_limits<double>::infinity();
  const MomentArmTable table = moment_arm_table(model, "knee_r", 3);
  EXPECT_EQ(table.rows.size(), 2u);
  EXPECT_NEAR(table.values.front(), -0.5 * M_PI, 1e-15);
  EXPECT_NEAR(table.values.back(), 0.5 * M_PI, 1e-15);
}

// The arm of a driver includes what moves with it.
TEST(ModelSummary, IncludesCoupledCoordinates) {
  MusculoskeletalModel model = leg_model();
  const double alone = moment_arm_table(model, "ankle_r", 3).rows[0].arms[1];
  const double knee = moment_arm_table(model, "knee_r", 3).rows[0].arms[1];
  model.couplers.push_back({"coupler",
                            model.find_coordinate("knee_r"),
                            model.find_coordinate("ankle_r"),
                            {LinearFunction{0.5, 0.0}},
                            {}});
  EXPECT_NEAR(moment_arm_table(model, "ankle_r", 3).rows[0].arms[1], alone + 0.5 * knee, 1e-15);
}

std::string error_of(const MusculoskeletalModel& model, const std::string& coordinate) {
  try {
    moment_arm_table(model, coordinate, 3);
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

TEST(ModelSummary, SaysWhichCoordinatesHaveNoMomentArms) {
  MusculoskeletalModel model = leg_model();
  EXPECT_EQ(error_of(model, "elbow"),
            "legs: has no coordinate 'elbow'; expected the name of one of its coordinates. See "
            "`sinew model info`.");
  model.couplers.push_back({"knees",
                            model.find_coordinate("knee_l"),
                            model.find_coordinate("knee_r"),
                            {LinearFunction{}},
                            {}});
  EXPECT_EQ(error_of(model, "knee_l"),
            "legs: coordinate 'knee_l' follows 'knee_r' and moves nothing by itself; expected an "
            "independent coordinate. Ask for 'knee_r'.");
  model.coordinates[0].range_min = model.coordinates[0].range_max = 0.2;
  EXPECT_EQ(error_of(model, "tilt"),
            "model: coordinate 'tilt' has no range to go over; expected a range of some width, "
            "found 0.2 to 0.2. Correct its range.");
}

}  // namespace
}  // namespace sinew
