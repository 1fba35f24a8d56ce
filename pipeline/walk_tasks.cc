#include "pipeline/walk_tasks.h"

#include <algorithm>

#include "data/reference_walk.h"
#include "dynamics/reference_recording.h"
#include "ik/tracking.h"
#include "model/kinematic_tree.h"

namespace sinew {
namespace {

// Beside a marker's weight of 1/m². Coordinates that markers leave undetermined and the walk keeps
// still are held to where they are, as gait models do that take thorax and shoulder girdle as rigid
// [1/rad²]; what else is undetermined, in the lumbar spine, is drawn to the neutral pose so weakly
// that it gives markers way to 1e-4 rad: it decides nothing but how vertebrae share a turn,
// equally.
constexpr double kStillWeight = 1.0, kPostureWeight = 1e-4;

// A task's weight stands beside the mean of the markers, ours beside their sum.
IkTask coordinate_task(const Coordinate& coordinate, double weight, std::size_t markers) {
  IkTask task;
  task.kind = IkTask::Kind::kCoordinate;
  task.name = coordinate.name;
  task.weight = weight / static_cast<double>(markers);
  return task;
}

// Coordinates between bones that markers and tasks leave free in the neutral pose.
std::vector<int> free_coordinates(const MusculoskeletalModel& model, const KinematicTree& tree,
                                  const MarkerTrajectories& standing, const IkTaskSet& tasks) {
  BindingOptions markers_only;
  markers_only.wires.use = WireOptions::Use::kNone;
  markers_only.wires.virtual_link_weight = 0.0;
  const TrackingProblem tracking =
      bind_recording(model, tree, {"static", standing, {}}, &tasks, nullptr, markers_only);
  IkTargets targets(tracking.problem);
  set_targets(tracking, standing, 0, targets);
  std::vector<int> coordinates =
      undetermined_coordinates(model, tree, tracking, targets, tree.default_q);
  std::erase_if(coordinates, [&](int c) {
    const Coordinate& coordinate = model.coordinates[static_cast<std::size_t>(c)];
    return model.bodies[static_cast<std::size_t>(coordinate.joint) + 1].virtual_link;
  });
  return coordinates;
}

bool moves(const ReferenceWalk& walk, const std::string& coordinate) {
  return std::any_of(walk.curves.begin(), walk.curves.end(),
                     [&](const WalkCurve& curve) { return curve.coordinate == coordinate; });
}

}  // namespace

IkTaskSet walk_tasks(const MusculoskeletalModel& model) {
  const ReferenceWalk walk = reference_walk();
  const MarkerTrajectories standing = make_static_recording(model);
  const KinematicTree tree = compile_tree(model);
  IkTaskSet set;
  set.path = "walk";
  for (const std::string& name : standing.names) set.tasks.push_back({.name = name});
  const auto coordinate = [&model](int c) {
    return model.coordinates[static_cast<std::size_t>(c)];
  };
  for (const int c : free_coordinates(model, tree, standing, set)) {
    if (moves(walk, coordinate(c).name)) continue;
    set.tasks.push_back(coordinate_task(coordinate(c), kStillWeight, standing.names.size()));
  }
  for (const int c : free_coordinates(model, tree, standing, set)) {
    set.tasks.push_back(coordinate_task(coordinate(c), kPostureWeight, standing.names.size()));
  }
  return set;
}

}  // namespace sinew
