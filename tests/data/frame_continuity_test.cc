#include "data/frame_continuity.h"

#include <gtest/gtest.h>

#include <cmath>

namespace sinew {
namespace {

MarkerTrajectories moving() {
  MarkerTrajectories markers;
  markers.rate = 100.0;
  markers.names = {"A", "B"};
  markers.time = Eigen::VectorXd::LinSpaced(101, 0.0, 1.0);
  markers.p_WM = RowMatrix::Zero(101, 6);
  for (int f = 0; f < 101; ++f) {
    markers.frame_numbers.push_back(f + 1);
    markers.p_WM.row(f).setConstant(std::sin(3.0 * markers.time[f]));
  }
  markers.p_WM.block(20, 3, 30, 3).setConstant(std::nan(""));
  return markers;
}

TEST(FrameReasons, MovingFramesHaveNone) { EXPECT_TRUE(frame_reasons(moving()).empty()); }

TEST(FrameReasons, FramesThatStandStillAreNamed) {
  MarkerTrajectories markers = moving();
  const Eigen::RowVectorXd once = markers.p_WM.row(30);
  for (int f = 31; f <= 32; ++f) markers.p_WM.row(f) = once;
  EXPECT_TRUE(frame_reasons(markers).empty());  // as resampling leaves
  for (int f = 33; f <= 36; ++f) markers.p_WM.row(f) = once;
  const std::vector<VerdictReason> reasons = frame_reasons(markers);
  ASSERT_EQ(reasons.size(), 1u);
  EXPECT_EQ(reasons[0].code, "frozen-frames");
  EXPECT_EQ(reasons[0].weight, VerdictReason::Weight::kUnusable);
  EXPECT_EQ(reasons[0].figure, 6.0);
  EXPECT_EQ(reasons[0].text, "all markers stand still from 0.300 s to 0.360 s and jump then");
  // A static trial that somebody made stands still altogether.
  for (int f = 1; f < 101; ++f) markers.p_WM.row(f) = markers.p_WM.row(0);
  EXPECT_TRUE(frame_reasons(markers).empty());
  markers.p_WM.setConstant(std::nan(""));
  EXPECT_TRUE(frame_reasons(markers).empty());
}

TEST(FrameReasons, HolesInTimeAreNamed) {
  MarkerTrajectories markers = moving();
  markers.time.tail(40).array() += 0.01;  // one frame was dropped
  EXPECT_TRUE(frame_reasons(markers).empty());
  markers.time.tail(40).array() += 0.2;
  const std::vector<VerdictReason> reasons = frame_reasons(markers);
  ASSERT_EQ(reasons.size(), 1u);
  EXPECT_EQ(reasons[0].code, "time-hole");
  EXPECT_EQ(reasons[0].weight, VerdictReason::Weight::kRemark);
  EXPECT_NEAR(reasons[0].figure, 0.22, 1e-12);
  EXPECT_NEAR(reasons[0].limit, 0.025, 1e-12);
}

}  // namespace
}  // namespace sinew
