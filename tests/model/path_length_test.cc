#include "model/path_length.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "model/osim_file.h"
#include "tests/model/random_model.h"
#include "tests/model/shared_models.h"

namespace sinew {
namespace {

// Central differences: third derivatives times step² / 6, and rounding over step.
constexpr double kStep = 5e-6;
constexpr double kDifferenceTolerance = 2e-9;

PathPoint point_on(int body, const Eigen::Vector3d& p_BP) {
  PathPoint point;
  point.body = body;
  point.p_BP = p_BP;
  return point;
}

// Two bars of 0.3 m in a row, hanging along −Y from pins about Z.
MusculoskeletalModel two_pins() {
  MusculoskeletalModel model;
  model.bodies.resize(3);
  model.joints.resize(2);
  model.coordinates.resize(2);
  for (int i = 0; i < 2; ++i) {
    const auto n = static_cast<std::size_t>(i);
    model.bodies[n + 1].name = "bar" + std::to_string(i);
    Joint& joint = model.joints[n];
    joint.name = "pin" + std::to_string(i);
    joint.kind = Joint::Kind::kPin;
    joint.parent = i;
    joint.child = i + 1;
    joint.X_PF.p = {0.0, i == 0 ? 0.0 : -0.3, 0.0};
    joint.coordinates = {i};
    model.coordinates[n].name = "angle" + std::to_string(i);
    model.coordinates[n].joint = i;
  }
  validate(model);
  return model;
}

struct Posed {
  explicit Posed(const MusculoskeletalModel& model, const std::vector<double>& q)
      : tree(compile_tree(model)), ws(tree), arms(tree.unknown_v.size()) {
    for (std::size_t c = 0; c < q.size(); ++c) {
      ws.q[static_cast<std::size_t>(tree.q_of_coordinate[c])] = q[c];
    }
    update_kinematics(tree, ws);
  }
  KinematicTree tree;
  KinematicWorkspace ws;
  std::vector<double> arms;
};

// A straight wire from (0.1, 0) on ground to a point 0.2 below a pin: by the law of cosines
// l² = 0.1² + 0.2² − 2·0.1·0.2·cos(90° − angle), and dl/dangle by differentiating it.
TEST(PathLength, FollowsTheLawOfCosines) {
  const MusculoskeletalModel model = two_pins();
  PathElement path;
  path.points = {point_on(0, {0.1, 0.0, 0.0}), point_on(1, {0.0, -0.2, 0.0})};
  for (const double angle : {-1.0, -0.3, 0.0, 0.4, 1.1}) {
    Posed posed(model, {angle, 0.7});
    const double length = std::sqrt(0.05 - 0.04 * std::sin(angle));
    EXPECT_NEAR(path_length(path, posed.tree, posed.ws), length, 1e-15);
    moment_arms(path, posed.tree, posed.ws, posed.arms);
    EXPECT_NEAR(posed.arms[0], 0.02 * std::cos(angle) / length, 1e-15);
    EXPECT_NEAR(posed.arms[1], 0.0, 1e-15);
  }
}

TEST(PathLength, LeavesConditionalPointsOutBeyondTheirRange) {
  const MusculoskeletalModel model = two_pins();
  PathElement path;
  path.points = {point_on(0, {0.0, 0.0, 0.0}), point_on(1, {0.1, -0.1, 0.0}),
                 point_on(1, {0.0, -0.2, 0.0})};
  path.points[1].kind = PathPoint::Kind::kConditional;
  path.points[1].condition_coordinate = 1;
  path.points[1].condition_min = -0.5;
  path.points[1].condition_max = 0.5;
  const double bent = 2.0 * std::sqrt(0.02);
  for (const double angle : {-0.5, 0.0, 0.5}) {  // ends included
    Posed posed(model, {0.0, angle});
    EXPECT_NEAR(path_length(path, posed.tree, posed.ws), bent, 1e-15);
  }
  for (const double angle : {-0.51, 0.51}) {
    Posed posed(model, {0.0, angle});
    EXPECT_NEAR(path_length(path, posed.tree, posed.ws), 0.2, 1e-15);
  }
}

TEST(PathLength, GivesNoPullBetweenPointsThatCoincide) {
  const MusculoskeletalModel model = two_pins();
  PathElement path;
  path.points = {point_on(0, {0.0, 0.0, 0.0}), point_on(1, {0.0, 0.0, 0.0})};
  Posed posed(model, {0.3, 0.3});
  EXPECT_EQ(path_length(path, posed.tree, posed.ws), 0.0);
  moment_arms(path, posed.tree, posed.ws, posed.arms);
  EXPECT_EQ(posed.arms, std::vector<double>({0.0, 0.0}));
}

TEST(PathLength, RefusesACoordinateWithoutValueAndRoomOfAnotherSize) {
  const MusculoskeletalModel model =
      random_model(1, {.coupler_count = 0, .lock_count = 0, .for_quaternions = true});
  const KinematicTree tree = compile_tree(model, {.quaternions = true});
  KinematicWorkspace ws(tree);
  update_kinematics(tree, ws);
  PathElement path;
  path.points = {point_on(0, {0.0, 0.0, 0.0}), point_on(1, {0.0, 1.0, 0.0})};
  path.points[1].name = "P";
  std::vector<double> arms(3);
  EXPECT_THROW(moment_arms(path, tree, ws, arms), std::invalid_argument);
  path.points[1].kind = PathPoint::Kind::kConditional;
  path.points[1].condition_coordinate = 0;  // of a free joint
  EXPECT_THROW(path_length(path, tree, ws), std::invalid_argument);
}

// A polyline over bodies anywhere in a random model, one point of it moving.
PathElement random_path(const MusculoskeletalModel& model, std::mt19937& random) {
  std::uniform_int_distribution<int> body(0, static_cast<int>(model.bodies.size()) - 1);
  std::uniform_int_distribution<int> coordinate(0, static_cast<int>(model.coordinates.size()) - 1);
  std::uniform_real_distribution<double> value(-0.3, 0.3);
  PathElement path;
  for (int i = 0; i < 4; ++i) {
    path.points.push_back(point_on(body(random), {value(random), value(random), value(random)}));
  }
  PathPoint& moving = path.points[1];
  moving.kind = PathPoint::Kind::kMoving;
  for (TransformAxis& location : moving.location) {
    location.coordinate = coordinate(random);
    location.function = {SineFunction{value(random), 2.0, value(random), value(random)}};
  }
  moving.location[2].coordinate = -1;
  return path;
}

// Couplers, locks, moving points and every kind of joint: −∂l/∂x by the sweep is that by central
// differences of the length.
TEST(PathLength, HasMomentArmsThatAreTheSlopeOfTheLength) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    const MusculoskeletalModel model = random_model(seed);
    std::mt19937 random(seed);
    Posed posed(model, random_pose(model, random));
    const PathElement path = random_path(model, random);
    moment_arms(path, posed.tree, posed.ws, posed.arms);
    const std::vector<double> q = posed.ws.q;
    std::vector<double> step(posed.arms.size(), 0.0);
    for (std::size_t x = 0; x < step.size(); ++x) {
      double length[2];
      for (const int side : {0, 1}) {
        step[x] = side == 0 ? -kStep : kStep;
        advance(posed.tree, q, step, posed.ws.q);
        update_poses(posed.tree, posed.ws);
        length[side] = path_length(path, posed.tree, posed.ws);
      }
      step[x] = 0.0;
      EXPECT_NEAR(posed.arms[x], -(length[1] - length[0]) / (2.0 * kStep), kDifferenceTolerance)
          << "seed " << seed << ", unknown " << x;
    }
  }
}

// Published paths with conditional and moving points are there to be measured, too.
TEST(PathLength, MeasuresEveryPublishedModel) {
  SINEW_SKIP_WITHOUT_SHARED_DATA();
  for (const auto& file : shared_models()) {
    if (has_no_bodies(file)) continue;
    const MusculoskeletalModel model = read_osim(file);
    const KinematicTree tree = compile_tree(model);
    KinematicWorkspace ws(tree);
    update_poses(tree, ws);
    for (const PathElement& path : model.paths) {
      const double length = path_length(path, tree, ws);
      EXPECT_GT(length, 0.0) << file << " " << path.name;
      EXPECT_LT(length, 3.0) << file << " " << path.name;
    }
  }
}

}  // namespace
}  // namespace sinew
