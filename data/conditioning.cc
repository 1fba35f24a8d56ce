#include "data/conditioning.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "data/butterworth.h"
#include "data/natural_spline.h"
#include "data/numbers.h"

namespace sinew {
namespace {

// What the filter's reflected ends need to say anything.
constexpr Eigen::Index kShortest = 6;
// Times printed to milliseconds at 1000 Hz are exact, at 120 Hz off by 6 % of a step at most; two
// decimals at 120 Hz would be off by more than half.
constexpr double kStepTolerance = 0.1;

// Rows first … end − 1 in which none of the columns is NaN.
struct Stretch {
  Eigen::Index first = 0, end = 0;
  Eigen::Index size() const { return end - first; }
};

std::vector<Stretch> stretches(const RowMatrix& values, Eigen::Index column, Eigen::Index count) {
  std::vector<Stretch> found;
  bool inside = false;
  for (Eigen::Index row = 0; row < values.rows(); ++row) {
    const bool measured = !values.row(row).segment(column, count).hasNaN();
    if (measured && !inside) found.push_back({row, row});
    if (measured) found.back().end = row + 1;
    inside = measured;
  }
  return found;
}

void filter_stretch(RowMatrix& values, Eigen::Index column, Eigen::Index count,
                    const Stretch& stretch, double rate, double cutoff) {
  TimeTable table;
  table.time = Eigen::VectorXd::LinSpaced(stretch.size(), 0.0,
                                          static_cast<double>(stretch.size() - 1) / rate);
  table.values = values.block(stretch.first, column, stretch.size(), count);
  for (Eigen::Index i = 0; i < count; ++i) table.labels.push_back(std::to_string(i));
  const TimeTable padded = lowpass_with_padding(table, cutoff);
  values.block(stretch.first, column, stretch.size(), count) =
      padded.values.middleRows(stretch.size() / 2, stretch.size());
}

// Interpolates one stretch at those new times that lie in it. `slack`: what times may lie beyond
// its ends by rounding.
void sample_stretch(const Eigen::VectorXd& time, const RowMatrix& values, Eigen::Index column,
                    Eigen::Index count, const Stretch& stretch, const Eigen::VectorXd& new_time,
                    double slack, RowMatrix& out) {
  const Eigen::VectorXd x = time.segment(stretch.first, stretch.size());
  const Eigen::Index n = x.size();
  const double first = x[0] - slack, last = x[n - 1] + slack;
  const auto begin = std::lower_bound(new_time.begin(), new_time.end(), first) - new_time.begin();
  const int half_order = n >= 4 ? 2 : 1;
  Eigen::MatrixXd c;
  if (n >= 2) {
    c = natural_spline_coefficients(x, values.block(stretch.first, column, n, count), half_order);
  }
  Eigen::Index interval = 0;
  for (Eigen::Index row = begin; row < new_time.size() && new_time[row] <= last; ++row) {
    const double t = std::clamp(new_time[row], x[0], x[n - 1]);
    if (n == 1) {
      out.row(row).segment(column, count) = values.row(stretch.first).segment(column, count);
      continue;
    }
    while (interval < n - 2 && t >= x[interval + 1]) ++interval;
    const double dt = t - x[interval];
    Eigen::RowVectorXd y = Eigen::RowVectorXd::Zero(count);
    for (int k = 2 * half_order - 1; k >= 0; --k) y = y * dt + c.row(2 * half_order * interval + k);
    out.row(row).segment(column, count) = y;
  }
}

Eigen::VectorXd times_at(double first, double last, double rate) {
  if (!(rate > 0.0) || !std::isfinite(rate)) {
    throw std::invalid_argument(
        fmt::format("the rate to resample at is {} Hz; it must be above 0", rate));
  }
  // The last sample may pass the end by a rounding error, not by more.
  const auto count = static_cast<Eigen::Index>(std::floor((last - first) * rate + 1e-6)) + 1;
  Eigen::VectorXd time(count);
  for (Eigen::Index i = 0; i < count; ++i) time[i] = first + static_cast<double>(i) / rate;
  return time;
}

}  // namespace

MarkerTrajectories slice(const MarkerTrajectories& markers, int first, int end) {
  MarkerTrajectories part = markers;
  part.time = markers.time.segment(first, end - first);
  part.p_WM = markers.p_WM.middleRows(first, end - first);
  part.frame_numbers.assign(markers.frame_numbers.begin() + first,
                            markers.frame_numbers.begin() + end);
  return part;
}

TimeTable slice(const TimeTable& table, int first, int end) {
  TimeTable part = table;
  part.time = table.time.segment(first, end - first);
  part.values = table.values.middleRows(first, end - first);
  return part;
}

int lowpass(MarkerTrajectories& markers, double cutoff) {
  third_order_butterworth(markers.rate, cutoff);  // throws for every recording alike
  Eigen::Index untouched = 0;
  for (int marker = 0; marker < markers.marker_count(); ++marker) {
    for (const Stretch& stretch : stretches(markers.p_WM, 3 * marker, 3)) {
      if (stretch.size() < kShortest) {
        untouched += stretch.size();
      } else {
        filter_stretch(markers.p_WM, 3 * marker, 3, stretch, markers.rate, cutoff);
      }
    }
  }
  return static_cast<int>(untouched);
}

double uniform_rate(const TimeTable& table) {
  const Eigen::Index rows = table.time.size();
  if (rows < 2) throw std::invalid_argument("a table of fewer than 2 rows has no rate");
  const double step = (table.time[rows - 1] - table.time[0]) / static_cast<double>(rows - 1);
  for (Eigen::Index i = 1; i < rows; ++i) {
    const double found = table.time[i] - table.time[i - 1];
    if (std::abs(found - step) <= kStepTolerance * step) continue;
    throw std::invalid_argument(
        fmt::format("the time steps are not equal: {:.6g} s at {:.6g} s, {:.6g} s in the mean. "
                    "Resample first.",
                    found, table.time[i], step));
  }
  return 1.0 / step;
}

void lowpass(TimeTable& table, double cutoff) {
  const double rate = uniform_rate(table);
  third_order_butterworth(rate, cutoff);
  if (table.values.hasNaN()) {
    for (Eigen::Index c = 0; c < table.values.cols(); ++c) {
      if (!table.values.col(c).hasNaN()) continue;
      throw std::invalid_argument(
          fmt::format("column '{}' has missing values; filtering needs every one. Fill or drop it.",
                      table.labels[static_cast<std::size_t>(c)]));
    }
  }
  if (table.time.size() < kShortest) {
    throw std::invalid_argument(
        fmt::format("a table of {} rows is too short to be filtered; {} "
                    "are needed",
                    table.time.size(), kShortest));
  }
  filter_stretch(table.values, 0, table.values.cols(), {0, table.time.size()}, rate, cutoff);
}

RowMatrix values_at(const Eigen::VectorXd& time, const RowMatrix& values,
                    const Eigen::VectorXd& new_time, int columns_that_belong_together) {
  RowMatrix out = RowMatrix::Constant(new_time.size(), values.cols(), kNaN);
  if (time.size() == 0) return out;
  const double step = time.size() > 1
                          ? (time[time.size() - 1] - time[0]) / static_cast<double>(time.size() - 1)
                          : 0.0;
  for (Eigen::Index c = 0; c < values.cols(); c += columns_that_belong_together) {
    for (const Stretch& stretch : stretches(values, c, columns_that_belong_together)) {
      sample_stretch(time, values, c, columns_that_belong_together, stretch, new_time, 1e-6 * step,
                     out);
    }
  }
  return out;
}

MarkerTrajectories resample(const MarkerTrajectories& markers, double rate) {
  MarkerTrajectories result;
  result.names = markers.names;
  result.rate = rate;
  const Eigen::Index frames = markers.time.size();
  result.time = times_at(markers.time[0], markers.time[frames - 1], rate);
  result.p_WM = values_at(markers.time, markers.p_WM, result.time, 3);
  for (int i = 1; i <= result.frame_count(); ++i) result.frame_numbers.push_back(i);
  return result;
}

TimeTable resample(const TimeTable& table, double rate) {
  TimeTable result = table;
  const Eigen::Index rows = table.time.size();
  result.time = times_at(table.time[0], table.time[rows - 1], rate);
  result.values = values_at(table.time, table.values, result.time);
  return result;
}

}  // namespace sinew
