#include "data/sample_spikes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace sinew {
namespace {

// Two steps onto a platform as a type 2's Fz sees them, with a heel's impact and noise [N].
Eigen::VectorXd steps(double rate = 1000.0, double noise = 1.5) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal(0.0, noise);
  Eigen::VectorXd samples(static_cast<Eigen::Index>(2.0 * rate));
  for (Eigen::Index i = 0; i < samples.size(); ++i) {
    const double t = std::fmod(static_cast<double>(i) / rate, 1.0);
    double force = 0.0;
    if (t > 0.2 && t < 0.8) {
      const double s = (t - 0.2) / 0.6, impact = (t - 0.22) / 0.006;
      force = 900.0 * std::sin(M_PI * s) + 150.0 * std::sin(3.0 * M_PI * s) +
              400.0 * std::exp(-impact * impact);
    }
    samples[i] = force + normal(random);
  }
  return samples;
}

TEST(SampleSpikes, AreNotFoundWhereThereAreNone) {
  EXPECT_TRUE(find_sample_spikes(steps(), 1000.0).empty());
  EXPECT_TRUE(find_sample_spikes(steps(1000.0, 0.0), 1000.0).empty());
  // An impact between two samples of 100 Hz.
  EXPECT_TRUE(find_sample_spikes(steps(100.0), 100.0).empty());
  EXPECT_TRUE(find_sample_spikes(Eigen::VectorXd::Zero(500), 1000.0).empty());
  EXPECT_TRUE(find_sample_spikes(Eigen::VectorXd(), 1000.0).empty());
}

TEST(SampleSpikes, AreFoundWhereverTheyAre) {
  const Eigen::VectorXd clean = steps();
  for (const Eigen::Index at : {40, 225, 500, 790, 1300, 1999}) {
    for (const double value :
         {-1500.0, 5000.0, 1e30, -1e12, std::nan(""), std::numeric_limits<double>::infinity()}) {
      Eigen::VectorXd samples = clean;
      samples[at] = value;
      // The last sample has no neighbour behind it: only what is beyond all measure shows.
      if (at == 1999 && std::abs(value) < 1e6) continue;
      const std::vector<SampleSpike> found = find_sample_spikes(samples, 1000.0);
      ASSERT_EQ(found.size(), 1u) << at << ": " << value;
      EXPECT_EQ(found[0].first, at);
      EXPECT_EQ(found[0].last, at);
      bridge_samples(samples, at, at);
      const double line = at == 1999 ? clean[1998] : 0.5 * (clean[at - 1] + clean[at + 1]);
      EXPECT_DOUBLE_EQ(samples[at], line);
    }
  }
  Eigen::VectorXd samples = clean;
  samples.segment(600, 3).setConstant(-4000.0);
  const std::vector<SampleSpike> found = find_sample_spikes(samples, 1000.0);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0], (SampleSpike{600, 602, -4000.0}));
}

// Centres of pressure jump by themselves; what is on no floor does not belong to them.
TEST(SampleSpikes, PlacesMayJumpButNotLeaveTheEarth) {
  Eigen::VectorXd place = Eigen::VectorXd::Zero(300);
  place.segment(100, 1).setConstant(1.3);
  EXPECT_TRUE(find_sample_spikes(place, 1000.0, true).empty());
  place[200] = 1e30;
  EXPECT_EQ(find_sample_spikes(place, 1000.0, true).size(), 1u);
  // A channel that is mostly wild is broken, and nothing mends it.
  place.head(200).setConstant(1e30);
  EXPECT_TRUE(find_sample_spikes(place, 1000.0, true).empty());
}

TEST(SampleSpikes, OptionsHaveBounds) {
  SampleSpikeOptions options;
  options.wild = 0.0;
  EXPECT_THROW(find_sample_spikes(steps(), 1000.0, false, options), std::invalid_argument);
}

}  // namespace
}  // namespace sinew
