#include "data/conditioning.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "data/butterworth.h"

namespace sinew {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

// One marker whose x, y and z are a wave, its tenth and a constant.
MarkerTrajectories wave(double rate, int frames, double hertz) {
  MarkerTrajectories markers;
  markers.names = {"A"};
  markers.rate = rate;
  markers.time.resize(frames);
  markers.p_WM.resize(frames, 3);
  for (int i = 0; i < frames; ++i) {
    markers.time[i] = i / rate;
    markers.frame_numbers.push_back(i + 1);
    const double x = std::sin(2.0 * std::numbers::pi * hertz * i / rate);
    markers.p_WM.row(i) << x, 0.1 * x, 5.0;
  }
  return markers;
}

double middle_amplitude(const MarkerTrajectories& markers) {
  const int n = markers.frame_count();
  return markers.p_WM.col(0).segment(n / 4, n / 2).cwiseAbs().maxCoeff();
}

TEST(Lowpass, HasHalfTheGainAtTheCutoffAndNoDelay) {
  // Two passes of 1/√2 each; 10 Hz at 1000 Hz hits the crests.
  MarkerTrajectories markers = wave(1000.0, 2001, 10.0);
  const RowMatrix before = markers.p_WM;
  EXPECT_EQ(lowpass(markers, 10.0), 0);
  EXPECT_NEAR(middle_amplitude(markers), 0.5, 1e-3);
  const Eigen::VectorXd x = markers.p_WM.col(0).segment(500, 1000);
  EXPECT_LT((x - 0.5 * before.col(0).segment(500, 1000)).cwiseAbs().maxCoeff(), 2e-3);
  EXPECT_LT((markers.p_WM.col(2).array() - 5.0).abs().maxCoeff(), 1e-9);
}

TEST(Lowpass, KeepsGapsAndFiltersEachSideByItself) {
  MarkerTrajectories whole = wave(100.0, 80, 3.0), gap = wave(100.0, 100, 3.0);
  gap.p_WM.middleRows(80, 15).setConstant(kNaN);  // five frames are left behind it
  lowpass(whole, 6.0);
  const RowMatrix tail = gap.p_WM.bottomRows(5);
  EXPECT_EQ(lowpass(gap, 6.0), 5);
  EXPECT_EQ(gap.p_WM.topRows(80), whole.p_WM);
  EXPECT_TRUE(gap.p_WM.middleRows(80, 15).array().isNaN().all());
  EXPECT_EQ(gap.p_WM.bottomRows(5), tail);
}

TEST(Lowpass, SaysWhatDoesNotFit) {
  MarkerTrajectories markers = wave(100.0, 50, 3.0);
  EXPECT_THROW(lowpass(markers, 50.0), std::invalid_argument);
  TimeTable table;
  table.labels = {"x"};
  table.time = Eigen::VectorXd::LinSpaced(10, 0.0, 0.9);
  table.values = RowMatrix::Zero(10, 1);
  table.values(3, 0) = kNaN;
  try {
    lowpass(table, 2.0);
    FAIL();
  } catch (const std::invalid_argument& error) {
    EXPECT_STREQ(error.what(),
                 "column 'x' has missing values; filtering needs every one. Fill or drop it.");
  }
  table.values(3, 0) = 0.0;
  table.time[4] += 0.05;
  try {
    lowpass(table, 2.0);
    FAIL();
  } catch (const std::invalid_argument& error) {
    EXPECT_STREQ(error.what(),
                 "the time steps are not equal: 0.15 s at 0.45 s, 0.1 s in the mean. Resample "
                 "first.");
  }
}

TEST(Resample, FollowsASmoothCurve) {
  const MarkerTrajectories markers = wave(100.0, 201, 1.0);
  const MarkerTrajectories finer = resample(markers, 250.0);
  EXPECT_EQ(finer.frame_count(), 501);
  EXPECT_DOUBLE_EQ(finer.time[500], 2.0);
  // The cubic's error, 5/384 h⁴ max|x''''| = 5/384 · 1e-8 · (2π)⁴, away from the natural ends.
  for (int i = 50; i < 450; ++i) {
    const double x = std::sin(2.0 * std::numbers::pi * finer.time[i]);
    EXPECT_NEAR(finer.p_WM(i, 0), x, 2.1e-7) << i;
  }
  // Every fifth frame of the finer one is every second of the given.
  const MarkerTrajectories back = resample(finer, 50.0);
  for (int i = 0; i < back.frame_count(); ++i) {
    EXPECT_NEAR(back.p_WM(i, 0), markers.p_WM(2 * i, 0), 1e-12);
  }
}

TEST(Resample, GapsStayGaps) {
  MarkerTrajectories markers = wave(100.0, 101, 1.0);
  markers.p_WM.middleRows(40, 11).setConstant(kNaN);  // 0.40 to 0.50 s
  const MarkerTrajectories other = resample(markers, 200.0);
  for (int i = 0; i < other.frame_count(); ++i) {
    const bool inside = other.time[i] > 0.39 + 1e-6 && other.time[i] < 0.51 - 1e-6;
    EXPECT_EQ(std::isnan(other.p_WM(i, 0)), inside) << other.time[i];
  }
}

TEST(Slice, KeepsTimesAndNumbers) {
  const MarkerTrajectories part = slice(wave(100.0, 20, 1.0), 5, 8);
  EXPECT_EQ(part.frame_numbers, (std::vector<int>{6, 7, 8}));
  EXPECT_EQ(part.time, Eigen::Vector3d(0.05, 0.06, 0.07));
  EXPECT_EQ(part.p_WM.rows(), 3);
}

}  // namespace
}  // namespace sinew
