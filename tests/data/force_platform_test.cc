#include "data/force_platform.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <random>

#include "tests/data/test_files.h"

namespace sinew {
namespace {

using Eigen::Vector3d;

// A platform of 0.6 × 0.4 m, its x along -y of the laboratory, its y along -x, z down; C at
// (1, 2, 0). Corners in mm.
const std::vector<float> kCorners = {800, 1700, 0, 800, 2300, 0, 1200, 2300, 0, 1200, 1700, 0};
const Vector3d kCenter(1.0, 2.0, 0.0);
const Eigen::Matrix3d kAxes = (Eigen::Matrix3d() << 0, -1, 0, -1, 0, 0, 0, 0, -1).finished();

struct Load {
  Vector3d force;  // on the subject, in the laboratory [N]
  Vector3d p_WQ;   // centre of pressure [m]
  double torque;   // free moment about z of the laboratory [N·m]
};

std::vector<Load> random_loads() {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  std::vector<Load> loads;
  for (int i = 0; i < 20; ++i) {
    loads.push_back(
        {Vector3d(80 * uniform(random), 80 * uniform(random), 500 + 300 * uniform(random)),
         kCenter + Vector3d(0.15 * uniform(random), 0.25 * uniform(random), 0.0),
         10 * uniform(random)});
  }
  return loads;
}

// What a platform of type 2 measures about a point, in its axes: N and N·mm.
Eigen::Matrix<double, 6, 1> wrench_about(const Load& load, const Vector3d& p_WO) {
  const Vector3d moment = (load.p_WQ - p_WO).cross(load.force) + Vector3d(0.0, 0.0, load.torque);
  Eigen::Matrix<double, 6, 1> result;
  result << kAxes.transpose() * load.force, 1e3 * kAxes.transpose() * moment;
  return result;
}

C3dFile file_with(int type, const std::vector<float>& origin, const RowMatrix& samples,
                  std::vector<std::string> units) {
  C3dFile file;
  file.path = "test.c3d";
  file.layout.rate = 100.0;
  file.layout.frames = samples.rows();
  file.layout.analog_ratio = 1;
  file.analog.rate = 100.0;
  file.analog.samples_per_frame = 1;
  file.analog.values = samples;
  file.analog.units = std::move(units);
  std::vector<std::int16_t> channels;
  for (int i = 1; i <= samples.cols(); ++i) {
    file.analog.labels.push_back(std::to_string(i));
    channels.push_back(static_cast<std::int16_t>(i));
  }
  const auto set = [&](C3dParameter parameter) {
    set_parameter(file.groups, "FORCE_PLATFORM", std::move(parameter));
  };
  set(C3dParameter::of_integers("USED", {}, {1}));
  set(C3dParameter::of_integers("TYPE", {1}, {static_cast<std::int16_t>(type)}));
  set(C3dParameter::of_reals("CORNERS", {3, 4, 1}, kCorners));
  set(C3dParameter::of_reals("ORIGIN", {3, 1}, origin));
  set(C3dParameter::of_integers("CHANNEL", {static_cast<int>(samples.cols()), 1}, channels));
  return file;
}

const std::vector<std::string> kUnits = {"N", "N", "N", "Nmm", "Nmm", "Nmm"};

// Samples of type 2 about the transducers' origin, 40 mm under the surface and 2 and 3 mm aside.
RowMatrix type2_samples(const std::vector<Load>& loads) {
  const Vector3d p_WO = kCenter - kAxes * Vector3d(0.002, -0.003, -0.040);
  RowMatrix samples(static_cast<Eigen::Index>(loads.size()), 6);
  for (std::size_t i = 0; i < loads.size(); ++i) {
    samples.row(static_cast<Eigen::Index>(i)) = wrench_about(loads[i], p_WO).transpose();
  }
  return samples;
}

void expect_loads(const ForcePlatforms& platforms, const std::vector<Load>& loads,
                  const std::string& warnings = "") {
  EXPECT_EQ(to_text(platforms.warnings), warnings);
  ASSERT_EQ(platforms.recordings.size(), 1u);
  const ForcePlatformRecording& recording = platforms.recordings[0];
  for (std::size_t i = 0; i < loads.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    const Load& load = loads[i];
    EXPECT_LE((recording.force.row(row).transpose() - load.force).norm(), 1e-9);
    EXPECT_LE((recording.center.row(row).transpose() - load.p_WQ).norm(), 1e-9);
    EXPECT_LE((recording.free_moment.row(row).transpose() - Vector3d(0, 0, load.torque)).norm(),
              1e-7);
    const Vector3d moment = (load.p_WQ - kCenter).cross(load.force) + Vector3d(0, 0, load.torque);
    EXPECT_LE((recording.moment.row(row).transpose() - moment).norm(), 1e-7);
  }
}

TEST(ForcePlatform, Type2FindsRandomLoads) {
  const std::vector<Load> loads = random_loads();
  expect_loads(compute_forces(file_with(2, {2, -3, -40}, type2_samples(loads), kUnits)), loads);
}

TEST(ForcePlatform, OriginAboveTheSurfaceIsTurnedRound) {
  const std::vector<Load> loads = random_loads();
  expect_loads(compute_forces(file_with(2, {-2, 3, 40}, type2_samples(loads), kUnits)), loads,
               "0: force platform 1: FORCE_PLATFORM:ORIGIN lies above its surface; the sign was "
               "changed\n");
}

TEST(ForcePlatform, ForcesOnThePlatformAreTurnedRound) {
  const std::vector<Load> loads = random_loads();
  expect_loads(
      compute_forces(file_with(2, {2, -3, -40}, -type2_samples(loads), kUnits)), loads,
      "0: force platform 1: its forces push the subject down; they were taken as forces on "
      "the platform and turned round\n");
}

TEST(ForcePlatform, UnitsOfMomentsAreReadOrCorrected) {
  const std::vector<Load> loads = random_loads();
  RowMatrix samples = type2_samples(loads);
  const std::vector<std::string> wrong = {"N", "N", "N", "N-M", "N-M", "N-M"};
  const ForcePlatforms corrected = compute_forces(file_with(2, {2, -3, -40}, samples, wrong));
  ASSERT_EQ(corrected.warnings.size(), 1u);
  EXPECT_NE(corrected.warnings[0].text.find("moments were multiplied by 0.001"), std::string::npos);
  samples.rightCols(3) *= 1e-3;
  expect_loads(compute_forces(file_with(2, {2, -3, -40}, samples, wrong)), loads);
}

// Half the distances of four transducers, and how deep they lie [m].
constexpr double kA = 0.25, kB = 0.15, kDepth = 0.05;
const std::vector<float> kTransducers = {250, 150, -50};

// fx12, fx34, fy14, fy23, fz1, ..., fz4 that have the wrench of each load.
RowMatrix pairs_of(const std::vector<Load>& loads) {
  RowMatrix samples(static_cast<Eigen::Index>(loads.size()), 8);
  for (std::size_t i = 0; i < loads.size(); ++i) {
    const auto w = wrench_about(loads[i], kCenter + kAxes * Vector3d(0, 0, kDepth));
    const double mx = 1e-3 * w[3] / kB, my = 1e-3 * w[4] / kA, mz = 1e-3 * w[5];
    // The moment about z is left to the pair along x.
    samples.row(static_cast<Eigen::Index>(i)) << 0.5 * (w[0] - mz / kB), 0.5 * (w[0] + mz / kB),
        0.5 * w[1], 0.5 * w[1], 0.25 * (w[2] + mx - my), 0.25 * (w[2] + mx + my),
        0.25 * (w[2] - mx + my), 0.25 * (w[2] - mx - my);
  }
  return samples;
}

Eigen::MatrixXf random_calibration(int rows, int columns) {
  std::mt19937 random(5);
  std::uniform_real_distribution<float> uniform(-0.05f, 0.05f);
  Eigen::MatrixXf result(rows, columns);
  for (float& value : result.reshaped()) value = uniform(random);
  result.diagonal().array() += 2.0f;
  return result;
}

// A file whose channels are volts that `calibration` makes `physical` of.
C3dFile calibrated_file(int type, const std::vector<float>& origin, const RowMatrix& physical,
                        const Eigen::MatrixXf& calibration) {
  const Eigen::MatrixXd inverse =
      calibration.cast<double>().completeOrthogonalDecomposition().pseudoInverse();
  const RowMatrix volts = physical * inverse.transpose();
  C3dFile file = file_with(type, origin, volts,
                           std::vector<std::string>(static_cast<std::size_t>(volts.cols()), "V"));
  set_parameter(file.groups, "FORCE_PLATFORM",
                C3dParameter::of_reals(
                    "CAL_MATRIX",
                    {static_cast<int>(calibration.rows()), static_cast<int>(calibration.cols()), 1},
                    {calibration.data(), calibration.data() + calibration.size()}));
  return file;
}

TEST(ForcePlatform, Type3CombinesFourTransducers) {
  const std::vector<Load> loads = random_loads();
  expect_loads(
      compute_forces(file_with(3, kTransducers, pairs_of(loads), std::vector<std::string>(8, "N"))),
      loads);
}

TEST(ForcePlatform, Type4CalibratesByColumns) {
  const std::vector<Load> loads = random_loads();
  expect_loads(compute_forces(calibrated_file(4, {2, -3, -40}, type2_samples(loads),
                                              random_calibration(6, 6))),
               loads);
}

TEST(ForcePlatform, Type5CalibratesEightChannelsToSix) {
  const std::vector<Load> loads = random_loads();
  expect_loads(compute_forces(calibrated_file(5, {2, -3, -40}, type2_samples(loads),
                                              random_calibration(6, 8))),
               loads);
}

TEST(ForcePlatform, Type6CombinesTwelveForces) {
  const std::vector<Load> loads = random_loads();
  const RowMatrix pairs = pairs_of(loads);
  RowMatrix forces(pairs.rows(),
                   12);  // fx1, fy1, fz1, fx2, ...; shares within a pair do not matter
  forces << 0.3 * pairs.col(0), 0.6 * pairs.col(2), pairs.col(4), 0.7 * pairs.col(0),
      0.9 * pairs.col(3), pairs.col(5), 0.2 * pairs.col(1), 0.1 * pairs.col(3), pairs.col(6),
      0.8 * pairs.col(1), 0.4 * pairs.col(2), pairs.col(7);
  expect_loads(compute_forces(calibrated_file(6, kTransducers, forces, random_calibration(12, 12))),
               loads);
}

TEST(ForcePlatform, Type7CalibratesFourTransducers) {
  const std::vector<Load> loads = random_loads();
  expect_loads(
      compute_forces(calibrated_file(7, kTransducers, pairs_of(loads), random_calibration(8, 8))),
      loads);
  const C3dFile bare =
      file_with(7, kTransducers, pairs_of(loads), std::vector<std::string>(8, "N"));
  expect_loads(compute_forces(bare), loads,
               "0: force platform 1: FORCE_PLATFORM:CAL_MATRIX is missing; its channels were taken "
               "as forces and moments\n");
}

TEST(ForcePlatform, Type1HoldsTheCenterItself) {
  const std::vector<Load> loads = random_loads();
  RowMatrix samples(static_cast<Eigen::Index>(loads.size()), 6);
  for (std::size_t i = 0; i < loads.size(); ++i) {
    const Vector3d force = kAxes.transpose() * loads[i].force;
    const Vector3d p_CQ = 1e3 * (kAxes.transpose() * (loads[i].p_WQ - kCenter));
    samples.row(static_cast<Eigen::Index>(i)) << force.transpose(), p_CQ.x(), p_CQ.y(),
        -1e3 * loads[i].torque;
  }
  expect_loads(compute_forces(file_with(1, {0, 0, 0}, samples, {"N", "N", "N", "mm", "mm", "Nmm"})),
               loads);
}

TEST(ForcePlatform, BaselineIsSubtractedUnlessSomeoneStandsThere) {
  std::vector<Load> loads = random_loads();
  for (std::size_t i = 0; i < 5; ++i) loads[i] = {Vector3d::Zero(), kCenter, 0.0};
  Eigen::Matrix<double, 1, 6> offset;
  offset << 3, -4, 20, 500, -700, 300;
  C3dFile file = file_with(2, {2, -3, -40}, type2_samples(loads).rowwise() + offset, kUnits);
  set_parameter(file.groups, "FORCE_PLATFORM", C3dParameter::of_integers("ZERO", {2}, {0, 5}));
  const ForcePlatforms zeroed = compute_forces(file);
  EXPECT_EQ(to_text(zeroed.warnings), "");
  EXPECT_LE((zeroed.recordings[0].force.row(7).transpose() - loads[7].force).norm(), 1e-9);
  EXPECT_TRUE(std::isnan(zeroed.recordings[0].center(2, 0)));
  EXPECT_TRUE(std::isnan(zeroed.recordings[0].free_moment(2, 2)));
  EXPECT_LE(zeroed.recordings[0].force.row(2).norm(), 1e-9);

  loads = random_loads();
  file = file_with(2, {2, -3, -40}, type2_samples(loads), kUnits);
  set_parameter(file.groups, "FORCE_PLATFORM", C3dParameter::of_integers("ZERO", {2}, {1, 5}));
  const ForcePlatforms standing = compute_forces(file);
  ASSERT_EQ(standing.warnings.size(), 1u);
  EXPECT_NE(standing.warnings[0].text.find("no baseline was subtracted"), std::string::npos);
  EXPECT_LE((standing.recordings[0].force.row(7).transpose() - loads[7].force).norm(), 1e-9);
}

TEST(ForcePlatform, SaysWhyAPlatformCannotBeUsed) {
  const auto problem = [](const std::function<void(C3dFile&)>& spoil) {
    C3dFile file = file_with(2, {2, -3, -40}, type2_samples(random_loads()), kUnits);
    spoil(file);
    const ForcePlatforms platforms = compute_forces(file);
    EXPECT_EQ(platforms.warnings.size(), 1u);
    const ForcePlatformRecording& recording = platforms.recordings.at(0);
    EXPECT_FALSE(recording.platform.usable());
    EXPECT_EQ(recording.sample_count(), 0);
    return recording.platform.problem;
  };
  const auto set = [](C3dFile& file, C3dParameter parameter) {
    set_parameter(file.groups, "FORCE_PLATFORM", std::move(parameter));
  };
  EXPECT_EQ(
      problem([&](C3dFile& file) { set(file, C3dParameter::of_integers("TYPE", {1}, {11})); }),
      "type 11 is not supported; types 1 to 7 are");
  EXPECT_EQ(problem([&](C3dFile& file) { set(file, C3dParameter::of_integers("TYPE", {1}, {5})); }),
            "FORCE_PLATFORM:CHANNEL does not name its 8 channels");
  EXPECT_EQ(problem([&](C3dFile& file) {
              set(file, C3dParameter::of_integers("TYPE", {1}, {4}));
              set(file, C3dParameter::of_reals("CAL_MATRIX", {6, 8, 1}, std::vector<float>(48)));
            }),
            "FORCE_PLATFORM:CAL_MATRIX has 48 values, not 6 × 6 for it");
  EXPECT_EQ(problem([&](C3dFile& file) {
              std::vector<float> corners = kCorners;
              corners[4] = 1e20f;
              set(file, C3dParameter::of_reals("CORNERS", {3, 4, 1}, corners));
            }),
            "FORCE_PLATFORM:CORNERS are no platform's: one is far away or no number");
  EXPECT_EQ(problem([&](C3dFile& file) {
              set(file, C3dParameter::of_reals("CORNERS", {3, 4, 1}, std::vector<float>(12)));
            }),
            "FORCE_PLATFORM:CORNERS are no platform's: a side is 0 mm long");
  EXPECT_EQ(problem([&](C3dFile& file) {
              std::vector<float> corners = kCorners;
              corners[1] = 900;
              set(file, C3dParameter::of_reals("CORNERS", {3, 4, 1}, corners));
            }),
            "FORCE_PLATFORM:CORNERS are no platform's: opposite sides are 1400 and 600 mm long");
  EXPECT_EQ(problem([&](C3dFile& file) {
              set(file, C3dParameter::of_integers("CHANNEL", {6, 1}, {1, 2, 3, 4, 5, 60}));
            }),
            "FORCE_PLATFORM:CHANNEL names channel 60; the file has 6");
  EXPECT_EQ(problem([&](C3dFile& file) { set(file, C3dParameter::of_reals("ORIGIN", {0}, {})); }),
            "FORCE_PLATFORM:ORIGIN does not give its three numbers");
}

TEST(ForcePlatform, OptionsAreChecked) {
  EXPECT_THROW(compute_forces(C3dFile(), {.threshold = -1.0}), std::invalid_argument);
}

}  // namespace
}  // namespace sinew
