#include "data/table_comparison.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "data/conditioning.h"

namespace sinew {
namespace {

// Of a step; times are printed with so many digits that rounding is far less.
constexpr double kSameTime = 1e-3;

TimeTable with_increasing_times(const TimeTable& table) {
  std::vector<Eigen::Index> rows;
  for (Eigen::Index i = 0; i < table.time.size(); ++i) {
    if (i == 0 || table.time[i] > table.time[rows.back()]) rows.push_back(i);
  }
  if (static_cast<Eigen::Index>(rows.size()) == table.time.size()) return table;
  TimeTable result = table;
  result.time = table.time(rows).eval();
  result.values = table.values(rows, Eigen::all).eval();
  return result;
}

double step_of(const Eigen::VectorXd& time) {
  const Eigen::Index n = time.size();
  return n > 1 ? (time[n - 1] - time[0]) / static_cast<double>(n - 1) : 1.0;
}

std::string range_text(const Eigen::VectorXd& time) {
  if (time.size() == 0) return "no rows";
  return fmt::format("{:.6g} s to {:.6g} s", time[0], time[time.size() - 1]);
}

// Rows of the result to compare: first and one past the last.
std::pair<Eigen::Index, Eigen::Index> rows_to_compare(const TimeTable& result,
                                                      const TimeTable& truth,
                                                      const ComparisonOptions& options) {
  const double slack = kSameTime * std::min(step_of(result.time), step_of(truth.time));
  Eigen::Index first = result.time.size(), end = 0;
  if (truth.time.size() == 0) return {0, 0};
  const double from = std::max(truth.time[0], options.from.value_or(truth.time[0])) - slack;
  const double last = truth.time[truth.time.size() - 1];
  const double to = std::min(last, options.to.value_or(last)) + slack;
  for (Eigen::Index i = 0; i < result.time.size(); ++i) {
    if (result.time[i] < from || result.time[i] > to) continue;
    first = std::min(first, i);
    end = i + 1;
  }
  return {std::min(first, end), end};
}

// The truth at these times, and whether it had to be interpolated.
std::pair<RowMatrix, bool> truth_at(const TimeTable& truth, const Eigen::VectorXd& time) {
  const double slack = kSameTime * step_of(truth.time);
  RowMatrix values(time.size(), truth.values.cols());
  const double* const begin = truth.time.data();
  const double* const end = begin + truth.time.size();
  for (Eigen::Index i = 0; i < time.size(); ++i) {
    const Eigen::Index row = std::lower_bound(begin, end, time[i] - slack) - begin;
    if (row == truth.time.size() || truth.time[row] > time[i] + slack) {
      return {values_at(truth.time, truth.values, time), true};
    }
    values.row(i) = truth.values.row(row);
  }
  return {values, false};
}

// RMS of (1), over stretches of numbers.
double roughness_of(const Eigen::VectorXd& time, const Eigen::VectorXd& x) {
  double squares = 0.0;
  int count = 0;
  for (Eigen::Index i = 2; i < x.size(); ++i) {
    const double before = (x[i - 1] - x[i - 2]) / (time[i - 1] - time[i - 2]);
    const double after = (x[i] - x[i - 1]) / (time[i] - time[i - 1]);
    const double second = 2.0 * (after - before) / (time[i] - time[i - 2]);
    if (!std::isfinite(second)) continue;
    squares += second * second;
    ++count;
  }
  return count > 0 ? std::sqrt(squares / count) : std::nan("");
}

ColumnComparison compare_columns(const std::string& label, const Eigen::VectorXd& time,
                                 const Eigen::VectorXd& x, const Eigen::VectorXd& y) {
  ColumnComparison column;
  column.label = label;
  double sum = 0.0, squares = 0.0, peak = 0.0;
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    const double error = x[i] - y[i];
    if (!std::isfinite(error)) continue;
    ++column.rows;
    sum += error;
    squares += error * error;
    peak = std::max(peak, std::abs(y[i]));
    if (!(std::abs(error) <= column.max)) {
      column.max = std::abs(error);
      column.time_of_max = time[i];
    }
  }
  if (column.rows == 0) return column;
  column.mean = sum / column.rows;
  column.rms = std::sqrt(squares / column.rows);
  column.peak = peak;
  column.roughness = roughness_of(time, x);
  column.true_roughness = roughness_of(time, y);
  return column;
}

[[noreturn]] void fail(const TimeTableFile& result, const TimeTableFile& truth,
                       const std::string& problem, const std::string& expected,
                       const std::string& found, const std::string& remedy) {
  throw InputError({result.path},
                   {fmt::format("cannot be compared with {}: {}", truth.path, problem), expected,
                    found, remedy});
}

const char* unit_of(const TimeTable& table) { return *table.in_degrees ? "degrees" : "radians"; }

}  // namespace

TableComparison compare_tables(const TimeTableFile& result_file, const TimeTableFile& truth_file,
                               const ComparisonOptions& options) {
  const TimeTable result = with_increasing_times(result_file.table);
  const TimeTable truth = with_increasing_times(truth_file.table);
  if (result.in_degrees && truth.in_degrees && *result.in_degrees != *truth.in_degrees) {
    fail(result_file, truth_file, "their angles have different units", unit_of(truth),
         unit_of(result), "Give the model, which says what an angle is.");
  }
  const auto [first, end] = rows_to_compare(result, truth, options);
  if (first == end) {
    fail(result_file, truth_file, "no row lies in the time asked for", range_text(truth.time),
         range_text(result.time), "Choose other times or files.");
  }
  TableComparison comparison;
  const Eigen::VectorXd time = result.time.segment(first, end - first);
  comparison.rows = static_cast<int>(time.size());
  comparison.from = time[0];
  comparison.to = time[time.size() - 1];
  RowMatrix true_values;
  std::tie(true_values, comparison.interpolated) = truth_at(truth, time);
  for (std::size_t c = 0; c < result.labels.size(); ++c) {
    const int partner = truth.find_column(result.labels[c]);
    if (partner < 0) {
      comparison.only_in_result.push_back(result.labels[c]);
      continue;
    }
    const auto column = static_cast<Eigen::Index>(c);
    comparison.columns.push_back(compare_columns(
        result.labels[c], time, result.values.col(column).segment(first, end - first),
        true_values.col(partner)));
  }
  for (const std::string& label : truth.labels) {
    if (result.find_column(label) < 0) comparison.only_in_truth.push_back(label);
  }
  if (comparison.columns.empty()) {
    const auto name = [](const TimeTable& t) { return t.labels.empty() ? "none" : t.labels[0]; };
    fail(result_file, truth_file, "they have no column in common", name(truth) + ", ...",
         name(result) + ", ...",
         "For coordinates whose labels differ, give the model; else rename columns.");
  }
  return comparison;
}

}  // namespace sinew
