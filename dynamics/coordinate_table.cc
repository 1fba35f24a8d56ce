#include "dynamics/coordinate_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string_view>

namespace sinew {
namespace {

constexpr double kRadiansPerDegree = std::numbers::pi / 180.0;
constexpr int kColumnsBeyondRange = 2;

// `knee_r` of `knee_r`, `/jointset/knee/knee_r/value`, `knee/knee_r/value`; empty for other states.
std::string_view coordinate_of(std::string_view label) {
  constexpr std::string_view kValue = "/value";
  if (label.find('/') == label.npos) return label;
  if (!label.ends_with(kValue)) return {};
  label.remove_suffix(kValue.size());
  return label.substr(label.rfind('/') + 1);
}

bool is_other_state(std::string_view label) {
  return label.find('/') != label.npos && coordinate_of(label).empty();
}

// Column of every coordinate, or −1.
std::vector<int> find_columns(const MusculoskeletalModel& model, const TimeTableFile& file,
                              std::vector<Warning>& warnings) {
  const std::vector<std::string>& labels = file.table.labels;
  std::vector<int> columns(model.coordinates.size(), -1);
  std::string unknown;
  int other_states = 0;
  for (std::size_t j = 0; j < labels.size(); ++j) {
    const int c = model.find_coordinate(std::string(coordinate_of(labels[j])));
    if (c < 0) {
      if (is_other_state(labels[j])) {
        ++other_states;
      } else {
        unknown += (unknown.empty() ? "" : ", ") + labels[j];
      }
      continue;
    }
    int& column = columns[static_cast<std::size_t>(c)];
    if (column >= 0) {
      throw InputError({file.path, 0},
                       {fmt::format("two columns for coordinate '{}'",
                                    model.coordinates[static_cast<std::size_t>(c)].name),
                        "", labels[static_cast<std::size_t>(column)] + " and " + labels[j],
                        "Remove one of them."});
    }
    column = static_cast<int>(j);
  }
  if (std::all_of(columns.begin(), columns.end(), [](int column) { return column < 0; })) {
    throw InputError(
        {file.path, 0},
        {fmt::format("no column is a coordinate of model '{}'", model.name),
         "labels such as " + (model.coordinates.empty() ? "none" : model.coordinates.front().name),
         unknown, "Choose the model that the motion was made with."});
  }
  if (!unknown.empty()) {
    warnings.push_back({{file.path, 0}, "ignored columns that are no coordinates: " + unknown});
  }
  if (other_states > 0) {
    warnings.push_back(
        {{file.path, 0},
         fmt::format("ignored {} states that are no coordinate values", other_states)});
  }
  return columns;
}

bool decide_degrees(const MusculoskeletalModel& model, const TimeTableFile& file,
                    const std::vector<int>& columns, std::vector<Warning>& warnings) {
  if (file.table.in_degrees) return *file.table.in_degrees;
  double largest = 0.0;
  int beyond_range = 0;
  for (std::size_t c = 0; c < columns.size(); ++c) {
    const Coordinate& coordinate = model.coordinates[c];
    if (columns[c] < 0 || coordinate.motion != Coordinate::Motion::kRotational) continue;
    const auto values = file.table.values.col(columns[c]);
    largest = std::max(largest, values.cwiseAbs().maxCoeff());
    if (values.minCoeff() < coordinate.range_min - kRangeMargin ||
        values.maxCoeff() > coordinate.range_max + kRangeMargin) {
      ++beyond_range;
    }
  }
  const bool degrees = largest > kLargestRadians || beyond_range >= kColumnsBeyondRange;
  warnings.push_back(
      {{file.path, 0},
       fmt::format("the header has no inDegrees; angles are taken as {}, because the largest is "
                   "{:.4g} and {} columns would leave the model's ranges in radians. Add "
                   "inDegrees=yes or inDegrees=no to the header to be sure",
                   degrees ? "degrees" : "radians", largest, beyond_range)});
  return degrees;
}

// OpenSim before 4.0 wrote every coordinate that its model calls rotational in degrees; since 4.0
// those that only drive functions, such as a patella's, stay in radians. What tells is the coupler
// that sets the coordinate: the unit in which the column keeps closer to it is the right one.
bool is_coupled_in_degrees(const MusculoskeletalModel& model, std::size_t c,
                           const TimeTableFile& file, const std::vector<int>& columns) {
  if (model.coordinates[c].motion != Coordinate::Motion::kCoupled) return false;
  for (const CoordinateCoupler& coupler : model.couplers) {
    const auto from = static_cast<std::size_t>(coupler.independent);
    if (coupler.dependent != static_cast<int>(c) || columns[from] < 0) continue;
    const bool turns = model.coordinates[from].motion == Coordinate::Motion::kRotational;
    const CompiledFunction function(coupler.function);
    double error = 0.0, error_in_degrees = 0.0;
    for (Eigen::Index i = 0; i < file.table.values.rows(); ++i) {
      const double independent =
          file.table.values(i, columns[from]) * (turns ? kRadiansPerDegree : 1.0);
      const double value = file.table.values(i, columns[c]);
      error += std::abs(value - function.value(independent));
      error_in_degrees += std::abs(value * kRadiansPerDegree - function.value(independent));
    }
    return error_in_degrees < error;
  }
  return false;
}

void require_finite(const TimeTableFile& file, const std::vector<int>& columns) {
  for (const int column : columns) {
    for (Eigen::Index i = 0; column >= 0 && i < file.table.values.rows(); ++i) {
      if (std::isfinite(file.table.values(i, column))) continue;
      throw InputError({file.path, 0},
                       {fmt::format("coordinate '{}' in row {}, at {} s",
                                    file.table.labels[static_cast<std::size_t>(column)], i + 1,
                                    file.table.time[i]),
                        "a number", fmt::format("{}", file.table.values(i, column)),
                        "Fill the gap or leave the column out."});
    }
  }
}

// Rows to keep: all but those that repeat the row before them.
std::vector<Eigen::Index> distinct_rows(const CoordinateTable& table) {
  std::vector<Eigen::Index> kept;
  for (Eigen::Index i = 0; i < table.time.size(); ++i) {
    if (kept.empty() || table.time[i] > table.time[kept.back()]) {
      kept.push_back(i);
    } else if (table.time[i] < table.time[kept.back()] ||
               table.q.row(i) != table.q.row(kept.back())) {
      throw InputError(
          {table.path, 0},
          {fmt::format("two rows of coordinates differ at one time, row {} and the "
                       "one before it",
                       i + 1),
           "increasing time", fmt::format("{} s", table.time[i]), "Remove one of the rows."});
    }
  }
  return kept;
}

}  // namespace

CoordinateTable coordinate_table(const MusculoskeletalModel& model, const TimeTableFile& file) {
  if (file.table.time.size() == 0) {
    throw InputError({file.path, 0}, {"holds no rows of coordinates", "", "",
                                      "Choose the file that holds the motion."});
  }
  CoordinateTable result;
  result.path = file.path;
  const std::vector<int> columns = find_columns(model, file, result.warnings);
  require_finite(file, columns);
  const bool degrees = decide_degrees(model, file, columns, result.warnings);

  result.time = file.table.time;
  result.q.resize(file.table.time.size(), static_cast<Eigen::Index>(columns.size()));
  for (std::size_t c = 0; c < columns.size(); ++c) {
    const Coordinate& coordinate = model.coordinates[c];
    const auto to = static_cast<Eigen::Index>(c);
    result.measured.push_back(columns[c] >= 0);
    if (columns[c] < 0) {
      result.q.col(to).setConstant(coordinate.default_value);
      result.warnings.push_back(
          {{file.path, 0},
           fmt::format("has no coordinate '{}'; it stays at its default value {:.6g}",
                       coordinate.name, coordinate.default_value)});
      continue;
    }
    const bool coupled_turn = degrees && is_coupled_in_degrees(model, c, file, columns);
    if (coupled_turn) {
      result.warnings.push_back(
          {{file.path, 0},
           fmt::format("coordinate '{}' is taken as degrees, as OpenSim before 4.0 wrote it: that "
                       "is closer to what its coupler says than radians",
                       coordinate.name)});
    }
    const bool turn =
        coupled_turn || (degrees && coordinate.motion == Coordinate::Motion::kRotational);
    result.q.col(to) = file.table.values.col(columns[c]) * (turn ? kRadiansPerDegree : 1.0);
  }
  const std::vector<Eigen::Index> kept = distinct_rows(result);
  if (static_cast<Eigen::Index>(kept.size()) < result.time.size()) {
    result.warnings.push_back(
        {{file.path, 0},
         fmt::format("dropped {} repeated rows",
                     result.time.size() - static_cast<Eigen::Index>(kept.size()))});
    result.time = result.time(kept).eval();
    result.q = result.q(kept, Eigen::all).eval();
  }
  return result;
}

}  // namespace sinew
