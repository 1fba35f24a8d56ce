#include "data/carried_mass.h"

#include <gtest/gtest.h>

#include <cmath>

namespace sinew {
namespace {

constexpr double kMass = 71.0, kGravity = 9.80665;
constexpr int kSamples = 2001;  // of 2 s

// Platforms of 1000 Hz that carry what `force` says of each at a time [N].
template <typename Force>
std::vector<ForcePlatformRecording> platforms(int count, const Force& force) {
  std::vector<ForcePlatformRecording> plates(static_cast<std::size_t>(count));
  for (int p = 0; p < count; ++p) {
    ForcePlatformRecording& plate = plates[static_cast<std::size_t>(p)];
    plate.platform.number = p + 1;
    plate.rate = 1000.0;
    plate.force.setZero(kSamples, 3);
    for (int i = 0; i < kSamples; ++i) plate.force(i, 1) = force(p, i / 1000.0);
  }
  return plates;
}

TEST(StandingMass, IsWhatAllPlatformsCarryInTheStillestStretch) {
  // Steps on at 0.4 s, sways by 2 % of the weight, with a third of it on the second platform.
  const auto standing = [](int plate, double t) {
    if (t < 0.4) return 0.0;
    const double weight = kMass * kGravity * (1.0 + 0.02 * std::sin(2.0 * M_PI * t / 0.2));
    return weight * (plate == 0 ? 2.0 : 1.0) / 3.0;
  };
  const std::optional<double> mass = standing_mass(platforms(2, standing));
  ASSERT_TRUE(mass);
  EXPECT_NEAR(*mass, kMass, 1e-3 * kMass);
}

TEST(StandingMass, IsNothingWhereNobodyStandsStill) {
  EXPECT_FALSE(standing_mass({}));
  EXPECT_FALSE(standing_mass(platforms(1, [](int, double) { return 20.0; })));
  EXPECT_FALSE(standing_mass(platforms(
      1, [](int, double t) { return kMass * kGravity * (1.0 + 0.3 * std::sin(2.0 * M_PI * t)); })));
}

class StrideMassOf : public ::testing::Test {
 protected:
  // Right, left and right foot, each 0.7 s on a platform of its own, strides of 1 s; together they
  // carry the weight and a wave of the stride's length, whose mean is nothing.
  StrideMassOf() {
    assignment.feet = {{"right", "calcn_r", {}}, {"left", "calcn_l", {}}};
    for (int step = 0; step < 3; ++step) {
      PlateContact contact;
      contact.plate = step;
      contact.from = 0.2 + 0.5 * step;
      contact.to = contact.from + 0.7;
      contact.foot = step % 2;
      contact.state = PlateContact::State::kAssigned;
      assignment.contacts.push_back(contact);
    }
    coverage.feet = {"right", "left"};
    coverage.loads.assign(201, {FootLoad::kMeasured, FootLoad::kNone});
    plates = platforms(3, [this](int plate, double t) {
      const auto stands = [&](std::size_t k) {
        return t >= assignment.contacts[k].from && t <= assignment.contacts[k].to;
      };
      const int standing = stands(0) + stands(1) + stands(2);
      const double force = kMass * kGravity * (1.0 + 0.3 * std::sin(2.0 * M_PI * t));
      return stands(static_cast<std::size_t>(plate)) ? force / standing : 0.0;
    });
  }

  std::optional<StrideMass> found() const {
    return stride_mass(assignment, coverage, time, plates);
  }

  FootAssignment assignment;
  LoadCoverage coverage;
  std::vector<ForcePlatformRecording> plates;
  Eigen::VectorXd time = Eigen::VectorXd::LinSpaced(201, 0.0, 2.0);
};

TEST_F(StrideMassOf, IsTheMeanFromStrikeToStrike) {
  ASSERT_TRUE(found());
  EXPECT_EQ(found()->strides, 1);
  EXPECT_NEAR(found()->mass, kMass, 1e-9 * kMass);
}

TEST_F(StrideMassOf, IsNothingWithoutAWholeStrideOfKnownLoads) {
  coverage.loads[60][1] = FootLoad::kUnmeasured;
  EXPECT_FALSE(found());
  coverage.loads[60][1] = FootLoad::kNone;
  assignment.contacts[2].state = PlateContact::State::kUnusable;
  EXPECT_FALSE(found());
  assignment.contacts[2].state = PlateContact::State::kAssigned;
  assignment.contacts[0].from = 0.0;  // stands there already when the record begins
  EXPECT_FALSE(found());
}

}  // namespace
}  // namespace sinew
