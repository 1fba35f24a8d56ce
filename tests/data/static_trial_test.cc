#include "data/static_trial.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>

#include "data/mass_unit.h"

namespace sinew {
namespace {

// Eight markers on two segments of a person `size` times as large, that turn against each other by
// `swing` [rad] once a second and go along with `speed` [m/s]; noise of 1 mm.
MarkerTrajectories person(double size, double swing, double speed, double seconds = 3.0) {
  std::mt19937 random(2);
  std::normal_distribution<double> noise(0.0, 0.001);
  MarkerTrajectories markers;
  markers.rate = 50.0;
  const int frames = static_cast<int>(seconds * markers.rate);
  for (const char* name : {"A", "B", "C", "D", "E", "F", "G", "H"}) markers.names.push_back(name);
  const Eigen::Vector3d places[] = {{0, 1.0, 0},      {0.1, 1.2, 0.2}, {-0.1, 1.3, -0.2},
                                    {0.1, 0.9, -0.1}, {0, 0.8, 0.05},  {0.05, 0.5, -0.05},
                                    {-0.1, 0.3, 0},   {0.05, 0.1, 0.1}};
  markers.time.resize(frames);
  markers.p_WM.resize(frames, 24);
  for (int f = 0; f < frames; ++f) {
    const double t = f / markers.rate, angle = swing * std::sin(2.0 * M_PI * t);
    markers.time[f] = t;
    markers.frame_numbers.push_back(f + 1);
    for (int m = 0; m < 8; ++m) {
      Eigen::Vector3d p = places[m];
      if (m >= 4) {
        p -= Eigen::Vector3d(0, 0.9, 0);
        p = Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ()) * p;
        p += Eigen::Vector3d(0, 0.9, 0);
      }
      p = size * p + Eigen::Vector3d(speed * t, 0, 0);
      for (int axis = 0; axis < 3; ++axis) markers.p_WM(f, 3 * m + axis) = p[axis] + noise(random);
    }
  }
  return markers;
}

std::string codes(const std::vector<VerdictReason>& reasons) {
  std::string all;
  for (const VerdictReason& reason : reasons) all += reason.code + " ";
  return all;
}

TEST(StaticTrial, NothingIsWrongWithOnePersonWhoStandsAndWalks) {
  EXPECT_EQ(codes(static_trial_reasons(person(1.0, 0.0, 0.0), person(1.0, 0.5, 1.2))), "");
  // Breathing and sway.
  EXPECT_EQ(codes(static_trial_reasons(person(1.0, 0.02, 0.0), person(1.0, 0.5, 1.2))), "");
  // Two static trials: nothing tells segments from poses.
  EXPECT_EQ(codes(static_trial_reasons(person(1.0, 0.0, 0.0), person(1.0, 0.0, 0.0))), "");
}

TEST(StaticTrial, ExchangedTrialsAreFound) {
  const std::vector<VerdictReason> reasons =
      static_trial_reasons(person(1.0, 0.5, 1.2), person(1.0, 0.0, 0.0));
  ASSERT_EQ(codes(reasons), "trials-exchanged ");
  EXPECT_EQ(reasons[0].weight, VerdictReason::Weight::kUnusable);
  EXPECT_EQ(finding_of(reasons[0]).severity, Finding::Severity::kError);
  EXPECT_EQ(finding_of(reasons[0]).kind, "trials exchanged");
}

// Who stands for a second and walks off.
TEST(StaticTrial, OneThatMovesIsNamedWithTheTimeInWhichItIsStill) {
  MarkerTrajectories markers = person(1.0, 0.0, 0.0, 2.0);
  for (int f = 50; f < markers.frame_count(); ++f) {
    for (int m = 0; m < 8; ++m) markers.p_WM(f, 3 * m) += 1.2 * (markers.time[f] - 1.0);
  }
  const std::vector<VerdictReason> reasons = static_trial_reasons(markers, person(1.0, 0.5, 1.2));
  ASSERT_EQ(codes(reasons), "static-moves ");
  EXPECT_NE(reasons[0].remedy.find("--scale walk"), std::string::npos);
  const TrialMovement movement = trial_movement(markers);
  EXPECT_NEAR(movement.still_from, 0.0, 0.1);
  EXPECT_NEAR(movement.still_to, 1.0, 0.1);
}

TEST(StaticTrial, AnotherPersonIsFoundByTheSegments) {
  const std::vector<VerdictReason> reasons =
      static_trial_reasons(person(1.08, 0.0, 0.0), person(1.0, 0.5, 1.2));
  ASSERT_EQ(codes(reasons), "other-person ");
  EXPECT_GT(reasons[0].figure, 10.0);
  EXPECT_EQ(reasons[0].limit, 10.0);
  // Markers that were never recorded together say nothing.
  MarkerTrajectories other = person(1.08, 0.0, 0.0);
  for (std::string& name : other.names) name += "2";
  EXPECT_EQ(codes(static_trial_reasons(other, person(1.0, 0.5, 1.2))), "");
}

TEST(StaticTrial, AMarkerThatSatElsewhereIsFoundByItsSegment) {
  const auto on = [](const std::vector<int>& segments) {
    std::vector<StaticMarker> known;
    for (const int segment : segments) known.push_back({segment});
    return known;
  };
  const std::vector<StaticMarker> segments = on({0, 0, 0, 0, 1, 1, 1, 1});
  const MarkerTrajectories walk = person(1.0, 0.5, 1.2);
  MarkerTrajectories standing = person(1.0, 0.0, 0.0);
  EXPECT_EQ(codes(static_marker_reasons(standing, walk, segments)), "");
  standing.p_WM.col(3 * 1 + 1).array() += 0.06;  // B, upwards
  std::vector<VerdictReason> reasons = static_marker_reasons(standing, walk, segments);
  ASSERT_EQ(codes(reasons), "static-marker ");
  EXPECT_EQ(reasons[0].weight, VerdictReason::Weight::kRemark);
  EXPECT_NEAR(reasons[0].figure, 60.0, 1.0);
  EXPECT_EQ(reasons[0].text,
            "B sat elsewhere among the markers of its segment in the static trial");
  EXPECT_EQ(reasons[0].remedy, "--drop B, or --scale walk leaves the static trial out");
  // D is 0.3 m below and 0.3 m to the side: of two alone nothing tells which.
  std::vector<StaticMarker> pairs = on({-1, 0, -1, 0, 1, 1, -1, -1});
  reasons = static_marker_reasons(standing, walk, pairs);
  ASSERT_EQ(codes(reasons), "static-marker ");
  EXPECT_NEAR(reasons[0].figure, 1e3 * (std::hypot(0.3, 0.36) - std::hypot(0.3, 0.3)), 1.0);
  EXPECT_EQ(reasons[0].text, "B or D sat elsewhere in the static trial: their distance differs");
  // A fit that has both trials does.
  pairs[1].change = 0.041;
  pairs[3].change = 0.026;
  reasons = static_marker_reasons(standing, walk, pairs);
  ASSERT_EQ(codes(reasons), "static-marker ");
  EXPECT_NEAR(reasons[0].figure, 41.0, 1e-9);
  EXPECT_EQ(reasons[0].text, "B sat elsewhere on its segment in the static trial");
  EXPECT_EQ(reasons[0].remedy, "--drop B, or --scale walk leaves the static trial out");
  // Skin that slides is none, and neither are segments that nobody knows.
  EXPECT_EQ(codes(static_marker_reasons(standing, walk, on(std::vector<int>(8, -1)))), "");
  standing = person(1.0, 0.0, 0.0);
  standing.p_WM.col(3 * 1 + 1).array() += 0.02;
  EXPECT_EQ(codes(static_marker_reasons(standing, walk, segments)), "");
}

TEST(StaticTrial, NothingMeasuredIsNothingFound) {
  MarkerTrajectories nothing = person(1.0, 0.0, 0.0);
  nothing.p_WM.setConstant(std::nan(""));
  EXPECT_EQ(codes(static_trial_reasons(nothing, person(1.0, 0.5, 1.2))), "");
  EXPECT_EQ(codes(static_trial_reasons(person(1.0, 0.5, 1.2), nothing)), "static-moves ");
  nothing.p_WM.resize(0, 24);
  nothing.time.resize(0);
  EXPECT_EQ(codes(static_trial_reasons(nothing, nothing)), "");
}

TEST(StaticTrial, AWalkThatTheModelDoesNotMeetIsNamed) {
  EXPECT_TRUE(static_against_walk_reasons(0.001, 0.0065).empty());
  EXPECT_TRUE(static_against_walk_reasons(0.02, 0.005).empty());
  EXPECT_TRUE(static_against_walk_reasons(std::nan(""), 0.05).empty());
  const std::vector<VerdictReason> reasons = static_against_walk_reasons(0.0006, 0.0153);
  ASSERT_EQ(codes(reasons), "static-rms ");
  EXPECT_EQ(reasons[0].text,
            "markers are met to 0.6 mm RMS in the static trial but to 15.3 mm in the walk");
  EXPECT_NEAR(reasons[0].figure, 14.7, 1e-9);
}

TEST(StaticTrial, APoseThatTheModelCannotTakeIsNamed) {
  EXPECT_TRUE(static_pose_reasons(0.0129).empty());
  EXPECT_TRUE(static_pose_reasons(std::nan("")).empty());
  ASSERT_EQ(codes(static_pose_reasons(0.025)), "static-pose ");
  EXPECT_EQ(static_pose_reasons(0.025)[0].weight, VerdictReason::Weight::kRemark);
  EXPECT_EQ(static_pose_reasons(0.0559)[0].weight, VerdictReason::Weight::kUnusable);
}

TEST(MassUnit, PoundsAndNewtonsAreFoundByThePlatforms) {
  const MassEvidence evidence{70.0, 1.75};
  EXPECT_TRUE(mass_unit_reasons(71.0, evidence).empty());
  EXPECT_TRUE(mass_unit_reasons(90.0, evidence).empty());  // wrong, but in no other unit
  const std::vector<VerdictReason> pounds = mass_unit_reasons(154.3, evidence);
  ASSERT_EQ(pounds.size(), 1u);
  EXPECT_EQ(pounds[0].text,
            "the mass of 154.3 kg seems to be in pounds: the platforms carry 70.0 kg");
  EXPECT_EQ(pounds[0].remedy, "--mass 70.0");
  EXPECT_EQ(pounds[0].weight, VerdictReason::Weight::kUnusable);
  const std::vector<VerdictReason> newtons = mass_unit_reasons(686.0, evidence);
  ASSERT_EQ(newtons.size(), 1u);
  EXPECT_EQ(newtons[0].remedy, "--mass 70.0");
}

TEST(MassUnit, WithoutPlatformsTheHeightTells) {
  EXPECT_TRUE(mass_unit_reasons(150.0, {}).empty());
  const MassEvidence tall{{}, 1.75};
  EXPECT_TRUE(mass_unit_reasons(110.0, tall).empty());
  const std::vector<VerdictReason> pounds = mass_unit_reasons(154.3, tall);
  ASSERT_EQ(pounds.size(), 1u);
  EXPECT_EQ(pounds[0].weight, VerdictReason::Weight::kRemark);
  // A child of 1.1 m and 20 kg, in pounds.
  EXPECT_TRUE(mass_unit_reasons(44.1, {{}, 1.1}).empty());
  EXPECT_FALSE(mass_unit_reasons(44.1, {{}, 1.0}).empty());
}

}  // namespace
}  // namespace sinew
