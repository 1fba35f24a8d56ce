#include "data/load_coverage.h"

#include <gtest/gtest.h>

#include <cmath>

#include "data/force_table.h"

namespace sinew {
namespace {

using Eigen::Vector3d;

// A platform of 0.6 × 0.4 m around the origin that carries `force` N in its middle from 0.5 s to
// 1.5 s of two.
ForcePlatformRecording platform(double force) {
  ForcePlatformRecording plate;
  plate.platform.number = 1;
  plate.platform.p_WC.setZero();
  plate.platform.R_WP << 1, 0, 0, 0, 0, -1, 0, 1, 0;
  for (std::size_t k = 0; k < 4; ++k) {
    const double sx = k == 0 || k == 3 ? 0.3 : -0.3, sy = k < 2 ? 0.2 : -0.2;
    plate.platform.corners[k] = plate.platform.R_WP * Vector3d(sx, sy, 0.0);
  }
  plate.rate = 100.0;
  plate.force.setZero(201, 3);
  plate.moment.setZero(201, 3);
  plate.center.setConstant(201, 3, std::nan(""));
  plate.free_moment.setZero(201, 3);
  for (int i = 50; i <= 150; ++i) plate.force(i, 1) = force;
  condition(plate, {.threshold = 20.0});
  return plate;
}

// Heel and toe of the right foot at `right` and of the left at `left`, at rest.
MarkerTrajectories standing(const Vector3d& right, const Vector3d& left) {
  MarkerTrajectories markers;
  markers.names = {"RHEE", "RTOE", "LHEE", "LTOE"};
  markers.rate = 100.0;
  markers.time = Eigen::VectorXd::LinSpaced(201, 0.0, 2.0);
  markers.p_WM.resize(201, 12);
  const Vector3d toe(0.2, 0.0, 0.0);
  for (int f = 0; f < 201; ++f) {
    markers.frame_numbers.push_back(f + 1);
    markers.p_WM.row(f) << right.transpose(), (right + toe).transpose(), left.transpose(),
        (left + toe).transpose();
  }
  return markers;
}

// Lifts the right (0) or left (1) foot by a hand's breadth while the platform carries nothing.
void lift_where_unloaded(MarkerTrajectories& markers, int foot) {
  for (int f = 0; f < 201; ++f) {
    if (f >= 50 && f <= 150) continue;
    for (const int m : {2 * foot, 2 * foot + 1}) markers.p_WM(f, 3 * m + 1) += 0.1;
  }
}

LoadCoverage cover(const MarkerTrajectories& markers, const ForcePlatformRecording& plate,
                   const std::vector<AssignmentOverride>& overrides = {}) {
  const std::vector<ForcePlatformRecording> plates = {plate};
  return load_coverage(markers, assign_feet(markers, find_feet(markers), plates, 20.0, overrides),
                       plates);
}

const Vector3d kOn(-0.1, 0.05, 0.0), kBeside(-0.1, 0.05, 1.0);

TEST(LoadCoverage, StandingBesideThePlatformIsNotMeasured) {
  MarkerTrajectories markers = standing(kOn, kBeside);
  lift_where_unloaded(markers, 0);
  const LoadCoverage coverage = cover(markers, platform(700.0));
  EXPECT_EQ(coverage.feet, (std::vector<std::string>{"right", "left"}));
  EXPECT_EQ(coverage.loads[100][0], FootLoad::kMeasured);
  EXPECT_EQ(coverage.loads[100][1], FootLoad::kUnmeasured);
  // The platform under the right foot says that nothing presses.
  EXPECT_EQ(coverage.loads[10][0], FootLoad::kNone);
  EXPECT_EQ(coverage.complete_frames(0), 201);
  EXPECT_EQ(coverage.complete_frames(1), 0);
  EXPECT_FALSE(coverage.complete(100));
  const Eigen::VectorXd time = Eigen::VectorXd::LinSpaced(201, 0.0, 2.0);
  EXPECT_EQ(complete_times(coverage, 0, time), "0.00 s to 2.00 s");
  EXPECT_EQ(complete_times(coverage, 1, time), "none");
}

TEST(LoadCoverage, TwoFeetOnOnePlatformCannotBeUsed) {
  MarkerTrajectories markers = standing(kOn, kOn + Vector3d(0, 0, -0.15));
  lift_where_unloaded(markers, 0);
  lift_where_unloaded(markers, 1);
  LoadCoverage coverage = cover(markers, platform(700.0));
  EXPECT_EQ(coverage.loads[100][0], FootLoad::kUnusable);
  EXPECT_EQ(coverage.loads[100][1], FootLoad::kUnusable);
  EXPECT_EQ(coverage.loads[10][1], FootLoad::kNone);
  const Eigen::VectorXd time = Eigen::VectorXd::LinSpaced(201, 0.0, 2.0);
  EXPECT_EQ(complete_times(coverage, 0, time), "0.00 s to 0.49 s, 1.51 s to 2.00 s");
  // Who says that it is the left one's takes the right for unloaded: it stands above a platform
  // that carries somebody else, so that nothing is known of it.
  coverage = cover(markers, platform(700.0), {{1, "left", {}, {}}});
  EXPECT_EQ(coverage.loads[100][0], FootLoad::kUnmeasured);
  EXPECT_EQ(coverage.loads[100][1], FootLoad::kMeasured);
}

// A dead platform, or one that is elsewhere than the file says.
TEST(LoadCoverage, AFootThatRestsOnAPlatformWithoutForceIsNotMeasured) {
  const LoadCoverage dead = cover(standing(kOn, kBeside), platform(0.0));
  EXPECT_EQ(dead.complete_frames(0), 0);
  EXPECT_EQ(dead.loads[100][0], FootLoad::kUnmeasured);
  // It comes down on it a moment before the force shows.
  MarkerTrajectories markers = standing(kOn, kBeside);
  lift_where_unloaded(markers, 0);
  markers.p_WM.block(40, 1, 10, 1) = markers.p_WM.block(50, 1, 10, 1);
  EXPECT_EQ(cover(markers, platform(700.0)).complete_frames(0), 201);
}

TEST(LoadCoverage, AFootInTheAirNeedsNoPlatform) {
  MarkerTrajectories markers = standing(kOn, kBeside);
  for (int f = 0; f < 201; ++f) {
    for (const int m : {2, 3}) markers.p_WM(f, 3 * m) += 2.0 * markers.time[f];
  }
  LoadCoverage coverage = cover(markers, platform(700.0));
  EXPECT_EQ(coverage.loads[100][1], FootLoad::kNone);
  EXPECT_TRUE(coverage.complete(100));
  markers.p_WM.middleCols(6, 6).setConstant(std::nan(""));
  coverage = cover(markers, platform(700.0));
  EXPECT_EQ(coverage.loads[100][1], FootLoad::kUnknown);
}

}  // namespace
}  // namespace sinew
