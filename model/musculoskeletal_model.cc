#include "model/musculoskeletal_model.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>

namespace sinew {
namespace {

template <typename Items>
int index_by_name(const Items& items, const std::string& name) {
  for (std::size_t i = 0; i < items.size(); ++i) {
    if (items[i].name == name) return static_cast<int>(i);
  }
  return -1;
}

[[noreturn]] void reject(const SourceLocation& at, std::string problem, std::string expected,
                         std::string found, std::string remedy) {
  throw InputError(at.file.empty() ? SourceLocation{"model"} : at,
                   {std::move(problem), std::move(expected), std::move(found), std::move(remedy)});
}

template <typename Items>
void require_unique(const Items& items, const char* what) {
  std::set<std::string> names;
  for (const auto& item : items) {
    if (!names.insert(item.name).second) {
      reject(item.source, fmt::format("two {} are called '{}'", what, item.name), "unique names",
             "", "Rename one of them.");
    }
  }
}

bool in_range(int index, std::size_t size) { return index >= 0 && index < static_cast<int>(size); }

void check_bodies(const MusculoskeletalModel& model) {
  if (model.bodies.empty() || model.joints.size() + 1 != model.bodies.size()) {
    throw std::invalid_argument(
        fmt::format("a model of {} bodies has {} joints; expected ground and "
                    "one joint for every other body",
                    model.bodies.size(), model.joints.size()));
  }
  if (model.bodies.size() < 2) {
    reject({}, "the model has no bodies", "at least one Body", "", "Name a model that has bodies.");
  }
  for (const Body& body : model.bodies) {
    if (!(body.mass >= 0.0) || !std::isfinite(body.mass) || !body.p_BCm.allFinite() ||
        !body.I_BCm.allFinite()) {
      reject(body.source, fmt::format("the mass properties of body '{}' are unusable", body.name),
             "finite numbers, mass 0 or more", "", "Correct mass, mass centre or inertia.");
    }
    if (body.virtual_link && (body.mass != 0.0 || !body.I_BCm.isZero(0.0))) {
      reject(body.source, fmt::format("virtual link '{}' has mass", body.name),
             "no mass and no inertia", fmt::format("{} kg", body.mass),
             "A virtual link is a place where paths fork, not a part of the body.");
    }
  }
}

void check_joints(const MusculoskeletalModel& model) {
  int next_coordinate = 0;
  for (std::size_t j = 0; j < model.joints.size(); ++j) {
    const Joint& joint = model.joints[j];
    if (joint.child != static_cast<int>(j) + 1 || joint.parent < 0 || joint.parent >= joint.child) {
      throw std::invalid_argument(
          fmt::format("joint '{}' connects body {} to {}; expected child {} and an earlier parent",
                      joint.name, joint.parent, joint.child, j + 1));
    }
    if (!joint.X_PF.p.allFinite() || !joint.X_PF.R.allFinite() || !joint.X_BM.p.allFinite() ||
        !joint.X_BM.R.allFinite()) {
      reject(joint.source, fmt::format("a frame of joint '{}' is not finite", joint.name),
             "finite numbers", "", "Correct the location and orientation of its frames.");
    }
    if (model.bodies[j + 1].virtual_link && joint.kind != Joint::Kind::kFree) {
      throw std::invalid_argument(fmt::format("joint '{}' of virtual link '{}' is not a free joint",
                                              joint.name, model.bodies[j + 1].name));
    }
    for (const int c : joint.coordinates) {
      if (c != next_coordinate++ || !in_range(c, model.coordinates.size()) ||
          model.coordinates[static_cast<std::size_t>(c)].joint != static_cast<int>(j)) {
        throw std::invalid_argument(
            fmt::format("coordinates of joint '{}' are out of order", joint.name));
      }
    }
  }
  if (next_coordinate != static_cast<int>(model.coordinates.size())) {
    throw std::invalid_argument("a coordinate belongs to no joint");
  }
}

int coordinate_count(Joint::Kind kind) {
  switch (kind) {
    case Joint::Kind::kWeld:
      return 0;
    case Joint::Kind::kPin:
    case Joint::Kind::kSlider:
      return 1;
    case Joint::Kind::kUniversal:
      return 2;
    case Joint::Kind::kBall:
    case Joint::Kind::kGimbal:
    case Joint::Kind::kPlanar:
    case Joint::Kind::kEllipsoid:
      return 3;
    case Joint::Kind::kFree:
      return 6;
    case Joint::Kind::kCustom:
      break;
  }
  return -1;  // any number up to six
}

// What the kind of a joint asks of its coordinates, axes and radii.
void check_joint_kinds(const MusculoskeletalModel& model) {
  for (const Joint& joint : model.joints) {
    const int count = static_cast<int>(joint.coordinates.size());
    const int expected = coordinate_count(joint.kind);
    if (expected >= 0 ? count != expected : count > 6) {
      throw std::invalid_argument(fmt::format("joint '{}' has {} coordinates; expected {}",
                                              joint.name, count,
                                              expected >= 0 ? std::to_string(expected) : "0 to 6"));
    }
    if (joint.kind == Joint::Kind::kEllipsoid && !(joint.radii.minCoeff() > 0.0)) {
      throw std::invalid_argument(
          fmt::format("ellipsoid joint '{}' has a radius that is not positive", joint.name));
    }
    if (joint.kind != Joint::Kind::kCustom) continue;
    for (const TransformAxis& step : joint.axes) {
      const bool own =
          step.coordinate < 0 || std::find(joint.coordinates.begin(), joint.coordinates.end(),
                                           step.coordinate) != joint.coordinates.end();
      if (!own || !(step.axis.norm() > 0.0) || !step.axis.allFinite()) {
        throw std::invalid_argument(fmt::format(
            "an axis of joint '{}' has no direction or another joint's coordinate", joint.name));
      }
    }
  }
}

void check_coordinates(const MusculoskeletalModel& model) {
  for (const Coordinate& c : model.coordinates) {
    if (!(c.range_min <= c.range_max) || !std::isfinite(c.default_value)) {
      reject(c.source, fmt::format("coordinate '{}' has an unusable range or default", c.name),
             "a lower bound below an upper one and a finite default", "",
             "Correct the coordinate.");
    }
  }
}

template <typename Constraints>
void check_constrained_bodies(const MusculoskeletalModel& model, const Constraints& constraints) {
  for (const auto& constraint : constraints) {
    if (!in_range(constraint.body1, model.bodies.size()) ||
        !in_range(constraint.body2, model.bodies.size())) {
      throw std::invalid_argument(
          fmt::format("constraint '{}' has a body out of range", constraint.name));
    }
  }
}

void check_paths(const MusculoskeletalModel& model) {
  for (const PathElement& path : model.paths) {
    for (const PathPoint& point : path.points) {
      if (!in_range(point.body, model.bodies.size()) || !point.p_BP.allFinite()) {
        reject(path.source,
               fmt::format("point '{}' of '{}' has an unusable place", point.name, path.name),
               "a body and three finite numbers", "", "Correct its location.");
      }
    }
  }
}

// Every dependent coordinate must have one coupler, and chains of couplers must end.
void check_couplers(const MusculoskeletalModel& model) {
  std::vector<int> source(model.coordinates.size(), -1);
  for (const CoordinateCoupler& coupler : model.couplers) {
    if (!in_range(coupler.dependent, source.size()) ||
        !in_range(coupler.independent, source.size())) {
      throw std::invalid_argument(
          fmt::format("coupler '{}' has an index out of range", coupler.name));
    }
    const auto dependent = static_cast<std::size_t>(coupler.dependent);
    if (source[dependent] >= 0) {
      reject(coupler.source,
             fmt::format("two couplers set coordinate '{}'", model.coordinates[dependent].name),
             "one coupler a coordinate", fmt::format("another in '{}'", coupler.name),
             "Remove one of them.");
    }
    source[dependent] = coupler.independent;
  }
  for (const CoordinateCoupler& coupler : model.couplers) {
    int c = coupler.dependent;
    for (std::size_t steps = 0; source[static_cast<std::size_t>(c)] >= 0; ++steps) {
      if (steps > model.couplers.size()) {
        reject(coupler.source,
               fmt::format("coupler '{}' makes coordinate '{}' depend on itself", coupler.name,
                           model.coordinates[static_cast<std::size_t>(coupler.dependent)].name),
               "couplers without a circle", "", "Remove a coupler.");
      }
      c = source[static_cast<std::size_t>(c)];
    }
  }
}

}  // namespace

int MusculoskeletalModel::virtual_link_count() const {
  return static_cast<int>(std::count_if(bodies.begin(), bodies.end(),
                                        [](const Body& body) { return body.virtual_link; }));
}

double MusculoskeletalModel::total_mass() const {
  double sum = 0.0;
  for (const Body& body : bodies) sum += body.mass;
  return sum;
}

int MusculoskeletalModel::find_body(const std::string& body_name) const {
  return index_by_name(bodies, body_name);
}
int MusculoskeletalModel::find_joint(const std::string& joint_name) const {
  return index_by_name(joints, joint_name);
}
int MusculoskeletalModel::find_coordinate(const std::string& coordinate_name) const {
  return index_by_name(coordinates, coordinate_name);
}
int MusculoskeletalModel::find_marker(const std::string& marker_name) const {
  return index_by_name(markers, marker_name);
}

double muscle_natural_length(const PathElement& muscle) {
  constexpr double kLongestFiber = 1.5;  // of the optimal length
  return muscle.tendon_slack_length + kLongestFiber * muscle.optimal_fiber_length;
}

void validate(const MusculoskeletalModel& model) {
  check_bodies(model);
  check_joints(model);
  check_joint_kinds(model);
  check_coordinates(model);
  check_couplers(model);
  check_constrained_bodies(model, model.welds);
  check_constrained_bodies(model, model.point_constraints);
  check_paths(model);
  require_unique(model.bodies, "bodies");
  require_unique(model.joints, "joints");
  require_unique(model.coordinates, "coordinates");
  require_unique(model.markers, "markers");
  for (const Marker& marker : model.markers) {
    if (!in_range(marker.body, model.bodies.size()) || !marker.p_BM.allFinite()) {
      reject(marker.source, fmt::format("marker '{}' has an unusable place", marker.name),
             "a body and three finite numbers", "", "Correct its location.");
    }
  }
  if (!model.gravity.allFinite()) {
    reject({}, "gravity is not finite", "three finite numbers", "", "Correct gravity.");
  }
}

}  // namespace sinew
