#include "dynamics/external_loads.h"

#include <gtest/gtest.h>

#include <array>
#include <limits>
#include <stdexcept>
#include <string>

#include "tests/dynamics/two_link_model.h"

namespace sinew {
namespace {

constexpr double kMissing = std::numeric_limits<double>::quiet_NaN();

ExternalLoadsSetup setup_on(const std::string& body) {
  ExternalForce force;
  force.name = "plate";
  force.applied_to_body = body;
  force.force_columns = {"fx", "fy", "fz"};
  force.point_columns = {"px", "py", "pz"};
  force.torque_columns = {"mx", "my", "mz"};
  force.line = 7;
  ExternalLoadsSetup setup;
  setup.path = "loads.xml";
  setup.forces = {force};
  return setup;
}

// Rows of force, point and torque, 0.1 s apart.
TimeTableFile recording(const RowMatrix& values) {
  TimeTableFile file;
  file.path = "grf.mot";
  file.table.labels = {"fx", "fy", "fz", "px", "py", "pz", "mx", "my", "mz"};
  file.table.values = values;
  file.table.time.resize(values.rows());
  for (Eigen::Index i = 0; i < values.rows(); ++i) file.table.time[i] = 0.1 * i;
  return file;
}

RowMatrix constant_rows(int rows) {
  Eigen::Matrix<double, 1, 9> row;
  row << 10.0, 700.0, -20.0, 0.3, 0.1, 0.2, 1.0, 2.0, 3.0;
  return row.replicate(rows, 1);
}

std::string error_of(const ExternalLoadsSetup& setup, const TimeTableFile& file,
                     const ExternalLoadsOptions& options = {}) {
  try {
    ExternalLoads(two_link_model(), setup, file, options);
  } catch (const std::exception& error) {
    return error.what();
  }
  return "no error";
}

// Spatial forces at the pose with shoulder at `shoulder` and elbow at `elbow`.
struct Posed {
  MusculoskeletalModel model = two_link_model();
  SimbodyModel compiled{model};
  SimTK::State state = compiled.default_state();

  Posed(double shoulder, double elbow) {
    compiled.set_q(state, std::array{shoulder, elbow});
    compiled.system().realize(state, SimTK::Stage::Position);
  }
  SimTK::SpatialVec force_on(const ExternalLoads& loads, double t, int body) const {
    SimTK::Vector_<SimTK::SpatialVec> F(compiled.matter().getNumBodies());
    F.setToZero();
    loads.add_body_forces(t, compiled, state, F);
    return F[compiled.body(body)];
  }
};

void expect_vector(const SimTK::Vec3& actual, const Eigen::Vector3d& expected) {
  EXPECT_LT((to_eigen(actual) - expected).norm(), 1e-10)
      << to_eigen(actual).transpose() << " instead of " << expected.transpose();
}

TEST(ExternalLoads, AreNoneByDefault) {
  const ExternalLoads none;
  EXPECT_EQ(none.size(), 0);
  none.require_coverage(-1e9, 1e9);
  expect_vector(Posed(0.4, 0.2).force_on(none, 0.0, 2)[1], Eigen::Vector3d::Zero());
}

TEST(ExternalLoads, ActAtAPointInGround) {
  const Posed posed(0.4, 0.2);
  const ExternalLoads loads(posed.model, setup_on("lower"), recording(constant_rows(10)));
  const Eigen::Vector3d f{10, 700, -20}, p{0.3, 0.1, 0.2}, m{1, 2, 3};
  // The elbow, lower's origin, 0.4 m along the upper link turned by 0.4 rad from -y.
  const Eigen::Vector3d elbow{0.4 * std::sin(0.4), -0.4 * std::cos(0.4), 0.0};
  const SimTK::SpatialVec F = posed.force_on(loads, 0.35, 2);
  expect_vector(F[1], f);
  expect_vector(F[0], m + (p - elbow).cross(f));
  expect_vector(posed.force_on(loads, 0.35, 1)[1], Eigen::Vector3d::Zero());
}

TEST(ExternalLoads, TurnWithTheFramesTheyAreGivenIn) {
  const Posed posed(0.4, 0.2);
  ExternalLoadsSetup setup = setup_on("lower");
  setup.forces[0].force_expressed_in_body = "lower";
  setup.forces[0].point_expressed_in_body = "upper";
  const ExternalLoads loads(posed.model, setup, recording(constant_rows(10)));
  const Eigen::Matrix3d R_upper =
      Eigen::AngleAxisd(0.4, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  const Eigen::Matrix3d R_lower =
      Eigen::AngleAxisd(0.6, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  const Eigen::Vector3d f = R_lower * Eigen::Vector3d(10, 700, -20);
  const Eigen::Vector3d p = R_upper * Eigen::Vector3d(0.3, 0.1, 0.2);
  const Eigen::Vector3d elbow = R_upper * Eigen::Vector3d(0.0, -0.4, 0.0);
  const SimTK::SpatialVec F = posed.force_on(loads, 0.35, 2);
  expect_vector(F[1], f);
  expect_vector(F[0], R_lower * Eigen::Vector3d(1, 2, 3) + (p - elbow).cross(f));
}

TEST(ExternalLoads, ActAtTheBodysOriginWithoutAPoint) {
  const Posed posed(0.4, 0.2);
  ExternalLoadsSetup setup = setup_on("lower");
  setup.forces[0].point_columns.clear();
  setup.forces[0].torque_columns.clear();
  const ExternalLoads loads(posed.model, setup, recording(constant_rows(10)));
  const SimTK::SpatialVec F = posed.force_on(loads, 0.0, 2);
  expect_vector(F[1], {10, 700, -20});
  expect_vector(F[0], Eigen::Vector3d::Zero());
}

TEST(ExternalLoads, SkipForcesThatDoNotApply) {
  ExternalLoadsSetup setup = setup_on("nobody");
  setup.forces[0].applies = false;
  EXPECT_EQ(ExternalLoads(two_link_model(), setup, recording(constant_rows(4))).size(), 0);
}

TEST(ExternalLoads, FollowNaturalCubicsFromFourSamplesOn) {
  RowMatrix values = constant_rows(4);
  values.col(1) = Eigen::Vector4d(0.0, 1.0, 0.0, 0.0);
  const ExternalLoads loads(two_link_model(), setup_on("lower"), recording(values));
  // Natural cubic through 0, 1, 0, 0 at unit steps: second derivatives 0, -16/5, 9/5... by hand
  // from M0 + 4 M1 + M2 = 6 (y0 - 2 y1 + y2): 4 M1 + M2 = -12, M1 + 4 M2 = 6, so M1 = -18/5, M2 =
  // 12/5.
  const auto by_hand = [](double m0, double m1, double y0, double y1, double s) {
    return y0 + s * (y1 - y0) - s * (1 - s) * ((2 - s) * m0 + (1 + s) * m1) / 6.0;
  };
  EXPECT_NEAR(loads.sample(0, 0.05).force.y(), by_hand(0.0, -3.6, 0.0, 1.0, 0.5), 1e-13);
  EXPECT_NEAR(loads.sample(0, 0.12).force.y(), by_hand(-3.6, 2.4, 1.0, 0.0, 0.2), 1e-13);
  EXPECT_NEAR(loads.sample(0, 0.27).force.y(), by_hand(2.4, 0.0, 0.0, 0.0, 0.7), 1e-13);
  EXPECT_NEAR(loads.sample(0, 0.2).point.x(), 0.3, 1e-13);
}

TEST(ExternalLoads, FollowLinesOrConstantsBelowFourSamples) {
  RowMatrix values = constant_rows(3);
  values.col(1) = Eigen::Vector3d(0.0, 1.0, 0.0);
  const ExternalLoads lines(two_link_model(), setup_on("lower"), recording(values));
  EXPECT_NEAR(lines.sample(0, 0.05).force.y(), 0.5, 1e-13);
  EXPECT_NEAR(lines.sample(0, 0.125).force.y(), 0.75, 1e-13);
  const ExternalLoads constant(two_link_model(), setup_on("lower"), recording(constant_rows(1)));
  EXPECT_EQ(constant.sample(0, 12.0).force.y(), 700.0);
  constant.require_coverage(0.0, 100.0);
}

TEST(ExternalLoads, FillMissingPointsOfForcesThatAreZero) {
  RowMatrix values = constant_rows(7);
  values.block(2, 0, 3, 3).setZero();
  values.block(2, 3, 3, 3).setConstant(kMissing);
  values.block(5, 3, 2, 1).setConstant(0.7);
  const ExternalLoads loads(two_link_model(), setup_on("lower"), recording(values));
  EXPECT_NEAR(loads.sample(0, 0.3).point.x(), 0.5, 1e-12);  // halfway from 0.3 to 0.7
  ASSERT_EQ(loads.warnings().size(), 1u);
  EXPECT_EQ(to_string(loads.warnings()[0]),
            "loads.xml:7: external force 'plate' has no point in 3 rows where it is zero; filled "
            "from the rows around them");
  values(3, 1) = 5.0;
  EXPECT_EQ(
      error_of(setup_on("lower"), recording(values)),
      "grf.mot: column 'px' of the external loads in row 3, at 0.2 s; expected a number, found "
      "nan. Fill the gap, or write zeros if nothing touched the plate.");
}

TEST(ExternalLoads, DropIdenticalRowsAtOneTime) {
  TimeTableFile file = recording(constant_rows(6));
  file.table.time[3] = file.table.time[2];
  const ExternalLoads loads(two_link_model(), setup_on("lower"), file);
  ASSERT_EQ(loads.warnings().size(), 1u);
  EXPECT_EQ(loads.warnings()[0].text, "dropped 1 repeated rows of external loads");
  file.table.values(3, 0) = 11.0;
  EXPECT_EQ(error_of(setup_on("lower"), file),
            "grf.mot: two rows of external loads differ at one time, row 4 and the one before it; "
            "expected increasing time, found 0.2 s. Remove one of the rows.");
}

// A point that jumps while the force is small: the filtered load must carry the filtered moment,
// not the filtered force at the filtered point.
TEST(ExternalLoads, AreFilteredAsForceAndMoment) {
  const int rows = 200;
  RowMatrix values = constant_rows(rows);
  for (int i = 0; i < rows; ++i) {
    values(i, 1) = 700.0 * std::pow(std::sin(0.05 * i), 2);
    values(i, 3) = i % 63 < 31 ? 0.3 : -0.5;
  }
  TimeTableFile file = recording(values);
  file.table.time *= 0.1;  // 100 Hz
  const Posed posed(0.0, 0.0);
  const ExternalLoads raw(posed.model, setup_on("upper"), file);
  const ExternalLoads filtered(posed.model, setup_on("upper"), file, {.cutoff = 20.0});
  // `upper` has its origin at ground's: the spatial force is the load itself. The mean over whole
  // periods passes a low-pass.
  SimTK::SpatialVec raw_sum(SimTK::Vec3(0), SimTK::Vec3(0)), filtered_sum = raw_sum;
  double largest_change = 0.0;
  for (int i = 20; i < 146; ++i) {
    const SimTK::SpatialVec a = posed.force_on(raw, 0.01 * i, 1),
                            b = posed.force_on(filtered, 0.01 * i, 1);
    raw_sum += a;
    filtered_sum += b;
    largest_change = std::max(largest_change, (a - b)[0].norm());
  }
  EXPECT_GT(largest_change, 1.0);
  EXPECT_NEAR(filtered_sum[1][1] / raw_sum[1][1], 1.0, 1e-3);
  EXPECT_NEAR(filtered_sum[0][2] / raw_sum[0][2], 1.0, 1e-2);
  EXPECT_EQ(filtered.sample(0, 0.5).point, Eigen::Vector3d::Zero());
}

TEST(ExternalLoads, MustCoverTheMotion) {
  const ExternalLoads loads(two_link_model(), setup_on("lower"), recording(constant_rows(11)));
  loads.require_coverage(-0.04, 1.04);  // within half a step
  try {
    loads.require_coverage(0.0, 1.2);
    FAIL() << "no error";
  } catch (const InputError& error) {
    EXPECT_STREQ(
        error.what(),
        "grf.mot: the external loads do not cover the motion; expected 0 to 1.2 s, found 0 "
        "to 1 s. Choose a time range within the loads.");
  }
}

TEST(ExternalLoads, RejectWhatDoesNotFitTheModelOrTheData) {
  const TimeTableFile file = recording(constant_rows(10));
  EXPECT_EQ(error_of(setup_on("foot"), file),
            "loads.xml:7: <applied_to_body> of external force 'plate' names no body of model 'two "
            "links'; expected a body's name or ground, found foot. Correct the name.");
  ExternalLoadsSetup setup = setup_on("lower");
  setup.forces[0].force_expressed_in_body = "lab";
  EXPECT_EQ(error_of(setup, file).substr(0, 64),
            "loads.xml:7: <force_expressed_in_body> of external force 'plate'");
  setup = setup_on("lower");
  setup.forces[0].point_expressed_in_body = "lab";
  EXPECT_EQ(error_of(setup, file).substr(0, 64),
            "loads.xml:7: <point_expressed_in_body> of external force 'plate'");
  setup = setup_on("lower");
  setup.forces[0].torque_columns = {"tx", "ty", "tz"};
  EXPECT_EQ(error_of(setup, file),
            "loads.xml:7: grf.mot has no column 'tx', which external force 'plate' needs for its "
            "torque; found fx fy fz px py pz mx my mz. Correct the identifier or the labels.");
  setup.forces[0].torque_columns = {"mx", "my"};
  EXPECT_EQ(
      error_of(setup, file),
      "loads.xml:7: external force 'plate' has 2 columns for its torque; expected 3. Name the "
      "columns of x, y and z.");
  EXPECT_EQ(error_of(setup_on("lower"), recording(RowMatrix(0, 9))),
            "grf.mot: holds no rows of external loads. Record loads or leave the file out.");
  TimeTableFile missing = file;
  missing.table.values(4, 1) = kMissing;
  EXPECT_EQ(
      error_of(setup_on("lower"), missing),
      "grf.mot: column 'fy' of the external loads in row 5, at 0.4 s; expected a number, found "
      "nan. Fill the gap, or write zeros if nothing touched the plate.");
}

TEST(ExternalLoads, RejectFiltersThatCannotBe) {
  const TimeTableFile file = recording(constant_rows(10));
  EXPECT_EQ(error_of(setup_on("lower"), file, {.cutoff = 0.0}),
            "ExternalLoadsOptions::cutoff is 0 Hz; it must be positive, or negative for no filter");
  EXPECT_EQ(
      error_of(setup_on("lower"), file, {.cutoff = 6.0}),
      "grf.mot: the external loads cannot be filtered: the low-pass cutoff of 6 Hz is not below "
      "half the sampling rate of 10 Hz. Choose a cutoff below 5 Hz.");
  ExternalLoadsSetup setup = setup_on("lower");
  setup.forces[0].point_expressed_in_body = "lower";
  EXPECT_EQ(
      error_of(setup, file, {.cutoff = 3.0}),
      "loads.xml:7: external force 'plate' cannot be filtered: its force and its point are "
      "given in different bodies' frames. Filter the recording before, or give both in ground.");
}

}  // namespace
}  // namespace sinew
