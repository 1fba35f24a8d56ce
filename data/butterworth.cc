#include "data/butterworth.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "data/coordinate_spline.h"

namespace sinew {
namespace {

// A 9-digit time column of a minute is uniform to 1e-10 of a step of 10 ms; 8 decimals, as OpenSim
// prints them, are not, and OpenSim resamples those.
constexpr double kUniformSteps = 1e-9;
// OpenSim's Storage::MAX_RESAMPLE_SIZE.
constexpr int kMaxResampledRows = 100000;
constexpr int kPasses = 3;  // rows that a third-order filter takes as its start

[[noreturn]] void fail(const std::string& text) { throw std::invalid_argument(text); }

void check_time_and_values(const TimeTable& table) {
  for (Eigen::Index i = 0; i < table.time.size(); ++i) {
    if (!std::isfinite(table.time[i])) fail(fmt::format("time of row {} is not finite", i + 1));
    if (i > 0 && !(table.time[i] > table.time[i - 1])) {
      fail(
          fmt::format("time must increase to be filtered; row {} at {} s follows {} s. Remove "
                      "the repeated row.",
                      i + 1, table.time[i], table.time[i - 1]));
    }
    for (Eigen::Index j = 0; j < table.values.cols(); ++j) {
      if (!std::isfinite(table.values(i, j))) {
        fail(fmt::format(
            "column '{}' is {} in row {} at {} s; filtering needs every value. Fill "
            "the gap or drop the column.",
            table.labels[static_cast<std::size_t>(j)], table.values(i, j), i + 1, table.time[i]));
      }
    }
  }
}

double smallest_step(const Eigen::VectorXd& time) {
  double step = std::numeric_limits<double>::infinity();
  for (Eigen::Index i = 1; i < time.size(); ++i) step = std::min(step, time[i] - time[i - 1]);
  return step;
}

double mean_step(const Eigen::VectorXd& time) {
  return (time[time.size() - 1] - time[0]) / static_cast<double>(time.size() - 1);
}

void reverse_rows(Eigen::Ref<Eigen::VectorXd> x) { std::reverse(x.begin(), x.end()); }

// One pass in place; `history` keeps the unfiltered samples that are still needed.
void filter_once(const ButterworthCoefficients& c, Eigen::Ref<Eigen::VectorXd> x) {
  Eigen::Vector3d history = x.head<kPasses>().reverse();  // x_{n−1}, x_{n−2}, x_{n−3}
  for (Eigen::Index n = kPasses; n < x.size(); ++n) {
    const double input = x[n];
    x[n] = c.feedforward[0] * input;
    for (int k = 1; k <= kPasses; ++k) {
      x[n] += c.feedforward[k] * history[k - 1] - c.feedback[k] * x[n - k];
    }
    history = {input, history[0], history[1]};
  }
}

}  // namespace

ButterworthCoefficients third_order_butterworth(double rate, double cutoff) {
  if (!(cutoff > 0.0) || !std::isfinite(cutoff)) {
    fail(fmt::format("the low-pass cutoff must be positive, is {} Hz. Leave it out for no filter.",
                     cutoff));
  }
  if (!(cutoff < 0.5 * rate)) {
    fail(
        fmt::format("the low-pass cutoff of {:.6g} Hz is not below half the sampling rate of "
                    "{:.6g} Hz. Choose a cutoff below {:.6g} Hz.",
                    cutoff, rate, 0.5 * rate));
  }
  // s → (1/w) (1 − z⁻¹)/(1 + z⁻¹), both factors multiplied by their w and (1 + z⁻¹).
  const double w = std::tan(std::numbers::pi * cutoff / rate);
  const double p0 = w + 1.0, p1 = w - 1.0;
  const double q0 = w * w + w + 1.0, q1 = 2.0 * (w * w - 1.0), q2 = w * w - w + 1.0;
  const double scale = 1.0 / (p0 * q0);
  ButterworthCoefficients c;
  c.feedforward = Eigen::Vector4d(1.0, 3.0, 3.0, 1.0) * (w * w * w * scale);
  c.feedback = Eigen::Vector4d(p0 * q0, p0 * q1 + p1 * q0, p0 * q2 + p1 * q1, p1 * q2) * scale;
  return c;
}

void filter_forward_and_backward(const ButterworthCoefficients& filter,
                                 Eigen::Ref<Eigen::MatrixXd> columns) {
  if (columns.rows() < kPasses + 1) {
    fail(fmt::format("a third-order filter needs at least {} frames, there are {}", kPasses + 1,
                     columns.rows()));
  }
  for (Eigen::Index j = 0; j < columns.cols(); ++j) {
    for (int pass = 0; pass < 2; ++pass) {
      filter_once(filter, columns.col(j));
      reverse_rows(columns.col(j));
    }
  }
}

TimeTable pad_by_reflection(const TimeTable& table, int count) {
  const auto rows = static_cast<int>(table.time.size());
  if (count < 0 || count >= rows) {
    fail(fmt::format("cannot reflect {} rows of a table of {}", count, rows));
  }
  TimeTable padded = table;
  padded.time.resize(rows + 2 * count);
  padded.values.resize(rows + 2 * count, table.values.cols());
  padded.time.segment(count, rows) = table.time;
  padded.values.middleRows(count, rows) = table.values;
  for (int i = 1; i <= count; ++i) {
    const int before = count - i, after = count + rows - 1 + i, last = rows - 1;
    padded.time[before] = 2.0 * table.time[0] - table.time[i];
    padded.time[after] = 2.0 * table.time[last] - table.time[last - i];
    padded.values.row(before) = 2.0 * table.values.row(0) - table.values.row(i);
    padded.values.row(after) = 2.0 * table.values.row(last) - table.values.row(last - i);
  }
  return padded;
}

TimeTable resample_uniformly(const TimeTable& table) {
  check_time_and_values(table);
  const CoordinateSpline spline(table.time, table.values);
  double step = smallest_step(table.time);
  if (mean_step(table.time) - step <= kUniformSteps * step) return table;
  const double duration = spline.last_time() - spline.first_time();
  step = std::max(step, duration / kMaxResampledRows);
  // The last sample may pass the end by a rounding error, not by more.
  const auto rows = static_cast<Eigen::Index>(std::floor(duration / step * (1.0 + 1e-12))) + 1;
  TimeTable result = table;
  result.time.resize(rows);
  result.values.resize(rows, table.values.cols());
  for (Eigen::Index i = 0; i < rows; ++i) {
    result.time[i] = spline.first_time() + static_cast<double>(i) * step;
    spline.evaluate(std::min(result.time[i], spline.last_time()),
                    {result.values.row(i).data(), static_cast<std::size_t>(result.values.cols())},
                    {}, {});
  }
  return result;
}

TimeTable lowpass_with_padding(const TimeTable& table, double cutoff) {
  const auto rows = static_cast<int>(table.time.size());
  if (rows < kPasses + 1) {
    fail(
        fmt::format("a third-order filter needs at least {} frames, there are {}. Choose "
                    "a negative cutoff for no filter.",
                    kPasses + 1, rows));
  }
  check_time_and_values(table);
  TimeTable result = resample_uniformly(pad_by_reflection(table, rows / 2));
  const double step = result.time[1] - result.time[0];
  Eigen::MatrixXd columns = result.values;
  filter_forward_and_backward(third_order_butterworth(1.0 / step, cutoff), columns);
  result.values = columns;
  return result;
}

}  // namespace sinew
