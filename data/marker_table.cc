#include "data/marker_table.h"

#include <fmt/format.h>

#include <cmath>
#include <optional>
#include <string_view>

#include "data/text.h"

namespace sinew {
namespace {

struct Column {
  std::string name;
  int axis = 0;
  double metres = 1.0;  // per unit
};

std::optional<Column> parse_label(std::string_view label) {
  Column column;
  for (const auto& [unit, metres] :
       {std::pair{"[mm]", 1e-3}, std::pair{"[cm]", 1e-2}, std::pair{"[m]", 1.0}}) {
    if (!label.ends_with(unit)) continue;
    column.metres = metres;
    label = text::trim(label.substr(0, label.size() - std::string_view(unit).size()));
    break;
  }
  constexpr std::string_view kAxes = "xyzXYZ123", kSeparators = "._:- ";
  if (label.size() < 3) return std::nullopt;
  const std::size_t axis = kAxes.find(label.back());
  const bool separated = kSeparators.find(label[label.size() - 2]) != kSeparators.npos;
  if (axis == kAxes.npos || !separated) return std::nullopt;
  column.axis = static_cast<int>(axis % 3);
  column.name = std::string(text::trim(label.substr(0, label.size() - 2)));
  if (column.name.empty()) return std::nullopt;
  return column;
}

// The three columns that begin with `first`, if they are x, y and z of one name.
std::optional<Column> triple_at(const std::vector<std::string>& labels, std::size_t first) {
  if (first + 3 > labels.size()) return std::nullopt;
  const std::optional<Column> x = parse_label(labels[first]);
  if (!x) return std::nullopt;
  for (int axis = 0; axis < 3; ++axis) {
    const auto column = parse_label(labels[first + static_cast<std::size_t>(axis)]);
    if (!column || column->axis != axis || column->name != x->name || column->metres != x->metres) {
      return std::nullopt;
    }
  }
  return x;
}

void check_times(const TimeTableFile& file) {
  const Eigen::VectorXd& time = file.table.time;
  if (time.size() < 2) {
    throw InputError({file.path}, {"is too short to tell the rate of markers", "at least 2 rows",
                                   fmt::format("{}", time.size()), "Was it written completely?"});
  }
  for (Eigen::Index i = 1; i < time.size(); ++i) {
    if (time[i] > time[i - 1]) continue;
    throw InputError({file.path}, {fmt::format("row {} repeats the time {} s", i + 1, time[i]),
                                   "times that increase", "", "Remove the row."});
  }
}

}  // namespace

TimeTable marker_table(const MarkerTrajectories& markers) {
  TimeTable table;
  table.name = "Markers";
  table.time = markers.time;
  table.values = markers.p_WM;
  for (const std::string& name : markers.names) {
    for (const char axis : {'x', 'y', 'z'}) table.labels.push_back(name + "." + axis);
  }
  return table;
}

double metres_per_unit(const TimeTable& table) {
  const auto first = triple_at(table.labels, 0);
  return first ? first->metres : 1.0;
}

bool holds_markers(const TimeTable& table) {
  if (table.labels.empty() || table.labels.size() % 3 != 0) return false;
  for (std::size_t i = 0; i < table.labels.size(); i += 3) {
    if (!triple_at(table.labels, i)) return false;
  }
  return true;
}

MarkerFile markers_from_table(const TimeTableFile& file) {
  check_times(file);
  MarkerFile result;
  result.path = file.path;
  result.warnings = file.warnings;
  MarkerTrajectories& markers = result.markers;
  markers.time = file.table.time;
  markers.p_WM = file.table.values;
  const Eigen::Index last = markers.time.size() - 1;
  markers.rate = static_cast<double>(last) / (markers.time[last] - markers.time[0]);
  for (int i = 1; i <= markers.frame_count(); ++i) markers.frame_numbers.push_back(i);
  for (std::size_t i = 0; i < file.table.labels.size(); i += 3) {
    const std::optional<Column> column = triple_at(file.table.labels, i);
    if (!column) {
      throw InputError({file.path},
                       {fmt::format("column '{}' begins no marker", file.table.labels[i]),
                        "NAME.x, NAME.y, NAME.z, one after the other", "",
                        "Name the columns so, or convert to a table instead (.mot, .sto, .csv)."});
    }
    markers.names.push_back(column->name);
    markers.p_WM.middleCols(static_cast<Eigen::Index>(i), 3) *= column->metres;
  }
  for (int frame = 0; frame < markers.frame_count(); ++frame) {
    for (int marker = 0; marker < markers.marker_count(); ++marker) {
      const Eigen::Vector3d p = markers.position(frame, marker);
      if (p.allFinite() || p.array().isNaN().all()) continue;
      throw InputError({file.path}, {fmt::format("marker '{}' is torn at {} s",
                                                 markers.names[static_cast<std::size_t>(marker)],
                                                 markers.time[frame]),
                                     "three coordinates or none", "", "Correct the row."});
    }
  }
  return result;
}

}  // namespace sinew
