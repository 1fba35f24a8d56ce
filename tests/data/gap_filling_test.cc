#include "data/gap_filling.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>

#include "data/input_error.h"
#include "tests/data/test_files.h"

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
  hide(markers, 1, 0, 3);  // the ends: longer than a parabola goes on
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

TEST(GapFilling, TheListComesBackWithWhatWasLeft) {
  MarkerTrajectories markers = two_bodies();
  hide(markers, 1, 50, 3);
  hide(markers, 5, 7, 1);
  hide(markers, 6, 100, 40);
  GapFillOptions options{.max_gap = 0.05, .rigid = true};
  options.segments = {{0, 1, 2, 3}};
  const GapFillResult result = fill_gaps(markers, options);
  ASSERT_EQ(result.left, (std::vector<MarkerGap>{{6, 100, 40}}));
  const TemporaryFolder folder;
  folder.write("filled.csv", filled_gaps_csv(markers, result));
  const std::vector<FilledGap> read = read_filled_gaps(folder.path() / "filled.csv", markers);
  ASSERT_EQ(read.size(), 3u);
  EXPECT_EQ(read[0].gap, (MarkerGap{1, 50, 3}));
  EXPECT_EQ(read[0].method, FilledGap::Method::kRigid);
  EXPECT_NEAR(read[0].error, result.filled[0].error, 1e-2 * result.filled[0].error);
  EXPECT_EQ(read[1].method, FilledGap::Method::kSpline);
  EXPECT_EQ(read[2].gap, (MarkerGap{6, 100, 40}));
  EXPECT_EQ(read[2].method, FilledGap::Method::kNone);
  EXPECT_TRUE(std::isnan(read[2].error));
  folder.write("bad.csv",
               "marker,first_frame,last_frame,from_s,to_s,frames,method,error_m,taken_from\n"
               "A2,151,153,0.5,0.52,3,guess,,\n");
  try {
    read_filled_gaps(folder.path() / "bad.csv", markers);
    ADD_FAILURE() << "no error";
  } catch (const InputError& error) {
    EXPECT_EQ(error.where().line, 2);
    EXPECT_NE(std::string(error.what()).find("tells no method and error"), std::string::npos);
  }
}

// Skin that slides by millimetres within tenths of a second: over one frame neighbours in time know
// better, over 0.3 s neighbours on the body do, and the list says how well.
TEST(GapFilling, TheBetterOfTheTwoIsTakenAndItsErrorIsTold) {
  std::mt19937 random(11);
  std::normal_distribution<double> noise(0.0, 2e-4);
  MarkerTrajectories truth = two_bodies();
  for (int m = 0; m < 8; ++m) {
    for (int f = 0; f < truth.frame_count(); ++f) {
      const double slide = 0.003 * std::sin(25.0 * truth.time[f] + m);
      truth.p_WM.row(f).segment<3>(3 * m) +=
          Eigen::RowVector3d(slide + noise(random), noise(random), -slide + noise(random));
    }
  }
  for (const int count : {1, 3, 10, 30}) {
    double squares = 0.0, told = 0.0;
    int gaps = 0;
    for (int first = 40; first < 240; first += 20, ++gaps) {
      MarkerTrajectories markers = truth;
      hide(markers, 2, first, count);
      const GapFillResult result = fill_gaps(markers, {.max_gap = 0.1, .rigid = true});
      ASSERT_EQ(result.filled.size(), 1u);
      const FilledGap& filled = result.filled[0];
      if (count == 1) {
        EXPECT_EQ(filled.method, FilledGap::Method::kSpline);
      }
      if (count == 30) {
        EXPECT_EQ(filled.method, FilledGap::Method::kRigid);
      }
      squares += (markers.p_WM - truth.p_WM).block(first, 6, count, 3).squaredNorm() / count;
      told += filled.error * filled.error;
    }
    // Ten gaps: the RMS of both is known to a third.
    EXPECT_LT(std::sqrt(squares / gaps), 1.7 * std::sqrt(told / gaps)) << count;
    EXPECT_GT(std::sqrt(squares / gaps), std::sqrt(told / gaps) / 1.7) << count;
  }
}

// At an end only one side tells where the marker was on the body, and the estimate knows.
TEST(GapFilling, AnEndIsFilledFromTheBodyOnlyAndNotFromThreeFrames) {
  MarkerTrajectories truth = two_bodies();
  for (int f = 0; f < truth.frame_count(); ++f) {
    truth.p_WM(f, 6) += 0.004 * std::sin(12.0 * truth.time[f]);
  }
  MarkerTrajectories inside = truth, end = truth, three = truth, alone = truth;
  hide(inside, 2, 200, 20);
  hide(end, 2, 280, 20);
  const GapFillResult of_inside = fill_gaps(inside, {.rigid = true});
  const GapFillResult of_end = fill_gaps(end, {.rigid = true});
  ASSERT_EQ(of_inside.filled.size(), 1u);
  ASSERT_EQ(of_end.filled.size(), 1u);
  EXPECT_GT(of_end.filled[0].error, 1.5 * of_inside.filled[0].error);
  const double off = (end.p_WM - truth.p_WM).cwiseAbs().maxCoeff();
  EXPECT_GT(off, 0.0);
  EXPECT_LT(off, 3.0 * of_end.filled[0].error);
  hide(three, 2, 0, 100);
  hide(three, 2, 103, 197);
  EXPECT_EQ(fill_gaps(three, {.max_gap = 5.0, .rigid = true}).left,
            (std::vector<MarkerGap>{{2, 0, 100}, {2, 103, 197}}));
  hide(alone, 2, 280, 20);
  EXPECT_EQ(fill_gaps(alone, {.max_gap = 5.0}).left, (std::vector<MarkerGap>{{2, 280, 20}}));
}

TEST(GapFilling, OptionsHaveBounds) {
  MarkerTrajectories markers = two_bodies();
  EXPECT_THROW(fill_gaps(markers, {.max_gap = -1.0}), std::invalid_argument);
  EXPECT_THROW(fill_gaps(markers, {.max_misfit = kNaN}), std::invalid_argument);
}

}  // namespace
}  // namespace sinew
