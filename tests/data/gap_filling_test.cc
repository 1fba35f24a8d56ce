#include "data/gap_filling.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>

namespace sinew {
namespace {

using Eigen::Vector3d;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

// Two rigid bodies of four markers each, A1 … A4 and B1 … B4, that turn and move differently.
MarkerTrajectories two_bodies(int frames = 300) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> uniform(-0.2, 0.2);
  MarkerTrajectories markers;
  markers.rate = 100.0;
  markers.time.resize(frames);
  markers.p_WM.resize(frames, 24);
  for (const char body : {'A', 'B'}) {
    for (int i = 1; i <= 4; ++i) markers.names.push_back(body + std::to_string(i));
  }
  for (int m = 0; m < 8; ++m) {
    const Vector3d p(uniform(random), uniform(random), uniform(random));
    const double side = m < 4 ? 1.0 : -1.0;
    for (int f = 0; f < frames; ++f) {
      const double t = f / markers.rate;
      const Eigen::AngleAxisd turn(0.8 * std::sin((3.0 + side) * t),
                                   Vector3d(0.3, 0.2 * side, 1.0).normalized());
      markers.time[f] = t;
      markers.p_WM.row(f).segment<3>(3 * m) =
          (turn * p + Vector3d(1.2 * t, 0.3 * side, 1.0 + 0.1 * side * std::sin(5.0 * t)))
              .transpose();
    }
  }
  for (int f = 0; f < frames; ++f) markers.frame_numbers.push_back(f + 101);
  return markers;
}

void hide(MarkerTrajectories& markers, int marker, int first, int count) {
  markers.p_WM.block(first, 3 * marker, count, 3).setConstant(kNaN);
}

double largest_error(const MarkerTrajectories& a, const MarkerTrajectories& b) {
  return (a.p_WM - b.p_WM).cwiseAbs().maxCoeff();
}

TEST(GapFilling, RigidGapsComeBackExactlyWhateverTheirLength) {
  const MarkerTrajectories truth = two_bodies();
  MarkerTrajectories markers = truth;
  hide(markers, 1, 50, 150);
  hide(markers, 6, 0, 30);    // the record's beginning
  hide(markers, 4, 280, 20);  // and its end
  const GapFillResult result = fill_gaps(markers, {.rigid = true});
  EXPECT_LT(largest_error(markers, truth), 1e-12);
  ASSERT_EQ(result.filled.size(), 3u);
  EXPECT_TRUE(result.left.empty());
  EXPECT_EQ(result.filled[0].gap, (MarkerGap{1, 50, 150}));
  EXPECT_EQ(result.filled[0].method, FilledGap::Method::kRigid);
  EXPECT_EQ(result.filled[0].from, (std::vector<int>{0, 2, 3}));  // found in the recording
  EXPECT_LT(result.filled[0].error, 1e-12);
}

TEST(GapFilling, SegmentsThatAreSaidGoBeforeDistances) {
  MarkerTrajectories markers = two_bodies();
  hide(markers, 1, 50, 20);
  GapFillOptions options{.rigid = true};
  options.segments = {{0, 1}, {2, 3, 4, 5}};  // only one other marker: too few
  EXPECT_EQ(fill_gaps(markers, options).left, (std::vector<MarkerGap>{{1, 50, 20}}));
  // Markers of the other body move away from it, which the misfit tells.
  options.segments = {{1, 2, 5, 6, 7}};
  EXPECT_EQ(fill_gaps(markers, options).left.size(), 1u);
}

TEST(GapFilling, ATenthOfASecondBySplineIsOffByLessThanAMillimetre) {
  const MarkerTrajectories truth = two_bodies();
  MarkerTrajectories markers = truth;
  hide(markers, 1, 100, 10);
  hide(markers, 2, 150, 11);  // longer than allowed
  const GapFillResult result = fill_gaps(markers, {.max_gap = 0.1});
  ASSERT_EQ(result.filled.size(), 1u);
  EXPECT_EQ(result.filled[0].method, FilledGap::Method::kSpline);
  EXPECT_EQ(result.left, (std::vector<MarkerGap>{{2, 150, 11}}));
  const double error =
      (markers.p_WM.block(100, 3, 10, 3) - truth.p_WM.block(100, 3, 10, 3)).cwiseAbs().maxCoeff();
  EXPECT_LT(error, 1e-3);
  EXPECT_GT(error, 0.0);
  // The estimate, from other frames, is of the same size.
  EXPECT_LT(result.filled[0].error, 2e-3);
  EXPECT_GT(result.filled[0].error, 1e-6);
}

TEST(GapFilling, ASplineGivesACubicBackAndNeverLeavesTheRecord) {
  MarkerTrajectories markers = two_bodies(60);
  for (int f = 0; f < 60; ++f) {
    const double t = f / 100.0;
    markers.p_WM.row(f).head<3>() << 1.0 + 2.0 * t, 3.0 - t,
        0.5;  // straight: natural ends are exact
  }
  const MarkerTrajectories truth = markers;
  hide(markers, 0, 30, 10);
  hide(markers, 1, 0, 3);
  hide(markers, 2, 57, 3);
  hide(markers, 3, 1, 3);  // one frame before it
  const GapFillResult result = fill_gaps(markers, {.max_gap = 1.0});
  EXPECT_EQ(result.filled.size(), 1u);
  EXPECT_EQ(result.left.size(), 3u);
  EXPECT_LT((markers.p_WM.leftCols(3) - truth.p_WM.leftCols(3)).cwiseAbs().maxCoeff(), 1e-13);
}

TEST(GapFilling, NothingIsFilledUnasked) {
  MarkerTrajectories markers = two_bodies();
  hide(markers, 0, 10, 1);
  const GapFillResult result = fill_gaps(markers, {});
  EXPECT_TRUE(result.filled.empty());
  EXPECT_EQ(result.left, (std::vector<MarkerGap>{{0, 10, 1}}));
  EXPECT_TRUE(std::isnan(markers.p_WM(10, 0)));
}

TEST(GapFilling, TheListNamesEverySample) {
  MarkerTrajectories markers = two_bodies();
  hide(markers, 1, 50, 3);
  hide(markers, 5, 7, 1);
  GapFillOptions options{.max_gap = 0.05, .rigid = true};
  options.segments = {{0, 1, 2, 3}};
  const GapFillResult result = fill_gaps(markers, options);
  const std::string csv = filled_gaps_csv(markers, result);
  EXPECT_TRUE(
      csv.starts_with("marker,first_frame,last_frame,from_s,to_s,frames,method,error_m,taken_from\n"
                      "A2,151,153,0.5,0.52,3,rigid,"))
      << csv;
  EXPECT_NE(csv.find(",A1 A3 A4\nB2,108,108,0.07,0.07,1,spline,"), csv.npos) << csv;
}

TEST(GapFilling, OptionsHaveBounds) {
  MarkerTrajectories markers = two_bodies();
  EXPECT_THROW(fill_gaps(markers, {.max_gap = -1.0}), std::invalid_argument);
  EXPECT_THROW(fill_gaps(markers, {.max_misfit = kNaN}), std::invalid_argument);
}

}  // namespace
}  // namespace sinew
