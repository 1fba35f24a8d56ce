#include "model/model_summary.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "model/kinematic_tree.h"
#include "model/path_length.h"

namespace sinew {
namespace {

bool is_coupled(const MusculoskeletalModel& model, int coordinate) {
  return std::any_of(model.couplers.begin(), model.couplers.end(),
                     [&](const CoordinateCoupler& c) { return c.dependent == coordinate; });
}

void count_coordinates(const MusculoskeletalModel& model, ModelSummary& summary) {
  for (std::size_t c = 0; c < model.coordinates.size(); ++c) {
    const Coordinate& coordinate = model.coordinates[c];
    const bool coupled = is_coupled(model, static_cast<int>(c));
    ++(coupled ? summary.coupled : summary.dof);
    if (!coupled && (coordinate.locked || coordinate.prescribed)) ++summary.locked;
  }
}

void count_paths(const MusculoskeletalModel& model, ModelSummary& summary) {
  for (const PathElement& path : model.paths) {
    if (!std::isnan(path.natural_length)) ++summary.wires;
    switch (path.kind) {
      case PathElement::Kind::kMuscle:
        ++summary.muscles;
        break;
      case PathElement::Kind::kTendon:
        ++summary.tendons;
        break;
      case PathElement::Kind::kLigament:
        ++summary.ligaments;
        break;
      case PathElement::Kind::kActuator:
        ++summary.actuators;
        break;
    }
  }
}

// The description's index of the coordinate, and an error for one that cannot be swept.
int independent_coordinate(const MusculoskeletalModel& model, const std::string& name) {
  const int c = model.find_coordinate(name);
  const SourceLocation at = {model.name.empty() ? "model" : model.name};
  if (c < 0) {
    throw InputError(at, {fmt::format("has no coordinate '{}'", name),
                          "the name of one of its coordinates", "", "See `sinew model info`."});
  }
  for (const CoordinateCoupler& coupler : model.couplers) {
    if (coupler.dependent != c) continue;
    const std::string& source =
        model.coordinates[static_cast<std::size_t>(coupler.independent)].name;
    throw InputError(
        at, {fmt::format("coordinate '{}' follows '{}' and moves nothing by itself", name, source),
             "an independent coordinate", "", fmt::format("Ask for '{}'.", source)});
  }
  return c;
}

std::vector<double> values_over_range(const Coordinate& c, int count) {
  const double reach =
      c.motion == Coordinate::Motion::kTranslational ? 0.1 : 0.5 * std::numbers::pi;
  const double low = std::isfinite(c.range_min) ? c.range_min : -reach;
  const double high = std::isfinite(c.range_max) ? c.range_max : reach;
  if (!(low < high)) {
    throw InputError(
        c.source.file.empty() ? SourceLocation{"model"} : c.source,
        {fmt::format("coordinate '{}' has no range to go over", c.name), "a range of some width",
         fmt::format("{} to {}", low, high), "Correct its range."});
  }
  std::vector<double> values;
  for (int i = 0; i < count; ++i) values.push_back(low + (high - low) * i / (count - 1));
  return values;
}

}  // namespace

ModelSummary summarize(const MusculoskeletalModel& model) {
  ModelSummary summary;
  count_coordinates(model, summary);
  count_paths(model, summary);
  summary.virtual_links = model.virtual_link_count();
  summary.bodies = static_cast<int>(model.bodies.size()) - 1 - summary.virtual_links;
  summary.markers = static_cast<int>(model.markers.size());
  summary.mass = model.total_mass();
  for (const Joint& joint : model.joints) {
    summary.depth.push_back(
        joint.parent == 0 ? 0 : summary.depth[static_cast<std::size_t>(joint.parent) - 1] + 1);
  }
  summary.crossing_paths.assign(model.joints.size(), 0);
  for (const PathElement& path : model.paths) {
    const std::vector<bool> crossed = joints_crossed(model, path);
    for (std::size_t j = 0; j < crossed.size(); ++j) summary.crossing_paths[j] += crossed[j];
  }
  return summary;
}

std::vector<bool> joints_crossed(const MusculoskeletalModel& model, const PathElement& path) {
  // Points on each body and beyond it: children stand after their parents.
  std::vector<std::size_t> beyond(model.bodies.size(), 0);
  for (const PathPoint& point : path.points) ++beyond[static_cast<std::size_t>(point.body)];
  for (std::size_t b = beyond.size() - 1; b > 0; --b) {
    beyond[static_cast<std::size_t>(model.joints[b - 1].parent)] += beyond[b];
  }
  std::vector<bool> crossed;
  for (std::size_t b = 1; b < beyond.size(); ++b) {
    crossed.push_back(beyond[b] > 0 && beyond[b] < path.points.size());
  }
  return crossed;
}

MomentArmTable moment_arm_table(const MusculoskeletalModel& model, const std::string& coordinate,
                                int count) {
  MomentArmTable table;
  table.coordinate = independent_coordinate(model, coordinate);
  const auto c = static_cast<std::size_t>(table.coordinate);
  table.values = values_over_range(model.coordinates[c], count);
  const KinematicTree tree = compile_tree(model, {.ignore_locks = true});
  KinematicWorkspace workspace(tree);
  const auto x = static_cast<std::size_t>(
      tree.unknown_of_v[static_cast<std::size_t>(tree.v_of_coordinate[c])]);
  std::vector<double> arms(static_cast<std::size_t>(tree.unknown_count()));
  std::vector<MomentArmTable::Row> rows(model.paths.size());
  for (const double value : table.values) {
    workspace.q[static_cast<std::size_t>(tree.q_of_coordinate[c])] = value;
    update_kinematics(tree, workspace);
    for (std::size_t p = 0; p < rows.size(); ++p) {
      rows[p].path = static_cast<int>(p);
      rows[p].lengths.push_back(path_length(model.paths[p], tree, workspace));
      moment_arms(model.paths[p], tree, workspace, arms);
      rows[p].arms.push_back(arms[x]);
    }
  }
  constexpr double kRounding = 1e-12;  // [m]; a path that the coordinate does not move
  for (MomentArmTable::Row& row : rows) {
    const auto acts = [](double arm) { return std::abs(arm) > kRounding; };
    if (std::any_of(row.arms.begin(), row.arms.end(), acts)) table.rows.push_back(std::move(row));
  }
  return table;
}

}  // namespace sinew
