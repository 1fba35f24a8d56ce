#include "data/table_comparison.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace sinew {
namespace {

constexpr double kOmega = 2.0 * std::numbers::pi;

// a sin(ωt) + offset and a ramp, from 0 s to 1 s.
TimeTableFile wave(const std::string& path, int steps, double a, double offset) {
  TimeTableFile file{path, {}, {}};
  file.table.labels = {"wave", "ramp"};
  file.table.time = Eigen::VectorXd::LinSpaced(steps + 1, 0.0, 1.0);
  file.table.values.resize(steps + 1, 2);
  file.table.values.col(0) = a * (kOmega * file.table.time.array()).sin() + offset;
  file.table.values.col(1) = 3.0 * file.table.time;
  return file;
}

TEST(TableComparison, FindsErrorsOfClosedForm) {
  const TableComparison c = compare_tables(wave("a", 1000, 2.2, 0.5), wave("b", 1000, 2.0, 0.0));
  EXPECT_EQ(c.rows, 1001);
  EXPECT_EQ(c.from, 0.0);
  EXPECT_EQ(c.to, 1.0);
  EXPECT_FALSE(c.interpolated);
  ASSERT_EQ(c.columns.size(), 2u);
  const ColumnComparison& w = c.columns[0];
  EXPECT_EQ(w.label, "wave");
  EXPECT_EQ(w.rows, 1001);
  EXPECT_NEAR(w.mean, 0.5, 1e-12);
  // 0.2² / 2 + 0.5², of which the endpoint repeats a zero.
  EXPECT_NEAR(w.rms, std::sqrt(0.02 + 0.25), 2e-4);
  EXPECT_NEAR(w.max, 0.7, 1e-9);
  EXPECT_NEAR(w.time_of_max, 0.25, 1e-12);
  EXPECT_NEAR(w.peak, 2.0, 1e-9);
  EXPECT_NEAR(w.max_percent(), 35.0, 1e-6);
  // RMS of a ω² sin: the difference quotient is off by (ω dt)² / 12.
  EXPECT_NEAR(w.true_roughness, std::sqrt(2.0) * kOmega * kOmega, 0.05);
  EXPECT_NEAR(w.roughness_ratio(), 1.1, 1e-6);
  const ColumnComparison& ramp = c.columns[1];
  EXPECT_EQ(ramp.max, 0.0);
  EXPECT_LT(ramp.roughness, 1e-8);
}

TEST(TableComparison, InterpolatesTheTruthAtOtherTimes) {
  const TableComparison c = compare_tables(wave("a", 333, 2.0, 0.0), wave("b", 100, 2.0, 0.0));
  EXPECT_TRUE(c.interpolated);
  EXPECT_EQ(c.rows, 334);
  // A natural cubic spline's error of the fourth order, and none of the second at ends where the
  // curve does not bend.
  EXPECT_LT(c.columns[0].max, 1e-6);
  EXPECT_GT(c.columns[0].max, 0.0);
}

TEST(TableComparison, ComparesWhatBothHaveInTheTimeAskedFor) {
  TimeTableFile a = wave("a", 100, 1.0, 0.0), b = wave("b", 100, 1.0, 0.0);
  a.table.labels[1] = "own";
  b.table.time.array() += 0.25;
  b.table.values.col(0) = (kOmega * b.table.time.array()).sin();
  ComparisonOptions options;
  options.to = 0.9;
  const TableComparison c = compare_tables(a, b, options);
  EXPECT_EQ(c.from, 0.25);
  EXPECT_EQ(c.to, 0.9);
  EXPECT_EQ(c.rows, 66);
  ASSERT_EQ(c.columns.size(), 1u);
  EXPECT_LT(c.columns[0].max, 1e-14);
  EXPECT_EQ(c.only_in_result, std::vector<std::string>{"own"});
  EXPECT_EQ(c.only_in_truth, std::vector<std::string>{"ramp"});
}

TEST(TableComparison, SkipsWhatWasNotMeasuredAndRepeatedTimes) {
  TimeTableFile a = wave("a", 100, 1.0, 0.0), b = wave("b", 100, 1.0, 0.0);
  a.table.values(10, 0) = std::nan("");
  b.table.values(20, 0) = std::nan("");
  a.table.time[31] = a.table.time[30];  // the first of the two counts
  a.table.values(31, 0) = 99.0;
  const TableComparison c = compare_tables(a, b);
  EXPECT_EQ(c.columns[0].rows, 98);
  EXPECT_EQ(c.columns[0].max, 0.0);
}

TEST(TableComparison, SaysWhyItCannot) {
  const auto error_of = [](const TimeTableFile& a, const TimeTableFile& b) -> std::string {
    try {
      compare_tables(a, b);
      return "none";
    } catch (const InputError& e) {
      return e.what();
    }
  };
  const TimeTableFile a = wave("a.mot", 10, 1.0, 0.0);
  TimeTableFile later = wave("b.mot", 10, 1.0, 0.0);
  later.table.time.array() += 5.0;
  EXPECT_EQ(error_of(a, later),
            "a.mot: cannot be compared with b.mot: no row lies in the time asked for; expected 5 s "
            "to 6 s, found 0 s to 1 s. Choose other times or files.");
  TimeTableFile other = wave("b.mot", 10, 1.0, 0.0);
  other.table.labels = {"x", "y"};
  EXPECT_EQ(error_of(a, other),
            "a.mot: cannot be compared with b.mot: they have no column in common; expected x, ..., "
            "found wave, .... For coordinates whose labels differ, give the model; else rename "
            "columns.");
  TimeTableFile degrees = a, radians = wave("b.mot", 10, 1.0, 0.0);
  degrees.table.in_degrees = true;
  radians.table.in_degrees = false;
  EXPECT_EQ(error_of(degrees, radians),
            "a.mot: cannot be compared with b.mot: their angles have different units; expected "
            "radians, found degrees. Give the model, which says what an angle is.");
}

}  // namespace
}  // namespace sinew
