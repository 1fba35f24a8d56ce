#include "dynamics/coordinate_table.h"

#include <gtest/gtest.h>

#include <limits>
#include <numbers>
#include <string>

#include "tests/dynamics/two_link_model.h"

namespace sinew {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

TimeTableFile motion(std::vector<std::string> labels, const RowMatrix& values,
                     std::optional<bool> in_degrees = {}) {
  TimeTableFile file;
  file.path = "walk.mot";
  file.table.labels = std::move(labels);
  file.table.time = Eigen::VectorXd::LinSpaced(values.rows(), 0.0, 0.1 * (values.rows() - 1.0));
  file.table.values = values;
  file.table.in_degrees = in_degrees;
  return file;
}

const RowMatrix kTwoRows{{0.1, 0.2}, {0.3, 0.4}};

std::string error_of(const TimeTableFile& file) {
  try {
    coordinate_table(two_link_model(), file);
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

TEST(CoordinateTable, OrdersColumnsAsTheModel) {
  const CoordinateTable table = coordinate_table(
      two_link_model(), motion({"elbow_angle", "shoulder_angle"}, kTwoRows, false));
  EXPECT_EQ(table.path, "walk.mot");
  EXPECT_EQ(table.q, (RowMatrix{{0.2, 0.1}, {0.4, 0.3}}));
  EXPECT_EQ(table.measured, (std::vector<bool>{true, true}));
  EXPECT_TRUE(table.warnings.empty());
}

TEST(CoordinateTable, ConvertsDegreesOfRotationalCoordinatesOnly) {
  MusculoskeletalModel model = two_link_model();
  model.coordinates[1].motion = Coordinate::Motion::kTranslational;
  const CoordinateTable table =
      coordinate_table(model, motion({"shoulder_angle", "elbow_angle"}, kTwoRows, true));
  EXPECT_DOUBLE_EQ(table.q(1, 0), 0.3 * kDegree);
  EXPECT_DOUBLE_EQ(table.q(1, 1), 0.4);
}

TEST(CoordinateTable, TakesOpenSim4Paths) {
  RowMatrix values(1, 4);
  values << 0.1, 7.0, 0.2, 8.0;
  const CoordinateTable table = coordinate_table(
      two_link_model(),
      motion({"/jointset/shoulder/shoulder_angle/value", "/jointset/shoulder/shoulder_angle/speed",
              "elbow/elbow_angle/value", "/forceset/biceps/activation"},
             values, false));
  EXPECT_EQ(table.q, (RowMatrix{{0.1, 0.2}}));
  ASSERT_EQ(table.warnings.size(), 1u);
  EXPECT_EQ(to_string(table.warnings[0]),
            "walk.mot: ignored 2 states that are no coordinate values");
}

TEST(CoordinateTable, KeepsMissingCoordinatesAtTheirDefaults) {
  const CoordinateTable table =
      coordinate_table(two_link_model(), motion({"shoulder_angle", "nose"}, kTwoRows, false));
  EXPECT_EQ(table.q, (RowMatrix{{0.1, 0.25}, {0.3, 0.25}}));
  EXPECT_EQ(table.measured, (std::vector<bool>{true, false}));
  ASSERT_EQ(table.warnings.size(), 2u);
  EXPECT_EQ(table.warnings[0].text, "ignored columns that are no coordinates: nose");
  EXPECT_EQ(table.warnings[1].text,
            "has no coordinate 'elbow_angle'; it stays at its default value 0.25");
}

struct Units {
  Eigen::RowVector2d values;
  bool degrees;
  const char* why;
};

TEST(CoordinateTable, DecidesUnitsByTheValuesWhereTheHeaderIsSilent) {
  const Units cases[] = {
      {{5.0, 40.0}, true, "an angle beyond 2 pi"},
      {{0.5, 2.6}, false, "within ranges"},
      {{-3.0, -5.0}, true, "standing still: both leave their ranges if they were radians"},
      {{3.1, 0.3}, false, "one column beyond its range, as a heading may be"},
  };
  for (const Units& c : cases) {
    const CoordinateTable table =
        coordinate_table(two_link_model(), motion({"shoulder_angle", "elbow_angle"}, c.values));
    EXPECT_DOUBLE_EQ(table.q(0, 0), c.values[0] * (c.degrees ? kDegree : 1.0)) << c.why;
    ASSERT_EQ(table.warnings.size(), 1u);
    const std::string expected = std::string("the header has no inDegrees; angles are taken as ") +
                                 (c.degrees ? "degrees" : "radians");
    EXPECT_EQ(table.warnings[0].text.substr(0, expected.size()), expected) << c.why;
  }
}

// A coordinate that a coupler sets to half of the shoulder's angle and that only drives functions.
TEST(CoordinateTable, TakesCoupledCoordinatesInTheUnitThatTheirCouplerSays) {
  MusculoskeletalModel model = two_link_model();
  const int shoulder = model.find_coordinate("shoulder_angle");
  const int elbow = model.find_coordinate("elbow_angle");
  model.coordinates[static_cast<std::size_t>(elbow)].motion = Coordinate::Motion::kCoupled;
  model.couplers.push_back({"half", elbow, shoulder, {LinearFunction{0.5, 0.0}}, {}});
  const RowMatrix before_4{{20.0, 10.0}, {60.0, 30.0}};
  RowMatrix since_4 = before_4;
  since_4.col(1) *= kDegree;
  for (const RowMatrix& values : {before_4, since_4}) {
    const CoordinateTable table =
        coordinate_table(model, motion({"shoulder_angle", "elbow_angle"}, values, true));
    EXPECT_NEAR(table.q(1, elbow), 30.0 * kDegree, 1e-15);
    ASSERT_EQ(table.warnings.size(), values == before_4 ? 1u : 0u);
  }
  model.couplers.clear();
  EXPECT_EQ(coordinate_table(model, motion({"shoulder_angle", "elbow_angle"}, before_4, true))
                .q(1, elbow),
            30.0);
}

TEST(CoordinateTable, DropsRepeatedRows) {
  TimeTableFile file = motion({"shoulder_angle", "elbow_angle"},
                              RowMatrix{{0.1, 0.2}, {0.3, 0.4}, {0.3, 0.4}}, false);
  file.table.time[2] = file.table.time[1];
  const CoordinateTable table = coordinate_table(two_link_model(), file);
  EXPECT_EQ(table.q, kTwoRows);
  EXPECT_EQ(table.time.size(), 2);
  ASSERT_EQ(table.warnings.size(), 1u);
  EXPECT_EQ(table.warnings[0].text, "dropped 1 repeated rows");
  file.table.values(2, 0) = 0.5;
  EXPECT_EQ(error_of(file),
            "walk.mot: two rows of coordinates differ at one time, row 3 and the one before it; "
            "expected increasing time, found 0.1 s. Remove one of the rows.");
}

TEST(CoordinateTable, RejectsWhatIsNoMotionOfTheModel) {
  EXPECT_EQ(error_of(motion({"shoulder_angle"}, RowMatrix(0, 1), false)),
            "walk.mot: holds no rows of coordinates. Choose the file that holds the motion.");
  EXPECT_EQ(error_of(motion({"left", "right"}, kTwoRows, false)),
            "walk.mot: no column is a coordinate of model 'two links'; expected labels such as "
            "shoulder_angle, found left, right. Choose the model that the motion was made with.");
  EXPECT_EQ(error_of(motion({"elbow_angle", "elbow/elbow_angle/value"}, kTwoRows, false)),
            "walk.mot: two columns for coordinate 'elbow_angle'; found elbow_angle and "
            "elbow/elbow_angle/value. Remove one of them.");
  RowMatrix missing = kTwoRows;
  missing(1, 1) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(error_of(motion({"shoulder_angle", "elbow_angle"}, missing, false)),
            "walk.mot: coordinate 'elbow_angle' in row 2, at 0.1 s; expected a number, found nan. "
            "Fill the gap or leave the column out.");
}

}  // namespace
}  // namespace sinew
