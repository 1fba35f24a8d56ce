#include "data/foot_assignment.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "data/external_loads_writer.h"
#include "data/force_table.h"
#include "data/storage_file.h"
#include "tests/data/test_files.h"

namespace sinew {
namespace {

using Eigen::Vector3d;

constexpr double kRate = 1000.0;
constexpr int kSamples = 2001;  // 2 s

// A platform of 0.6 × 0.4 m, level with the floor, its z down; axes as a model's, y up.
ForcePlatformRecording platform(int number, double x, double z) {
  ForcePlatformRecording recording;
  ForcePlatform& p = recording.platform;
  p.number = number;
  p.type = 2;
  p.p_WC = Vector3d(x, 0.0, z);
  p.R_WP << 1, 0, 0, 0, 0, -1, 0, 1, 0;
  for (std::size_t k = 0; k < 4; ++k) {
    const double sx = k == 0 || k == 3 ? 0.3 : -0.3, sy = k < 2 ? 0.2 : -0.2;
    p.corners[k] = p.p_WC + p.R_WP * Vector3d(sx, sy, 0.0);
  }
  recording.rate = kRate;
  recording.force.setZero(kSamples, 3);
  recording.moment.setZero(kSamples, 3);
  recording.center.setConstant(kSamples, 3, std::nan(""));
  recording.free_moment.setZero(kSamples, 3);
  return recording;
}

// Adds a load that presses from `from` to `to` with a peak of 700 N.
void press(ForcePlatformRecording& recording, double from, double to, const Vector3d& center,
           double free_moment = 3.0) {
  for (int i = 0; i < kSamples; ++i) {
    const double s = (i / kRate - from) / (to - from);
    if (s <= 0.0 || s >= 1.0) continue;
    const double shape = std::sin(3.141592653589793 * s);
    const Vector3d force(40.0 * shape, 700.0 * shape, -20.0 * shape);
    const Vector3d moment =
        (center - recording.platform.p_WC).cross(force) + Vector3d(0.0, free_moment * shape, 0.0);
    recording.force.row(i) += force.transpose();
    recording.moment.row(i) += moment.transpose();
  }
}

void finish(std::vector<ForcePlatformRecording>& plates) {
  for (ForcePlatformRecording& plate : plates) condition(plate, {.threshold = 20.0});
}

// Heel and toe of both feet: the right stands at `right` all the time, the left swings past.
MarkerTrajectories feet(const Vector3d& right, const Vector3d& left, double left_speed) {
  MarkerTrajectories markers;
  markers.names = {"RHEE", "RTOE", "LHEE", "LTOE"};
  markers.rate = 100.0;
  markers.time = Eigen::VectorXd::LinSpaced(201, 0.0, 2.0);
  markers.p_WM.resize(201, 12);
  for (int f = 0; f < 201; ++f) {
    markers.frame_numbers.push_back(f + 1);
    const Vector3d moved = left + Vector3d(left_speed * (markers.time[f] - 1.0), 0.0, 0.0);
    const Vector3d toe(0.2, -0.02, 0.0);
    markers.p_WM.row(f) << right.transpose(), (right + toe).transpose(), moved.transpose(),
        (moved + toe).transpose();
  }
  return markers;
}

FootAssignment assign(const MarkerTrajectories& markers,
                      const std::vector<ForcePlatformRecording>& plates,
                      const std::vector<std::string>& overrides = {}) {
  std::vector<AssignmentOverride> parsed;
  for (const std::string& text : overrides) parsed.push_back(parse_override(text).value());
  return assign_feet(markers, find_feet(markers), plates, 20.0, parsed);
}

const Vector3d kHeel(-0.1, 0.05, 0.0);  // of a foot in the middle of platform 1

TEST(FootAssignment, TheStandingFootUnderThePressureIsTaken) {
  std::vector<ForcePlatformRecording> plates = {platform(1, 0.0, 0.0)};
  press(plates[0], 0.5, 1.5, Vector3d(0.03, 0.0, 0.01));
  finish(plates);
  const MarkerTrajectories markers = feet(kHeel, kHeel + Vector3d(0, 0, -0.12), 2.5);
  const FootAssignment assignment = assign(markers, plates);
  ASSERT_EQ(assignment.contacts.size(), 1u);
  const PlateContact& contact = assignment.contacts[0];
  EXPECT_EQ(contact.state, PlateContact::State::kAssigned) << contact.reason;
  EXPECT_EQ(assignment.feet[0].name, "right");
  EXPECT_EQ(contact.foot, 0);
  EXPECT_GT(contact.confidence, 0.95);
  // 20 N of 700 N sin: 9 ms in.
  EXPECT_NEAR(contact.from, 0.509, 1.1e-3);
  EXPECT_NEAR(contact.to, 1.491, 1.1e-3);
  EXPECT_EQ(describe(contact, assignment, plates),
            "platform 1, 0.51 s to 1.49 s: right foot (100 % sure)");

  const TimeTable loads = foot_loads(assignment, plates);
  ASSERT_EQ(loads.labels.size(), 18u);
  EXPECT_EQ(loads.labels[0], "right_force_vx");
  EXPECT_EQ(loads.labels[8], "right_torque_z");
  const Eigen::VectorXd row = loads.values.row(1000);
  EXPECT_NEAR(row[1], 700.0, 1e-9);
  EXPECT_LT((row.segment<3>(3) - Vector3d(0.03, 0.0, 0.01)).norm(), 1e-12);
  EXPECT_NEAR(row[7], 3.0, 1e-12);
  EXPECT_EQ(row.tail(9).head(3).norm(), 0.0);  // the left
  // Before and after the step the centre waits where it begins and ends.
  EXPECT_LT((loads.values.row(0).segment<3>(3).transpose() - Vector3d(0.03, 0.0, 0.01)).norm(),
            1e-9);
  EXPECT_EQ(loads.values.row(0).head<3>().norm(), 0.0);
}

TEST(FootAssignment, TwoFeetOnOnePlatformAreUnusableUnlessSaid) {
  std::vector<ForcePlatformRecording> plates = {platform(1, 0.0, 0.0)};
  press(plates[0], 0.5, 1.5, Vector3d(0.0, 0.0, 0.02));
  finish(plates);
  const MarkerTrajectories markers = feet(kHeel, kHeel + Vector3d(0, 0, -0.15), 0.0);
  FootAssignment assignment = assign(markers, plates);
  EXPECT_EQ(assignment.contacts[0].state, PlateContact::State::kUnusable);
  EXPECT_EQ(assignment.contacts[0].reason, "both feet stand on it for 0.99 s");
  EXPECT_EQ(foot_loads(assignment, plates).values.leftCols(3).norm(), 0.0);
  assignment = assign(markers, plates, {"1:left@0.2-1.8"});
  EXPECT_EQ(assignment.contacts[0].state, PlateContact::State::kAssigned);
  EXPECT_EQ(assignment.feet[static_cast<std::size_t>(assignment.contacts[0].foot)].name, "left");
  EXPECT_EQ(assignment.contacts[0].reason,
            "said by --assign, though both feet stand on it for 0.99 s");
  // Another time is not meant.
  EXPECT_FALSE(assign(markers, plates, {"1:left@1.5-1.8"}).contacts[0].overridden);
  EXPECT_EQ(assign(markers, plates, {"1:none"}).contacts[0].state, PlateContact::State::kNobody);
}

TEST(FootAssignment, PressureFarFromBothFeetIsNobodys) {
  std::vector<ForcePlatformRecording> plates = {platform(1, 0.0, 0.0)};
  press(plates[0], 0.5, 1.5, Vector3d(0.0, 0.0, 0.17));
  finish(plates);
  const FootAssignment assignment = assign(feet(kHeel, Vector3d(2, 0, 0), 0.0), plates);
  EXPECT_EQ(assignment.contacts[0].reason,
            "the centre of pressure lies outside of either standing foot in 100 % of the frames");
  EXPECT_EQ(assignment.contacts[0].foot, -1);
}

// The pressure under the toe is farther from the heel than from any marker of a whole foot.
TEST(FootAssignment, AFootOfOneMarkerReachesAFootsLength) {
  MarkerTrajectories markers = feet(kHeel, Vector3d(2, 0, 0), 0.0);
  for (const double along : {0.2, 0.3}) {
    std::vector<ForcePlatformRecording> plates = {platform(1, 0.0, 0.0)};
    press(plates[0], 0.5, 1.5, kHeel + Vector3d(along, -0.05, 0.0));
    finish(plates);
    markers.p_WM.middleCols<3>(3).setConstant(std::nan(""));  // RTOE
    EXPECT_EQ(assign(markers, plates).contacts[0].foot, along < 0.25 ? 0 : -1) << along;
  }
}

TEST(FootAssignment, AFootOverTheEdgeNeedsAnotherPlatformThere) {
  std::vector<ForcePlatformRecording> plates = {platform(1, 0.0, 0.0), platform(2, 0.61, 0.0)};
  const Vector3d heel(0.2, 0.05, 0.0);  // the toe is 10 cm beyond platform 1
  press(plates[0], 0.5, 1.5, Vector3d(0.25, 0.0, 0.0));
  std::vector<ForcePlatformRecording> alone = plates;
  finish(alone);
  const MarkerTrajectories markers = feet(heel, Vector3d(3, 0, 0), 0.0);
  EXPECT_EQ(assign(markers, alone).contacts[0].reason,
            "the foot reaches 10 cm over its edge, where nothing measures the force");

  press(plates[1], 0.6, 1.5, Vector3d(0.38, 0.0, 0.01), -1.0);
  finish(plates);
  const FootAssignment both = assign(markers, plates);
  ASSERT_EQ(both.contacts.size(), 2u);
  for (const PlateContact& contact : both.contacts) {
    EXPECT_EQ(contact.state, PlateContact::State::kAssigned);
    EXPECT_NE(contact.reason.find("the foot crosses to platform"), std::string::npos);
  }
  // The sum has the same force and the same moment about the origin as the two together.
  const TimeTable loads = foot_loads(both, plates);
  const Eigen::VectorXd row = loads.values.row(1000);
  Vector3d force = Vector3d::Zero(), moment = Vector3d::Zero();
  for (const ForcePlatformRecording& plate : plates) {
    const Vector3d f = plate.force.row(1000), m = plate.moment.row(1000);
    force += f;
    moment += plate.platform.p_WC.cross(f) + m;
  }
  const Vector3d center = row.segment<3>(3), free(row[6], row[7], row[8]);
  EXPECT_LT((row.head<3>() - force).norm(), 1e-9);
  EXPECT_LT((center.cross(row.head<3>().eval()) + free - moment).norm(), 1e-9);
  EXPECT_NEAR(free.x(), 0.0, 1e-9);
  EXPECT_NEAR(free.z(), 0.0, 1e-9);
  EXPECT_NEAR(center.y(), 0.0, 1e-12);
}

TEST(FootAssignment, ShortKnocksAndPullsAreNoSteps) {
  std::vector<ForcePlatformRecording> plates = {platform(1, 0.0, 0.0)};
  press(plates[0], 0.30, 0.34, Vector3d(0.0, 0.0, 0.0));
  for (int i = 1500; i < 1900; ++i) plates[0].force(i, 1) = -25.0;  // an offset that pulls
  press(plates[0], 0.6, 1.2, Vector3d(0.0, 0.0, 0.0));
  finish(plates);
  EXPECT_EQ(assign(feet(kHeel, Vector3d(3, 0, 0), 0.0), plates).contacts.size(), 1u);
  EXPECT_EQ(plates[0].force.row(1700).norm(), 0.0);
}

TEST(FootAssignment, UnusablePlatformsMayComeFirst) {
  std::vector<ForcePlatformRecording> plates = {platform(1, 5.0, 0.0), platform(2, 0.0, 0.0)};
  plates[0].platform.problem = "type 11 is not supported";
  plates[0].platform.p_WC.setConstant(std::nan(""));
  for (RowMatrix* table :
       {&plates[0].force, &plates[0].moment, &plates[0].center, &plates[0].free_moment}) {
    table->resize(0, 3);
  }
  press(plates[1], 0.5, 1.5, Vector3d(0.0, 0.0, 0.0));
  finish(plates);
  const FootAssignment assignment = assign(feet(kHeel, Vector3d(3, 0, 0), 0.0), plates);
  ASSERT_EQ(assignment.contacts.size(), 1u);
  EXPECT_EQ(assignment.contacts[0].plate, 1);
  const TimeTable loads = foot_loads(assignment, plates);
  ASSERT_EQ(loads.time.size(), kSamples);
  EXPECT_FALSE(loads.values.hasNaN());
  EXPECT_NEAR(loads.values.maxCoeff(), 700.0, 1.0);
  EXPECT_TRUE(foot_loads(assignment, {plates[0]}).labels.empty());
}

TEST(FootAssignment, OverridesAreChecked) {
  for (const char* text :
       {"", "1", "x:right", "0:right", "1:", "1:right@", "1:right@2", "1:right@2-1"}) {
    EXPECT_FALSE(parse_override(text)) << text;
  }
  const auto parsed = parse_override("2:none@0.5-1.25").value();
  EXPECT_EQ(parsed.plate, 2);
  EXPECT_EQ(parsed.foot, "none");
  EXPECT_EQ(parsed.from, 0.5);
  EXPECT_EQ(parsed.to, 1.25);
  const std::vector<ForcePlatformRecording> plates = {platform(1, 0.0, 0.0)};
  EXPECT_THROW(assign(feet(kHeel, kHeel, 0.0), plates, {"2:right"}), std::invalid_argument);
  EXPECT_THROW(assign(feet(kHeel, kHeel, 0.0), plates, {"1:middle"}), std::invalid_argument);
}

TEST(ForceTable, FilteredForcesKeepTheirMomentAndFollowARotation) {
  std::vector<ForcePlatformRecording> plates = {platform(1, 0.1, -0.2)};
  press(plates[0], 0.3, 1.7, Vector3d(0.15, 0.0, -0.1));
  ForcePlatformRecording filtered = plates[0];
  condition(filtered, {.cutoff = 20.0, .rate = 500.0, .threshold = 20.0});
  EXPECT_EQ(filtered.sample_count(), 1001);
  // Every load of this step has one centre, and so has any sum of them.
  for (int i = 250; i < 750; ++i) {
    EXPECT_LT((filtered.center.row(i).transpose() - Vector3d(0.15, 0.0, -0.1)).norm(), 1e-9);
  }
  EXPECT_NEAR(filtered.force(500, 1), 700.0, 0.05);  // half a wave of 0.36 Hz passes 20 Hz
  ForcePlatformRecording turned = filtered;
  const Eigen::Matrix3d R =
      Eigen::AngleAxisd(0.7, Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  rotate(turned, R);
  EXPECT_LT((turned.center.row(500).transpose() - R * Vector3d(0.15, 0.0, -0.1)).norm(), 1e-9);
  condition(turned, {.threshold = 20.0});
  EXPECT_LT((turned.center.row(500).transpose() - R * Vector3d(0.15, 0.0, -0.1)).norm(), 1e-9);
}

TEST(ForceTable, CentersGoOnStraightWhereNothingPresses) {
  const double nan = std::nan("");
  RowMatrix centers(6, 3);
  centers << nan, nan, nan, 1, 0, 2, nan, nan, nan, nan, nan, nan, 4, 0, 8, nan, nan, nan;
  fill_centers(centers, Vector3d::Zero());
  EXPECT_EQ(centers.col(0), (Eigen::VectorXd(6) << 1, 1, 2, 3, 4, 4).finished());
  EXPECT_EQ(centers.col(2), (Eigen::VectorXd(6) << 2, 2, 4, 6, 8, 8).finished());
  RowMatrix never = RowMatrix::Constant(2, 3, nan);
  fill_centers(never, Vector3d(7, 8, 9));
  EXPECT_EQ(never.row(1), Eigen::RowVector3d(7, 8, 9));
}

TEST(ExternalLoadsWriter, IsReadBack) {
  const TemporaryFolder folder;
  TimeTable table;
  table.labels = {"right_force_vx", "right_force_vy", "right_force_vz",
                  "right_force_px", "right_force_py", "right_force_pz",
                  "right_torque_x", "right_torque_y", "right_torque_z"};
  table.time = Eigen::VectorXd::LinSpaced(2, 0.0, 1.0);
  table.values = RowMatrix::Ones(2, 9);
  write_storage(folder.path() / "grf.mot", table);
  ExternalLoadsSetup setup;
  setup.data_file = folder.path() / "grf.mot";
  ExternalForce force;
  force.name = "right & left";
  force.applied_to_body = "calcn_r";
  force.force_identifier = "right_force_v";
  force.point_identifier = "right_force_p";
  force.torque_identifier = "right_torque_";
  setup.forces = {force};
  write_external_loads(folder.path() / "grf.xml", setup);
  EXPECT_NE(content_of(folder.path() / "grf.xml").find("<datafile>grf.mot</datafile>"),
            std::string::npos);
  const ExternalLoadsSetup back = read_external_loads(folder.path() / "grf.xml");
  ASSERT_EQ(back.forces.size(), 1u);
  EXPECT_EQ(back.forces[0].name, "right & left");
  EXPECT_EQ(back.forces[0].applied_to_body, "calcn_r");
  EXPECT_TRUE(back.forces[0].applies);
  EXPECT_EQ(back.forces[0].torque_columns[2], "right_torque_z");
  EXPECT_EQ(back.data_file, folder.path() / "grf.mot");
  EXPECT_TRUE(back.warnings.empty());
}

}  // namespace
}  // namespace sinew
