#include "data/butterworth.h"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <string>

namespace sinew {
namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;

TimeTable table_of(const Eigen::VectorXd& time, const Eigen::MatrixXd& values) {
  TimeTable table;
  for (Eigen::Index j = 0; j < values.cols(); ++j) table.labels.push_back("c" + std::to_string(j));
  table.time = time;
  table.values = values;
  return table;
}

template <typename Function>
std::string error_of(Function function) {
  try {
    function();
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "no error";
}

// H(z) of the difference equation on the unit circle.
double gain(const ButterworthCoefficients& c, double frequency, double rate) {
  const std::complex<double> z = std::polar(1.0, -kTurn * frequency / rate);
  std::complex<double> above = 0.0, below = 0.0;
  for (int k = 3; k >= 0; --k) {
    above = above * z + c.feedforward[k];
    below = below * z + c.feedback[k];
  }
  return std::abs(above / below);
}

TEST(Butterworth, HasTheClosedFormGain) {
  for (const double rate : {50.0, 100.0, 1000.0}) {
    for (const double cutoff : {3.0, 6.0, 20.0}) {
      const auto c = third_order_butterworth(rate, cutoff);
      const double warped_cutoff = std::tan(0.5 * kTurn * cutoff / rate);
      // Near frequency 0 the feedback's terms cancel to the size of w³.
      const double rounding =
          16.0 * std::numeric_limits<double>::epsilon() * (1.0 + std::pow(warped_cutoff, -3));
      for (double f = 0.0; f < 0.49 * rate; f += 0.37) {
        const double ratio = std::tan(0.5 * kTurn * f / rate) / warped_cutoff;
        EXPECT_NEAR(gain(c, f, rate), 1.0 / std::sqrt(1.0 + std::pow(ratio, 6)), rounding) << f;
      }
      EXPECT_NEAR(gain(c, cutoff, rate), std::sqrt(0.5), rounding);
    }
  }
}

// scipy 1.17.1: signal.butter(3, 6/(100/2)).
TEST(Butterworth, AgreesWithScipy) {
  const auto c = third_order_butterworth(100.0, 6.0);
  const Eigen::Vector4d b{0.004750523610980862, 0.014251570832942585, 0.014251570832942585,
                          0.004750523610980862};
  const Eigen::Vector4d a{1.0, -2.250085081726394, 1.756401381785953, -0.46831211117171223};
  EXPECT_LT((c.feedforward - b).cwiseAbs().maxCoeff(), 1e-14);
  EXPECT_LT((c.feedback - a).cwiseAbs().maxCoeff(), 1e-13);
}

TEST(Butterworth, KeepsConstantsAndLines) {
  const Eigen::VectorXd time = Eigen::VectorXd::LinSpaced(201, 0.0, 2.0);
  Eigen::MatrixXd values(201, 2);
  values.col(0).setConstant(4.5);
  values.col(1) = 3.0 * time.array() - 1.0;
  const TimeTable filtered = lowpass_with_padding(table_of(time, values), 6.0);
  // A line lags behind by a constant, which the way back takes away, except near the padding's
  // ends.
  for (Eigen::Index i = 0; i < filtered.time.size(); ++i) {
    if (filtered.time[i] < 0.0 || filtered.time[i] > 2.0) continue;
    EXPECT_NEAR(filtered.values(i, 0), 4.5, 1e-12);
    EXPECT_NEAR(filtered.values(i, 1), 3.0 * filtered.time[i] - 1.0, 7e-9);
  }
}

// Two passes scale a sine by the square of one pass's gain and do not shift it.
TEST(Butterworth, ScalesASineBySquaredGainWithoutDelay) {
  const double rate = 100.0, cutoff = 6.0;
  const Eigen::VectorXd time = Eigen::VectorXd::LinSpaced(1001, 0.0, 10.0);
  for (const double f : {0.5, 3.0, 6.0, 12.0}) {
    const Eigen::VectorXd wave = (kTurn * f * time.array()).sin();
    const TimeTable filtered = lowpass_with_padding(table_of(time, wave), cutoff);
    const double expected = std::pow(gain(third_order_butterworth(rate, cutoff), f, rate), 2);
    ASSERT_EQ(filtered.time.size(), 2001);
    for (Eigen::Index i = 800; i < 1200; ++i) {  // seconds 3 to 7, past every transient
      EXPECT_NEAR(filtered.values(i, 0), expected * std::sin(kTurn * f * filtered.time[i]), 1e-9)
          << f << " Hz at " << filtered.time[i];
    }
  }
}

TEST(Butterworth, StartsEachPassWithThreeUnfilteredSamples) {
  const auto c = third_order_butterworth(100.0, 6.0);
  Eigen::MatrixXd x = Eigen::VectorXd::Unit(8, 0);
  filter_forward_and_backward(c, x);
  // By hand: forward, x_0 reaches y_3 through feedforward[3] and feedback[3], later ones through
  // the recursion; backward, the last three of those stay as they are.
  Eigen::VectorXd y = Eigen::VectorXd::Unit(8, 0);
  y[3] = c.feedforward[3] - c.feedback[3];
  for (int n = 4; n < 8; ++n) {
    y[n] = -c.feedback[1] * y[n - 1] - c.feedback[2] * y[n - 2] - c.feedback[3] * y[n - 3];
  }
  for (int n = 5; n < 8; ++n) EXPECT_DOUBLE_EQ(x(n, 0), y[n]);
  const double backward = c.feedforward[0] * y[4] + c.feedforward[1] * y[5] +
                          c.feedforward[2] * y[6] + c.feedforward[3] * y[7] - c.feedback[1] * y[5] -
                          c.feedback[2] * y[6] - c.feedback[3] * y[7];
  EXPECT_NEAR(x(4, 0), backward, 1e-15);
}

TEST(PadByReflection, ReflectsThroughTheEndPoints) {
  const TimeTable padded = pad_by_reflection(
      table_of(Eigen::VectorXd{{1.0, 2.0, 4.0, 5.0}}, Eigen::VectorXd{{10.0, 11.0, 15.0, 14.0}}),
      2);
  EXPECT_EQ(padded.time, (Eigen::VectorXd{{-2.0, 0.0, 1.0, 2.0, 4.0, 5.0, 6.0, 8.0}}));
  EXPECT_EQ(padded.values.col(0),
            (Eigen::VectorXd{{5.0, 9.0, 10.0, 11.0, 15.0, 14.0, 13.0, 17.0}}));
  EXPECT_EQ(error_of([&] { pad_by_reflection(padded, 8); }),
            "cannot reflect 8 rows of a table of 8");
}

TEST(ResampleUniformly, LeavesUniformTablesAlone) {
  const Eigen::VectorXd time = Eigen::VectorXd::LinSpaced(101, 0.0, 1.0);
  const TimeTable table = table_of(time, time.array().sin().matrix());
  const TimeTable same = resample_uniformly(table);
  EXPECT_EQ(same.time, table.time);
  EXPECT_EQ(same.values, table.values);
}

TEST(ResampleUniformly, TakesTheSmallestStep) {
  Eigen::VectorXd time(120);
  for (int i = 0; i < 120; ++i) time[i] = 0.01 * i + (i % 3 == 1 ? 0.002 : 0.0);
  const auto wave = [](double t) { return std::sin(kTurn * t); };
  const TimeTable uniform = resample_uniformly(table_of(time, time.unaryExpr(wave)));
  EXPECT_NEAR(uniform.time[1] - uniform.time[0], 0.008, 1e-12);
  EXPECT_EQ(uniform.time.size(), 149);  // 1.19 s / 8 ms, rounded down, and the first
  for (Eigen::Index i = 0; i < uniform.time.size(); ++i) {
    EXPECT_NEAR(uniform.time[i], 0.008 * static_cast<double>(i), 1e-12);
    EXPECT_NEAR(uniform.values(i, 0), wave(uniform.time[i]), 1e-4) << uniform.time[i];
  }
}

// Steps of 1 µs in a record of 10 s would make ten million rows.
TEST(ResampleUniformly, KeepsToAHundredThousandRows) {
  Eigen::VectorXd time = Eigen::VectorXd::LinSpaced(1001, 0.0, 10.0);
  time[500] = time[499] + 1e-6;
  const TimeTable uniform = resample_uniformly(table_of(time, time));
  EXPECT_EQ(uniform.time.size(), 100001);
}

TEST(LowpassWithPadding, RejectsWhatItCannotFilter) {
  const Eigen::VectorXd time = Eigen::VectorXd::LinSpaced(101, 0.0, 1.0);
  const TimeTable table = table_of(time, Eigen::VectorXd::Ones(101));
  EXPECT_EQ(error_of([&] { lowpass_with_padding(table, 50.0); }),
            "the low-pass cutoff of 50 Hz is not below half the sampling rate of 100 Hz. Choose a "
            "cutoff below 50 Hz.");
  EXPECT_EQ(error_of([&] { lowpass_with_padding(table, -6.0); }),
            "the low-pass cutoff must be positive, is -6 Hz. Leave it out for no filter.");
  EXPECT_EQ(error_of([&] { lowpass_with_padding(table, std::nan("")); }),
            "the low-pass cutoff must be positive, is nan Hz. Leave it out for no filter.");
  TimeTable missing = table;
  missing.values(7, 0) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(error_of([&] { lowpass_with_padding(missing, 6.0); }),
            "column 'c0' is nan in row 8 at 0.07 s; filtering needs every value. Fill the gap or "
            "drop the column.");
  TimeTable repeated = table;
  repeated.time[3] = repeated.time[2];
  EXPECT_EQ(
      error_of([&] { lowpass_with_padding(repeated, 6.0); }),
      "time must increase to be filtered; row 4 at 0.02 s follows 0.02 s. Remove the repeated "
      "row.");
  const TimeTable short_table = table_of(time.head(3), Eigen::VectorXd::Ones(3));
  EXPECT_EQ(
      error_of([&] { lowpass_with_padding(short_table, 6.0); }),
      "a third-order filter needs at least 4 frames, there are 3. Choose a negative cutoff for no "
      "filter.");
}

}  // namespace
}  // namespace sinew
