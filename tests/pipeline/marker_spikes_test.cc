#include "data/marker_spikes.h"

#include <gtest/gtest.h>

#include <random>

#include "data/reference_walk.h"
#include "dynamics/reference_recording.h"
#include "model/whole_body.h"

namespace sinew {
namespace {

const MarkerTrajectories& walk() {
  static const MarkerTrajectories markers = [] {
    WholeBodyOptions body;
    body.level = WholeBodyOptions::Level::kSimplified;
    return make_reference_recording(whole_body(body), reference_walk()).markers;
  }();
  return markers;
}

MarkerTrajectories noisy(double sd) {
  std::mt19937 random(7);
  std::normal_distribution<double> normal(0.0, sd);
  MarkerTrajectories markers = walk();
  for (Eigen::Index i = 0; i < markers.p_WM.size(); ++i) markers.p_WM.data()[i] += normal(random);
  return markers;
}

TEST(MarkerSpikes, AreNotFoundInAWalk) {
  EXPECT_TRUE(find_marker_spikes(walk()).empty());
  EXPECT_TRUE(find_marker_spikes(noisy(0.003)).empty());
  MarkerTrajectories giant = walk();
  giant.p_WM *= 1000.0;
  EXPECT_TRUE(find_marker_spikes(giant).empty());
}

TEST(MarkerSpikes, OfEveryMarkerAndDistanceAreFound) {
  const MarkerTrajectories clean = noisy(0.001);
  const int last = clean.frame_count() - 1;
  for (int m = 0; m < clean.marker_count(); ++m) {
    for (const double distance : {0.3, 10.0, 1000.0}) {
      for (const int frame : {0, 1, 37 + m, 150, last - 1, last}) {
        MarkerTrajectories markers = clean;
        markers.p_WM(frame, 3 * m + m % 3) += distance;
        const std::vector<MarkerSpike> found = find_marker_spikes(markers);
        ASSERT_EQ(found.size(), 1u)
            << clean.names[static_cast<std::size_t>(m)] << " " << frame << " " << distance;
        EXPECT_EQ(found[0].marker, m);
        EXPECT_EQ(found[0].first, frame);
        EXPECT_EQ(found[0].last, frame);
        EXPECT_NEAR(found[0].distance, distance, 0.06);
      }
    }
  }
}

TEST(MarkerSpikes, MayLastAndMayStandBesideGaps) {
  const MarkerTrajectories clean = noisy(0.001);
  MarkerTrajectories markers = clean;
  markers.p_WM.block(60, 3 * 5 + 1, 6, 1).array() += 0.4;  // 0.06 s
  markers.p_WM.block(100, 3 * 9, 20, 3).setConstant(std::nan(""));
  markers.p_WM(99, 3 * 9) += 0.5;  // a ghost where the marker goes out of sight
  markers.p_WM.block(40, 3 * 12, 120, 1).array() += 1000.0;  // away for long
  markers.p_WM(20, 3 * 15) += 0.03;                          // within what cameras do
  const std::vector<MarkerSpike> found = find_marker_spikes(markers);
  ASSERT_EQ(found.size(), 3u);
  EXPECT_EQ(found[0].marker, 5);
  EXPECT_EQ(found[0].first, 60);
  EXPECT_EQ(found[0].last, 65);
  EXPECT_EQ(found[1].marker, 9);
  EXPECT_EQ(found[1].first, 99);
  EXPECT_EQ(found[1].last, 99);
  EXPECT_EQ(found[2].marker, 12);
  EXPECT_EQ(found[2].first, 40);
  EXPECT_EQ(found[2].last, 159);
  leave_out(markers, found);
  EXPECT_EQ(markers.p_WM.array().isNaN().count(), 3 * (6 + 21 + 120));
  EXPECT_TRUE(find_marker_spikes(markers).empty());
}

TEST(MarkerSpikes, AMarkerThatIsAKilometreOffIsNowhere) {
  MarkerTrajectories markers = walk();
  markers.p_WM.col(3 * 4).array() += 1000.0;
  const std::vector<MarkerSpike> found = find_marker_spikes(markers);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].marker, 4);
  EXPECT_EQ(found[0].first, 0);
  EXPECT_EQ(found[0].last, markers.frame_count() - 1);
}

TEST(MarkerSpikes, OptionsHaveBounds) {
  EXPECT_THROW(find_marker_spikes(walk(), {.least = 0.0}), std::invalid_argument);
}

}  // namespace
}  // namespace sinew
