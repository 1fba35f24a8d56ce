#include "ik/wire_binding.h"

#include <fmt/format.h>

#include <cmath>
#include <stdexcept>

namespace sinew {
namespace {

bool moves(const PathElement& path) {
  for (const PathPoint& point : path.points) {
    if (point.kind == PathPoint::Kind::kMoving) return true;
  }
  return false;
}

double weight_of(PathElement::Kind kind, const WireOptions& options) {
  switch (kind) {
    case PathElement::Kind::kTendon:
      return options.tendon_weight;
    case PathElement::Kind::kLigament:
      return options.ligament_weight;
    default:
      return options.muscle_weight;
  }
}

WirePoint wire_point_of(const PathPoint& point, const KinematicTree& tree) {
  WirePoint result{point.body, point.p_BP};
  if (point.kind == PathPoint::Kind::kConditional && point.condition_coordinate >= 0) {
    result.condition_q = tree.q_of_coordinate[static_cast<std::size_t>(point.condition_coordinate)];
    result.condition_min = point.condition_min;
    result.condition_max = point.condition_max;
  }
  return result;
}

// A condition on an end would leave the wire hanging in the air: the point counts as fixed.
void add_wire(const PathElement& path, const KinematicTree& tree, double weight,
              IkProblem& problem) {
  problem.wires.push_back({static_cast<int>(problem.wire_points.size()),
                           static_cast<int>(path.points.size()), path.natural_length, weight});
  for (std::size_t i = 0; i < path.points.size(); ++i) {
    WirePoint point = wire_point_of(path.points[i], tree);
    if (i == 0 || i + 1 == path.points.size()) point.condition_q = -1;
    problem.wire_points.push_back(point);
  }
}

}  // namespace

void WireOptions::validate() const {
  const auto check = [](const char* field, double value) {
    if (std::isfinite(value) && value >= 0.0) return;
    throw std::invalid_argument(
        fmt::format("WireOptions.{} is {}; expected a finite number, 0 or more", field, value));
  };
  check("penalty", penalty);
  check("muscle_weight", muscle_weight);
  check("tendon_weight", tendon_weight);
  check("ligament_weight", ligament_weight);
  check("virtual_link_weight", virtual_link_weight);
}

std::vector<int> bind_virtual_links(const MusculoskeletalModel& model, const KinematicTree& tree,
                                    const WireOptions& options, IkProblem& problem) {
  std::vector<int> coordinates;
  if (options.virtual_link_weight == 0.0) return coordinates;
  for (std::size_t b = 1; b < model.bodies.size(); ++b) {
    if (!model.bodies[b].virtual_link) continue;
    for (const int c : model.joints[b - 1].coordinates) {
      const auto i = static_cast<std::size_t>(c);
      if (model.coordinates[i].locked) continue;
      problem.coordinates.push_back(
          {tree.q_of_coordinate[i], tree.v_of_coordinate[i], options.virtual_link_weight});
      coordinates.push_back(c);
    }
  }
  return coordinates;
}

std::vector<TrackedWire> bind_wires(const MusculoskeletalModel& model, const KinematicTree& tree,
                                    const WireOptions& options, IkProblem& problem,
                                    std::vector<Warning>& warnings) {
  options.validate();
  std::vector<TrackedWire> wires;
  if (options.use == WireOptions::Use::kNone) return wires;
  if (options.use == WireOptions::Use::kAuto && model.virtual_link_count() == 0) return wires;
  int left_out = 0;
  const PathElement* first = nullptr;
  for (std::size_t i = 0; i < model.paths.size(); ++i) {
    const PathElement& path = model.paths[i];
    if (path.kind == PathElement::Kind::kActuator) continue;
    if (!path.wrap_objects.empty() || moves(path) || !(path.natural_length >= 0.0)) {
      if (left_out++ == 0) first = &path;
      continue;
    }
    const double weight = options.penalty * weight_of(path.kind, options);
    if (weight == 0.0) continue;
    add_wire(path, tree, weight, problem);
    wires.push_back({path.name, static_cast<int>(i)});
  }
  if (left_out > 0) {
    warnings.push_back(
        {first->source,
         fmt::format("{} of {} paths are no wires of the inverse kinematics, since they run over "
                     "wrap objects, have moving points or no natural length (first: '{}')",
                     left_out, model.paths.size(), first->name)});
  }
  return wires;
}

}  // namespace sinew
