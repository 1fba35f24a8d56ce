#include "data/preflight_forces.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "data/c3d_reader.h"
#include "data/recording_edits.h"
#include "tests/data/test_files.h"

namespace sinew {
namespace {

constexpr double kRate = 1000.0;
constexpr double kStep = 0.5;  // of a converter [N]

// Two steps of a walk on one platform, in the converter's whole steps.
Eigen::VectorXd walking(double noise = 0.0, unsigned seed = 1) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal(0.0, 1.0);
  Eigen::VectorXd force(4000);
  for (Eigen::Index i = 0; i < force.size(); ++i) {
    const double t = std::fmod(static_cast<double>(i) / kRate, 2.0) - 0.6;
    double f = 0.0;
    if (t > 0.0 && t < 0.7) {
      const double s = std::numbers::pi * t / 0.7;
      f = 950.0 * std::sin(s) + 300.0 * std::sin(3.0 * s);
    }
    force[i] = kStep * std::round((f + noise * normal(random)) / kStep);
  }
  return force;
}

TEST(FlatTops, AreFoundWhereAChannelIsCutOff) {
  for (const double limit : {300.0, 600.0, 750.0}) {
    for (const double noise : {0.0, 1.0}) {
      const Eigen::VectorXd cut = walking(noise).cwiseMin(limit);
      const std::vector<FlatTop> tops = find_flat_tops(cut, {});
      ASSERT_EQ(tops.size(), 1u) << limit << " " << noise;
      EXPECT_EQ(tops[0].value, limit);
      EXPECT_GE(tops[0].stretches, 2);
      EXPECT_EQ(cut[tops[0].first], limit);
      EXPECT_EQ(cut[tops[0].first + tops[0].count - 1], limit);
      EXPECT_EQ(find_flat_tops(-cut, {}).size(), 1u);
    }
  }
}

TEST(FlatTops, AreNotRoundedPeaksNorUnloadedPlatforms) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    for (const double noise : {0.0, 0.3, 1.0, 3.0}) {
      const Eigen::VectorXd force = walking(noise, seed);
      EXPECT_TRUE(find_flat_tops(force, {}).empty()) << seed << " " << noise;
      EXPECT_TRUE(find_flat_tops(-force, {}).empty()) << seed << " " << noise;
    }
  }
  // Coarse steps make long plateaus of smooth peaks.
  const Eigen::VectorXd coarse = (walking() / 20.0).array().round() * 20.0;
  EXPECT_TRUE(find_flat_tops(coarse, {}).empty());
  EXPECT_TRUE(find_flat_tops(Eigen::VectorXd::Zero(500), {}).empty());
  EXPECT_TRUE(find_flat_tops(Eigen::VectorXd::Constant(500, 40.0), {}).empty());
}

TEST(FlatTops, CountAtTheConvertersEndHoweverOften) {
  // Loaded most of the time, as on a treadmill.
  Eigen::VectorXd force = walking().cwiseMin(600.0);
  for (Eigen::Index i = 0; i < force.size(); ++i) {
    if (i % 2000 > 700 && i % 2000 < 1900) force[i] = 600.0;
  }
  EXPECT_TRUE(find_flat_tops(force, {}).empty());
  EXPECT_EQ(find_flat_tops(force, {-600.5, 600.0}).size(), 1u);
}

ForcePlatformRecording plate_of(const Eigen::VectorXd& normal) {
  ForcePlatformRecording plate;
  plate.platform.number = 2;
  plate.platform.type = 2;
  // z points into the ground, as C3D platforms have it.
  plate.platform.R_WP = Eigen::Vector3d(1.0, -1.0, -1.0).asDiagonal();
  plate.rate = kRate;
  plate.force.setZero(normal.size(), 3);
  plate.force.col(2) = normal;
  plate.moment = plate.free_moment = plate.force;
  plate.center.setZero(normal.size(), 3);
  return plate;
}

TEST(Baseline, AnOffsetIsFoundWithItsTime) {
  EXPECT_TRUE(find_baseline_faults(plate_of(walking(1.0)), 20.0).empty());
  ForcePlatformRecording plate = plate_of(walking(1.0));
  plate.force.col(0).array() += 8.0;
  std::vector<Finding> found = find_baseline_faults(plate, 20.0);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].severity, Finding::Severity::kWarning);
  EXPECT_EQ(found[0].where, "platform 2");
  EXPECT_NE(found[0].text.find("unloaded it shows 8.0,"), std::string::npos) << found[0].text;
  ASSERT_EQ(found[0].flags.size(), 2u);
  // Within the longest time without a step, 1.3 s to 2.6 s.
  const UnloadedTime time = parse_unloaded(found[0].flags[1]).value();
  EXPECT_EQ(time.plate, 2);
  EXPECT_GE(time.from, 1.3);
  EXPECT_LE(time.to, 2.6);
  EXPECT_GT(time.to - time.from, 1.2);
  plate.force.col(2).array() += 35.0;
  found = find_baseline_faults(plate, 20.0);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].severity, Finding::Severity::kError);
}

TEST(Baseline, ADriftIsFoundWithTwoTimes) {
  ForcePlatformRecording plate = plate_of(walking(1.0));
  plate.force.col(2) += Eigen::VectorXd::LinSpaced(4000, 0.0, 30.0);
  const std::vector<Finding> found = find_baseline_faults(plate, 20.0);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_NE(found[0].text.find("drifts by"), std::string::npos) << found[0].text;
  ASSERT_EQ(found[0].flags.size(), 4u);
  EXPECT_LT(parse_unloaded(found[0].flags[1]).value().to, 0.6);
  EXPECT_GT(parse_unloaded(found[0].flags[3]).value().from, 3.3);
}

TEST(Baseline, SomeoneWhoStandsAllTheTimeIsNoOffset) {
  const std::vector<Finding> found =
      find_baseline_faults(plate_of(Eigen::VectorXd::Constant(3000, 350.0)), 20.0);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].severity, Finding::Severity::kNote);
}

// A published recording with an offset.
TEST(Baseline, RealPlatformsAreZeroedAsTheFlagSays) {
  const std::filesystem::path folder = "../shared/data";
  if (!std::filesystem::is_directory(folder)) GTEST_SKIP() << "no ../shared/data";
  C3dFile file = read_c3d(folder / "c3d.org/sample_03/gait-pig.c3d");
  // Else the file's own baseline would take the offset away.
  set_parameter(file.groups, "FORCE_PLATFORM", C3dParameter::of_integers("ZERO", {2}, {0, 0}));
  const auto faults = [&](int number) {
    std::vector<Finding> found;
    for (const auto& plate : compute_forces(file).recordings) {
      if (plate.platform.number == number) found = find_baseline_faults(plate, 20.0);
    }
    return found;
  };
  ASSERT_TRUE(faults(1).empty());
  std::vector<Warning> ignored;
  const auto platforms = find_force_platforms(file, ignored);
  const auto fx = static_cast<Eigen::Index>(platforms[0].channels[0]);
  file.analog.values.col(fx).array() += 15.0;
  const std::vector<Finding> found = faults(1);
  ASSERT_EQ(found.size(), 1u);
  RecordingEdits edits;
  edits.unloaded = {parse_unloaded(found[0].flags.at(1)).value()};
  edit_recording(file, edits);
  EXPECT_TRUE(faults(1).empty());
}

}  // namespace
}  // namespace sinew
