#include "model/limb_paths.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "model/whole_body.h"

namespace sinew {
namespace {

bool contains(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

TEST(LimbPaths, OfAWholeBody) {
  WholeBodyOptions options;
  options.height = 1.80;
  const MusculoskeletalModel body = whole_body(options);
  EXPECT_TRUE(is_floating(body));
  EXPECT_EQ(up_of(body), Eigen::Vector3d::UnitY());
  const Stance stance = default_stance(body);
  // It stands upright: nothing reaches above its height, and its head's markers come near it.
  EXPECT_LT(stance.highest - stance.lowest, 1.85);
  EXPECT_GT(stance.highest - stance.lowest, 1.65);
  // Where Drillis & Contini (1966) have the hips: 0.530 of the height.
  EXPECT_NEAR(stance.hip - stance.lowest, 0.530 * 1.80, 0.06);
  ASSERT_FALSE(stance.feet.empty());
  int left = 0, right = 0;
  for (const int foot : stance.feet) {
    const std::vector<std::string> path = coordinates_to_ground(body, foot);
    EXPECT_TRUE(contains(path, "pelvis_ty"));
    const int side = side_of_body(body, foot);
    EXPECT_NE(side, 0);
    EXPECT_TRUE(contains(path, side > 0 ? "knee_angle_r" : "knee_angle_l"));
    EXPECT_FALSE(contains(path, side > 0 ? "knee_angle_l" : "knee_angle_r"));
    (side > 0 ? right : left) += 1;
  }
  EXPECT_EQ(left, right);
  const int femur = body.find_body("femur_r");
  EXPECT_EQ(partner_body(body, femur), body.find_body("femur_l"));
  EXPECT_EQ(side_of_body(body, femur), 1);
  EXPECT_EQ(side_of_body(body, body.find_body("pelvis")), 0);
}

TEST(LimbPaths, SidesOfNames) {
  EXPECT_EQ(side_of("femur_r", "femur_l"), 1);
  EXPECT_EQ(side_of("LASI", "RASI"), -1);
  EXPECT_EQ(side_of("femur", "femur"), 0);
  EXPECT_EQ(side_of("femur_r", "femur"), 0);
}

// A pendulum is held by the ground; a sledge is not.
TEST(LimbPaths, WhatFloats) {
  MusculoskeletalModel model;
  model.bodies.resize(2);
  model.bodies[0].name = "ground";
  model.bodies[1].name = "bob";
  model.joints.resize(1);
  model.joints[0].child = 1;
  model.joints[0].kind = Joint::Kind::kPin;
  model.joints[0].coordinates = {0};
  model.coordinates.resize(1);
  model.coordinates[0].name = "angle";
  model.coordinates[0].joint = 0;
  EXPECT_FALSE(is_floating(model));
  EXPECT_EQ(default_stance(model).feet, (std::vector<int>{1}));
  EXPECT_TRUE(std::isnan(default_stance(model).hip));
  EXPECT_EQ(coordinates_to_ground(model, 1), (std::vector<std::string>{"angle"}));
  model.joints[0].kind = Joint::Kind::kPlanar;
  model.joints[0].coordinates = {0, 1, 2};
  model.coordinates.resize(3);
  for (std::size_t c = 1; c < 3; ++c) {
    model.coordinates[c].name = c == 1 ? "x" : "y";
    model.coordinates[c].joint = 0;
    model.coordinates[c].motion = Coordinate::Motion::kTranslational;
  }
  EXPECT_TRUE(is_floating(model));
  model.coordinates[2].locked = true;
  EXPECT_FALSE(is_floating(model));
}

}  // namespace
}  // namespace sinew
