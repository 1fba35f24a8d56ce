#include "model/skeleton.h"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

namespace sinew {
namespace {

// Where each index comes to lie when some are dropped; −1: dropped.
std::vector<int> renumber(const std::vector<char>& keep) {
  std::vector<int> to(keep.size(), -1);
  int next = 0;
  for (std::size_t i = 0; i < keep.size(); ++i) {
    if (keep[i]) to[i] = next++;
  }
  return to;
}

// Couplers, loops and markers of virtual links go with them.
void renumber_the_rest(const std::vector<int>& body, const std::vector<int>& coordinate,
                       MusculoskeletalModel& bones) {
  const auto coupled = [&](CoordinateCoupler& c) {
    c.dependent = coordinate[static_cast<std::size_t>(c.dependent)];
    c.independent = coordinate[static_cast<std::size_t>(c.independent)];
    return c.dependent < 0 || c.independent < 0;
  };
  std::erase_if(bones.couplers, coupled);
  for (WeldConstraint& weld : bones.welds) {
    weld.body1 = body[static_cast<std::size_t>(weld.body1)];
    weld.body2 = body[static_cast<std::size_t>(weld.body2)];
  }
  std::erase_if(bones.welds, [](const auto& w) { return w.body1 < 0 || w.body2 < 0; });
  for (PointConstraint& point : bones.point_constraints) {
    point.body1 = body[static_cast<std::size_t>(point.body1)];
    point.body2 = body[static_cast<std::size_t>(point.body2)];
  }
  std::erase_if(bones.point_constraints, [](const auto& p) { return p.body1 < 0 || p.body2 < 0; });
  for (Marker& marker : bones.markers) marker.body = body[static_cast<std::size_t>(marker.body)];
  std::erase_if(bones.markers, [](const Marker& m) { return m.body < 0; });
}

}  // namespace

Skeleton skeleton_of(const MusculoskeletalModel& model) {
  std::vector<char> keep_body(model.bodies.size()), keep_coordinate(model.coordinates.size());
  for (std::size_t b = 0; b < model.bodies.size(); ++b) {
    keep_body[b] = !model.bodies[b].virtual_link;
    if (b > 0 && model.bodies[static_cast<std::size_t>(model.joints[b - 1].parent)].virtual_link) {
      throw std::invalid_argument(
          fmt::format("body '{}' hangs from virtual link '{}'", model.bodies[b].name,
                      model.bodies[static_cast<std::size_t>(model.joints[b - 1].parent)].name));
    }
  }
  for (std::size_t c = 0; c < model.coordinates.size(); ++c) {
    keep_coordinate[c] = keep_body[static_cast<std::size_t>(model.coordinates[c].joint) + 1];
  }
  const std::vector<int> body = renumber(keep_body), coordinate = renumber(keep_coordinate);

  Skeleton result;
  MusculoskeletalModel& bones = result.model;
  bones = model;
  bones.bodies.clear();
  bones.joints.clear();
  bones.coordinates.clear();
  bones.paths.clear();
  for (std::size_t b = 0; b < model.bodies.size(); ++b) {
    if (!keep_body[b]) continue;
    bones.bodies.push_back(model.bodies[b]);
    if (b == 0) continue;
    Joint joint = model.joints[b - 1];
    joint.parent = body[static_cast<std::size_t>(joint.parent)];
    joint.child = body[static_cast<std::size_t>(joint.child)];
    for (int& c : joint.coordinates) c = coordinate[static_cast<std::size_t>(c)];
    for (TransformAxis& axis : joint.axes) {
      if (axis.coordinate >= 0) {
        axis.coordinate = coordinate[static_cast<std::size_t>(axis.coordinate)];
      }
    }
    bones.joints.push_back(std::move(joint));
  }
  for (std::size_t c = 0; c < model.coordinates.size(); ++c) {
    if (!keep_coordinate[c]) continue;
    bones.coordinates.push_back(model.coordinates[c]);
    bones.coordinates.back().joint =
        body[static_cast<std::size_t>(model.coordinates[c].joint) + 1] - 1;
    result.coordinates.push_back(static_cast<int>(c));
  }
  renumber_the_rest(body, coordinate, bones);
  result.bodies = body;
  validate(bones);
  return result;
}

}  // namespace sinew
