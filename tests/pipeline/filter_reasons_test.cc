#include "pipeline/filter_reasons.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "data/conditioning.h"
#include "model/osim_file.h"
#include "tests/pipeline/small_trial.h"

namespace sinew {
namespace {

// A trunk that goes along, and a hip that swings by 0.4 rad once a second: 20 times.
class Filtered : public ::testing::Test {
 protected:
  static constexpr int kFrames = 2001;
  static constexpr double kRate = 100.0;

  Filtered() {
    folder_.write("model.osim", SmallTrial::model());
    model_ = read_osim(folder_.path() / "model.osim");
    motion_.time = Eigen::VectorXd::LinSpaced(kFrames, 0.0, (kFrames - 1) / kRate);
    motion_.q = RowMatrix::Zero(kFrames, 4);
    motion_.q.col(1) = 1.2 * motion_.time;
    motion_.q.col(3) = 0.4 * (2.0 * std::numbers::pi * motion_.time.array()).sin();
    motion_.measured = {true, true, true, true};
  }

  // RMS of what two passes of a third-order Butterworth take from the hip [degrees].
  static double taken(double cutoff) {
    const double ratio =
        std::tan(std::numbers::pi / kRate) / std::tan(std::numbers::pi * cutoff / kRate);
    const double gain = 1.0 / (1.0 + std::pow(ratio, 6.0));
    return 0.4 / std::numbers::sqrt2 * (1.0 - gain) * 180.0 / std::numbers::pi;
  }

  TemporaryFolder folder_;
  MusculoskeletalModel model_;
  CoordinateTable motion_;
};

TEST_F(Filtered, AnglesAreJudgedByWhatIsTakenFromThem) {
  EXPECT_TRUE(angle_filter_reasons(model_, motion_, 6.0).empty());
  EXPECT_TRUE(angle_filter_reasons(model_, motion_, -1.0).empty());
  ASSERT_LT(taken(1.5), 1.5);
  EXPECT_TRUE(angle_filter_reasons(model_, motion_, 1.5).empty());
  const std::vector<VerdictReason> some = angle_filter_reasons(model_, motion_, 1.3);
  ASSERT_EQ(some.size(), 1u);
  EXPECT_EQ(some[0].code, "angle-filter");
  EXPECT_EQ(some[0].weight, VerdictReason::Weight::kRemark);
  EXPECT_NEAR(some[0].figure, taken(1.3), 0.05);
  EXPECT_TRUE(some[0].torques.empty());
  EXPECT_EQ(some[0].text,
            "the filter of 1.3 Hz takes part of the movement away, most of flexion (RMS)");
  const std::vector<VerdictReason> most = angle_filter_reasons(model_, motion_, 0.5);
  ASSERT_EQ(most.size(), 1u);
  EXPECT_EQ(most[0].weight, VerdictReason::Weight::kUnusable);
  EXPECT_NEAR(most[0].figure, taken(0.5), 0.2);
  EXPECT_EQ(most[0].torques.size(), 4u);
  // Noise is what filters are for: 20 Hz that swing by as much.
  motion_.q.col(3) = 0.4 * (40.0 * std::numbers::pi * motion_.time.array()).sin();
  EXPECT_TRUE(angle_filter_reasons(model_, motion_, 1.0).empty());
}

// One marker of several swings by 0.1 m once a second.
TEST_F(Filtered, MarkersAreJudgedByWhatIsTakenFromTheOneThatMovesMost) {
  MarkerTrajectories markers;
  markers.rate = kRate;
  markers.names = {"STILL", "HEEL"};
  markers.time = motion_.time;
  for (int f = 0; f < kFrames; ++f) markers.frame_numbers.push_back(f + 1);
  markers.p_WM = RowMatrix::Constant(kFrames, 6, 0.5);
  const auto swing = [&](double hertz) {
    markers.p_WM.col(4) =
        0.1 * (2.0 * std::numbers::pi * hertz * motion_.time.array()).sin().matrix();
  };
  const auto millimetres = [](double cutoff) {
    return taken(cutoff) * std::numbers::pi / 180.0 / 0.4 * 100.0;
  };
  const auto reasons_at = [&](double cutoff) {
    MarkerTrajectories filtered = markers;
    if (cutoff > 0.0) lowpass(filtered, cutoff);
    return marker_filter_reasons(markers, filtered, cutoff);
  };
  swing(1.0);
  EXPECT_TRUE(reasons_at(6.0).empty());
  EXPECT_TRUE(reasons_at(-1.0).empty());
  ASSERT_LT(millimetres(1.5), 10.0);
  EXPECT_TRUE(reasons_at(1.5).empty());
  std::vector<VerdictReason> reasons = reasons_at(1.3);
  ASSERT_EQ(reasons.size(), 1u);
  EXPECT_EQ(reasons[0].code, "marker-filter");
  EXPECT_EQ(reasons[0].weight, VerdictReason::Weight::kRemark);
  EXPECT_NEAR(reasons[0].figure, millimetres(1.3), 0.1);
  EXPECT_EQ(reasons[0].text,
            "the filter of 1.3 Hz takes part of the movement away, most of HEEL (RMS)");
  reasons = reasons_at(0.5);
  ASSERT_EQ(reasons.size(), 1u);
  EXPECT_EQ(reasons[0].weight, VerdictReason::Weight::kUnusable);
  EXPECT_NEAR(reasons[0].figure, millimetres(0.5), 0.3);
  // Noise is what filters are for, and where nothing is measured nothing is moved.
  swing(20.0);
  EXPECT_TRUE(reasons_at(1.0).empty());
  markers.p_WM.setConstant(std::nan(""));
  EXPECT_TRUE(reasons_at(1.0).empty());
}

}  // namespace
}  // namespace sinew
