#include "data/reference_laboratory.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>

#include "data/c3d_writer.h"
#include "data/force_platform.h"
#include "data/laboratory_axes.h"
#include "tests/data/test_files.h"

namespace sinew {
namespace {

using Eigen::Vector3d;

constexpr int kFrames = 221;
constexpr double kRate = 100.0;  // [Hz]

// Two markers of the walk's way, one of them lost for a while.
MarkerTrajectories markers() {
  MarkerTrajectories markers;
  markers.names = {"RHEE", "LHEE"};
  markers.rate = kRate;
  markers.time = Eigen::VectorXd::LinSpaced(kFrames, 0.0, kFrames - 1.0) / kRate;
  markers.p_WM.resize(kFrames, 6);
  for (int i = 0; i < kFrames; ++i) {
    markers.frame_numbers.push_back(i + 1);
    const double x = 1.36 * markers.time[i];
    markers.p_WM.row(i) << x, 0.08, 0.06, x + 0.1, 0.09, -0.06;
  }
  markers.p_WM.block(40, 3, 5, 3).setConstant(std::nan(""));
  return markers;
}

// Any loads at all under feet that stand, each foot's around its own footprint.
TimeTable random_forces(const ReferenceWalk& walk) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  TimeTable forces;
  forces.time = Eigen::VectorXd::LinSpaced(10 * kFrames, 0.0, 10 * kFrames - 1.0) / 1000.0;
  forces.values.setZero(10 * kFrames, 18);
  for (const ReferenceStep& step : steps_of(walk, 2.2)) {
    for (Eigen::Index i = 0; i < forces.time.size(); ++i) {
      if (forces.time[i] <= step.strike || forces.time[i] >= step.toe_off) continue;
      const auto u = [&] { return uniform(random); };
      forces.values.row(i).segment<9>(9 * step.foot) << 100 * u(), 500 + 300 * u(), 80 * u(),
          step.p_MC.x() + 0.15 * u(), 0.0, step.p_MC.z() + 0.05 * u(), 0.0, 8 * u(), 0.0;
    }
  }
  return forces;
}

TEST(ReferenceLaboratory, StepsFollowEachOtherOnTheFootprints) {
  const ReferenceWalk walk = reference_walk();
  const std::vector<ReferenceStep> steps = steps_of(walk, 2.2);
  ASSERT_EQ(steps.size(), 6u);  // left before the beginning, r, l, r, l, r at the end
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const auto phase = 0.5 * (static_cast<double>(i) - 1.0);
    EXPECT_EQ(steps[i].foot, i % 2 == 0 ? 1 : 0);
    EXPECT_NEAR(steps[i].strike, phase * walk.stride_time, 1e-12);
    EXPECT_NEAR(steps[i].toe_off, (phase + 0.62) * walk.stride_time, 1e-12);
    // The heel steps on the stride's part of the way; its footprint is 0.267 m long.
    EXPECT_NEAR(steps[i].p_MC.x(), phase * walk.stride_length + 0.5 * 0.267, 0.005);
    EXPECT_EQ(steps[i].p_MC.z() > 0.0, steps[i].foot == 0);
  }
  EXPECT_TRUE(steps_of(walk, 0.1).size() == 2);
}

TEST(ReferenceLaboratory, ReadingGivesMarkersLoadsAndEventsBack) {
  const TemporaryFolder folder;
  const std::filesystem::path path = folder.path() / "walk.c3d";
  const ReferenceWalk walk = reference_walk();
  const TimeTable forces = random_forces(walk);
  write_c3d(path, reference_laboratory(walk, markers(), forces));

  C3dFile file = read_c3d(path);
  EXPECT_EQ(to_text(file.warnings), "");
  EXPECT_EQ(file.layout.analog_ratio, 10);
  AxisEvidence evidence;
  evidence.markers = &file.markers;
  evidence.screen = file.screen;
  const LaboratoryAxes axes = find_axes(evidence);
  EXPECT_EQ(axis_name(axes.up.axis) + axis_name(axes.forward.axis), "zy");
  EXPECT_TRUE(axes.contradictions.empty());
  const Eigen::Matrix3d R_MW = axes.rotation();
  rotate_vectors(R_MW, file.markers.p_WM);
  const MarkerTrajectories given = markers();
  for (Eigen::Index i = 0; i < given.p_WM.size(); ++i) {
    const double x = given.p_WM.data()[i], y = file.markers.p_WM.data()[i];
    ASSERT_TRUE(std::isnan(x) ? std::isnan(y) : std::abs(x - y) < 2e-7) << x << " " << y;
  }

  const ForcePlatforms platforms = compute_forces(file, {.threshold = 1.0});
  EXPECT_EQ(to_text(platforms.warnings), "");
  const std::vector<ReferenceStep> steps = steps_of(walk, 2.2);
  ASSERT_EQ(platforms.recordings.size(), steps.size());
  for (std::size_t s = 0; s < steps.size(); ++s) {
    const ForcePlatformRecording& r = platforms.recordings[s];
    EXPECT_LT((R_MW * r.platform.p_WC - steps[s].p_MC).norm(), 1e-7);
    EXPECT_GT(r.platform.R_WP(1, 0), 0.999999);   // x forward
    EXPECT_LT(r.platform.R_WP(2, 2), -0.999999);  // z down
    for (Eigen::Index i = 0; i < r.force.rows(); ++i) {
      const auto load = forces.values.row(i).segment<9>(9 * steps[s].foot);
      if (forces.time[i] <= steps[s].strike || forces.time[i] >= steps[s].toe_off) {
        ASSERT_EQ(r.force.row(i).norm(), 0.0);
        continue;
      }
      // 32 bits: 6e-8 of 800 N, and of 0.2 m at 200 N.
      ASSERT_LT((R_MW * r.force.row(i).transpose() - load.head<3>().transpose()).norm(), 1e-4);
      ASSERT_LT((R_MW * r.center.row(i).transpose() - load.segment<3>(3).transpose()).norm(), 2e-7);
      ASSERT_LT((R_MW * r.free_moment.row(i).transpose() - load.tail<3>().transpose()).norm(),
                1e-4);
    }
  }

  ASSERT_EQ(file.events.size(), 9u);
  EXPECT_EQ(file.events[0].label + " " + file.events[0].context, "Foot Strike Right");
  EXPECT_NEAR(file.events[0].time, 0.0, 1e-6);
  EXPECT_EQ(file.events[1].label + " " + file.events[1].context, "Foot Off Left");
  EXPECT_NEAR(file.events[1].time, 0.12 * 1.1, 1e-6);
  EXPECT_EQ(file.events[2].label + " " + file.events[2].context, "Foot Strike Left");
  EXPECT_NEAR(file.events[2].time, 0.55, 1e-6);
}

TEST(ReferenceLaboratory, RefusesForcesThatDoNotFit) {
  const ReferenceWalk walk = reference_walk();
  TimeTable forces = random_forces(walk);
  forces.time.conservativeResize(2201);
  try {
    reference_laboratory(walk, markers(), forces);
    FAIL();
  } catch (const std::invalid_argument& e) {
    EXPECT_STREQ(e.what(),
                 "reference_laboratory got forces at 2201 times; they must cover 221 frames at a "
                 "whole multiple of 100 Hz");
  }
}

}  // namespace
}  // namespace sinew
