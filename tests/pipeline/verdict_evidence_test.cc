#include "pipeline/verdict_evidence.h"

#include <gtest/gtest.h>

#include <cmath>

#include "model/osim_file.h"
#include "model/whole_body.h"
#include "pipeline/dynamics_evidence.h"
#include "tests/pipeline/small_trial.h"

namespace sinew {
namespace {

using Names = std::vector<std::string>;

constexpr double kWeight = 48.0 * 9.80665;

class Evidence : public ::testing::Test {
 protected:
  Evidence() {
    SmallTrial::write(folder_);
    model_ = read_osim(folder_.path() / "model.osim");
  }

  ExternalLoads loads() const {
    return {model_, read_external_loads(folder_.path() / "grf.xml"),
            read_storage(folder_.path() / "grf.mot")};
  }

  // 100 frames: `known` ones in which 0.3 of the weight hangs on the root, and 0.8 in the others;
  // 40 N across and 7 N m everywhere.
  static TimeTable forces(int known) {
    TimeTable table;
    table.labels = {"tilt_moment", "x_force", "y_force", "flexion_moment"};
    table.time = Eigen::VectorXd::LinSpaced(100, 0.0, 0.99);
    table.values = RowMatrix::Zero(100, 4);
    table.values.col(0).setConstant(7.0);
    table.values.col(1).setConstant(-40.0);
    table.values.col(2).setConstant(0.8 * kWeight);
    table.values.col(2).head(known).setConstant(0.3 * kWeight);
    table.values.col(3).setConstant(1000.0);  // a muscle's, not the root's
    return table;
  }

  TemporaryFolder folder_;
  MusculoskeletalModel model_;
};

TEST_F(Evidence, OfTheModel) {
  const ModelEvidence e = model_evidence(model_);
  EXPECT_EQ(e.mass, 48.0);
  EXPECT_FALSE(e.stands);
  EXPECT_NEAR(e.height, 0.8, 1e-9);  // T1, 0.4 m above the hip, to L3, 0.4 m below
  EXPECT_TRUE(e.sides.empty());
  const std::vector<JointEvidence> joints = joint_evidence(model_);
  ASSERT_EQ(joints.size(), 2u);
  EXPECT_EQ(joints[0].name, "floor");
  EXPECT_EQ(joints[0].coordinates, (Names{"tilt", "x", "y"}));
}

// Lengths from joint to joint, whatever the axes: 5 cm more on the right.
TEST_F(Evidence, OfSegmentsOnBothSides) {
  const auto body = [&](const char* name, int parent, const Eigen::Vector3d& p_PF) {
    model_.bodies.emplace_back();
    model_.bodies.back().name = name;
    Joint joint;
    joint.parent = parent;
    joint.child = static_cast<int>(model_.bodies.size()) - 1;
    joint.X_PF.p = p_PF;
    model_.joints.push_back(joint);
    return joint.child;
  };
  const int right = body("femur_r", 1, {0.0, 0.0, 0.1}),
            left = body("femur_l", 1, {0.0, 0.0, -0.1});
  body("tibia_r", right, {0.0, -0.45, 0.0});
  body("tibia_l", left, {0.24, -0.32, 0.0});
  const ModelEvidence e = model_evidence(model_);
  ASSERT_EQ(e.sides.size(), 1u);
  EXPECT_EQ(e.sides[0].body, "femur_r");
  EXPECT_NEAR(e.sides[0].length, 0.45, 1e-12);
  EXPECT_NEAR(e.sides[0].partner_length, 0.40, 1e-12);
}

TEST_F(Evidence, OfDynamicsByATable) {
  const DynamicsEvidence e = dynamics_evidence(model_, forces(60), loads(), {});
  EXPECT_TRUE(e.floating);
  EXPECT_TRUE(e.loads_given);
  EXPECT_FALSE(e.by_platforms);
  EXPECT_NEAR(e.weight, kWeight, 1e-9);
  EXPECT_EQ(e.frames, 100);
  EXPECT_EQ(e.known, 60);
  EXPECT_NEAR(e.peak_load, kWeight, 1e-6);
  EXPECT_NEAR(e.mean_vertical_load, kWeight, 1e-6);
  EXPECT_NEAR(e.horizontal_load_rms, 0.0, 1e-6);
  EXPECT_NEAR(e.root.force_rms, std::hypot(40.0, 0.3 * kWeight), 1e-6);
  EXPECT_NEAR(e.root.moment_max, 7.0, 1e-12);
  EXPECT_NEAR(e.carried_mass, 48.0 / 1.3, 1e-6);
  EXPECT_EQ(e.supporting, (Names{"flexion", "tilt", "x", "y"}));
  // Where nothing is known the figures are those of all frames.
  const DynamicsEvidence none = dynamics_evidence(model_, forces(0), loads(), {});
  EXPECT_EQ(none.known, 0);
  EXPECT_NEAR(none.root.force_rms, std::hypot(40.0, 0.8 * kWeight), 1e-6);
  EXPECT_TRUE(std::isnan(none.carried_mass));
}

// A force of 100 N forwards while the movement needs 40 N backwards, of which nothing acts.
TEST_F(Evidence, OfPushesAgainstTheMovement) {
  TimeTable table = SmallTrial::loads(0.0, 1.5);
  table.values.col(0).setConstant(100.0);
  write_storage(folder_.path() / "grf.mot", table);
  TimeTable left = forces(60);
  left.values.col(1).head(60).setConstant(-140.0);
  const DynamicsEvidence e = dynamics_evidence(model_, left, loads(), {});
  ASSERT_EQ(e.pushes.size(), 1u);
  EXPECT_EQ(e.pushes[0].body, "");
  EXPECT_EQ(e.pushes[0].axis, "x");
  EXPECT_NEAR(e.pushes[0].load_rms, 100.0, 1e-9);
  EXPECT_NEAR(e.pushes[0].need_rms, 40.0, 1e-9);
  EXPECT_NEAR(e.pushes[0].cosine, -1.0, 1e-12);
}

// 100 N forwards at the thigh, then 50 N at the trunk, while the movement needs 100 N backwards and
// 50 N forwards: the one is turned, and the other asked for what is left of it.
TEST_F(Evidence, OfOnePushOfTwo) {
  TimeTable table = SmallTrial::loads(0.0, 1.5);
  const TimeTable once = table;
  for (const std::string& label : once.labels) table.labels.push_back("second_" + label);
  table.values.conservativeResize(Eigen::NoChange, 18);
  table.values.rightCols(9) = once.values;
  for (Eigen::Index row = 0; row < table.time.size(); ++row) {
    const bool early = table.time[row] < 0.2975;
    table.values(row, 0) = early ? 100.0 : 0.0;
    table.values(row, 9) = early ? 0.0 : 50.0;
  }
  write_storage(folder_.path() / "grf.mot", table);
  std::string setup = SmallTrial::loads_setup("grf.mot");
  const std::size_t begin = setup.find("<ExternalForce "), end = setup.find("</objects>");
  std::string second = setup.substr(begin, end - begin);
  second.replace(second.find("push"), 4, "second");
  second.replace(second.find("thigh"), 5, "trunk");
  for (const std::string part : {">f_v<", ">f_p<", ">f_torque_<"}) {
    second.insert(second.find(part) + 1, "second_");
  }
  folder_.write("grf.xml", setup.insert(end, second));
  const ExternalLoads both = loads();
  TimeTable left = forces(60);
  left.values.col(1).head(30).setConstant(-200.0);
  left.values.col(1).segment(30, 30).setZero();
  const DynamicsEvidence e = dynamics_evidence(model_, left, both, {});
  ASSERT_EQ(e.pushes.size(), 3u);
  EXPECT_TRUE(e.turns.empty());  // along one axis there is nothing to exchange
  ASSERT_EQ(e.pulls.size(), 2u);
  EXPECT_EQ(e.pulls[1].body, "trunk");
  EXPECT_NEAR(e.pulls[1].mean, kWeight, 1e-6);
  EXPECT_NEAR(e.pushes[0].cosine, -0.6, 1e-6);
  EXPECT_EQ(e.pushes[1].body, "thigh");
  EXPECT_NEAR(e.pushes[1].cosine, -1.0, 1e-6);
  EXPECT_EQ(e.pushes[2].body, "trunk");
  EXPECT_NEAR(e.pushes[2].cosine, 50.0 / std::hypot(200.0, 50.0), 1e-6);
}

TEST_F(Evidence, OfDynamicsByPlatforms) {
  LoadCoverage coverage{{"right", "left"}, {}};
  for (int f = 0; f < 110; ++f) {
    coverage.loads.push_back(
        {FootLoad::kMeasured, f < 30 ? FootLoad::kNone : FootLoad::kUnmeasured});
  }
  // The forces begin in the coverage's frame 10.
  const DynamicsEvidence e = dynamics_evidence(model_, forces(60), loads(), {&coverage, 10, 47.0});
  EXPECT_TRUE(e.by_platforms);
  EXPECT_EQ(e.known, 20);
  EXPECT_EQ(e.carried_mass, 47.0);
  EXPECT_FALSE(e.mass_of_some_frames);
  // Without whole strides the static trial tells, without both the frames that are known: 48 kg
  // carry their weight while 20 % of it hang on the root.
  const double none = std::nan("");
  EXPECT_EQ(
      dynamics_evidence(model_, forces(60), loads(), {&coverage, 10, none, 46.0}).carried_mass,
      46.0);
  const DynamicsEvidence some =
      dynamics_evidence(model_, forces(60), loads(), {&coverage, 10, none, none});
  EXPECT_TRUE(some.mass_of_some_frames);
  EXPECT_NEAR(some.carried_mass, 48.0 / 1.3, 1e-6);
  ASSERT_EQ(e.feet.size(), 2u);
  EXPECT_EQ(e.feet[0].complete, 100);
  EXPECT_EQ(e.feet[1].complete, 20);
}

TEST_F(Evidence, OfLoadsThatAreNotGiven) {
  const DynamicsEvidence e = dynamics_evidence(model_, forces(100), ExternalLoads(), {});
  EXPECT_FALSE(e.loads_given);
  EXPECT_TRUE(std::isnan(e.peak_load));
  EXPECT_FALSE(e.supporting.empty());
}

TEST_F(Evidence, OfKinematics) {
  std::string text = SmallTrial::model();
  const std::string open = "<Coordinate name=\"flexion\"/>";
  text.replace(text.find(open), open.size(),
               "<Coordinate name=\"flexion\"><range>-0.2 0.3</range><clamped>true</clamped>"
               "</Coordinate>");
  folder_.write("model.osim", text);
  IkInputs inputs;
  inputs.model_file = folder_.path() / "model.osim";
  inputs.marker_file = folder_.path() / "walk.trc";
  const IkJob job = prepare_ik(inputs);
  TrackingResult result;
  result.time = Eigen::VectorXd::LinSpaced(4, 0.0, 0.03);
  result.coordinates = RowMatrix::Zero(4, 4);
  result.coordinates.col(3) << 0.3, 0.1, -0.2, 0.3;
  result.marker_errors = RowMatrix::Constant(4, 6, 0.003);
  result.marker_errors.col(1).setConstant(std::nan(""));
  result.marker_errors(2, 0) = 0.009;
  result.frames.resize(4);
  for (FrameResult& frame : result.frames) {
    frame.termination = Termination::kGradient;
    frame.measured_markers = 5;
    frame.marker_rms = 0.003;
  }
  result.frames[3].termination = Termination::kMaxIterations;
  result.frames[3].measured_markers = 0;
  VerdictReason open_angle;
  open_angle.angles = {"tilt"};
  const KinematicsEvidence e = kinematics_evidence(job, result, 0.002, {open_angle});
  EXPECT_EQ(e.frames, 4);
  EXPECT_EQ(e.unconverged, 1);
  EXPECT_EQ(e.unmeasured, 1);
  EXPECT_NEAR(e.marker_rms, 0.003, 1e-12);
  EXPECT_EQ(e.static_rms, 0.002);
  ASSERT_EQ(e.markers.size(), 6u);
  EXPECT_NEAR(e.markers[0].rms, std::sqrt((3.0 * 9.0 + 81.0) / 4.0) * 1e-3, 1e-12);
  EXPECT_NEAR(e.markers[0].max, 0.009, 1e-12);
  EXPECT_EQ(e.markers[0].angles, (Names{"tilt", "x", "y"}));
  EXPECT_EQ(e.markers[5].angles, (Names{"flexion"}));
  EXPECT_EQ(e.markers[1].measured, 0);
  ASSERT_EQ(e.coordinates.size(), 4u);
  EXPECT_TRUE(e.coordinates[0].undetermined);
  EXPECT_FALSE(e.coordinates[1].rotational);
  EXPECT_NEAR(e.coordinates[3].range, 0.5, 1e-12);
  EXPECT_NEAR(e.coordinates[3].on_bound, 0.75, 1e-12);
}

TEST_F(Evidence, OfAMotionThatLacksACoordinate) {
  CoordinateTable motion;
  motion.measured = {true, false, true, false};
  EXPECT_EQ(coordinates_not_given(model_, motion), (Names{"x", "flexion"}));
  model_.coordinates[1].locked = true;
  CoordinateCoupler coupler;
  coupler.dependent = 3;
  coupler.independent = 0;
  model_.couplers.push_back(coupler);
  EXPECT_TRUE(coordinates_not_given(model_, motion).empty());
}

TEST(Locks, OfOneSideAndOfARootAreNamed) {
  MusculoskeletalModel body = whole_body({});
  const auto set = [&](const std::string& name, bool locked) {
    for (Coordinate& c : body.coordinates) {
      if (c.name == name) {
        c.locked = locked;
        return;
      }
    }
    ADD_FAILURE() << name;
  };
  EXPECT_TRUE(lock_reasons(body).empty());
  set("knee_angle_r", true);
  const std::vector<VerdictReason> knee = lock_reasons(body);
  ASSERT_EQ(knee.size(), 1u);
  EXPECT_EQ(knee[0].code, "locked");
  EXPECT_EQ(knee[0].angles, Names{"knee_angle_r"});
  set("knee_angle_l", true);  // as a robot walks
  EXPECT_TRUE(lock_reasons(body).empty());
  set("pelvis_tilt", true);
  ASSERT_EQ(lock_reasons(body).size(), 1u);
  EXPECT_EQ(lock_reasons(body)[0].torques, Names{"pelvis_tilt"});
}

}  // namespace
}  // namespace sinew
