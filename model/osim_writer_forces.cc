#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "model/osim_elements.h"
#include "model/osim_reader.h"

namespace sinew::osim {
namespace {

void append_moving_location(pugi::xml_node node, const MusculoskeletalModel& model,
                            const PathPoint& point) {
  static constexpr const char* kLetters[] = {"x", "y", "z"};
  for (std::size_t i = 0; i < 3; ++i) {
    const int c = point.location[i].coordinate;
    if (c >= 0) {
      append_text(node, fmt::format("socket_{}_coordinate", kLetters[i]),
                  coordinate_path(model, c));
    }
    append_function(node.append_child(fmt::format("{}_location", kLetters[i]).c_str()),
                    point.location[i].function, "");
  }
  // OpenSim leaves it aside; it is where editors show the point.
  if (!point.p_BP.isZero(0.0)) append_vector(node, "location", point.p_BP);
}

void append_point(pugi::xml_node set, const MusculoskeletalModel& model, const PathElement& path,
                  std::size_t index) {
  static constexpr const char* kClasses[] = {"PathPoint", "ConditionalPathPoint",
                                             "MovingPathPoint"};
  const PathPoint& point = path.points[index];
  const std::string name =
      point.name.empty() ? fmt::format("{}-P{}", path.name, index + 1) : point.name;
  require_component_name(fmt::format("a point of '{}'", path.name), name, path.source);
  pugi::xml_node node = append_object(set, kClasses[static_cast<int>(point.kind)], name);
  append_text(node, "socket_parent_frame", body_path(model, point.body));
  if (point.kind == PathPoint::Kind::kMoving) {
    append_moving_location(node, model, point);
    return;
  }
  append_vector(node, "location", point.p_BP);
  if (point.kind == PathPoint::Kind::kConditional) {
    append_text(node, "socket_coordinate", coordinate_path(model, point.condition_coordinate));
    const double range[] = {point.condition_min, point.condition_max};
    append_numbers(node, "range", range);
  }
}

const char* standard_class(PathElement::Kind kind) {
  switch (kind) {
    case PathElement::Kind::kMuscle:
      break;
    case PathElement::Kind::kTendon:
      return "PathSpring";
    case PathElement::Kind::kLigament:
      return "Ligament";
    case PathElement::Kind::kActuator:
      return "PathActuator";
  }
  return "Millard2012EquilibriumMuscle";
}

bool is_class_name(const std::string& name) {
  return !name.empty() && std::all_of(name.begin(), name.end(), [](unsigned char c) {
    return std::isalnum(c) != 0 || c == '_';
  });
}

std::string class_of(const PathElement& path) {
  const bool keeps = is_class_name(path.class_name) && path_kind(path.class_name) == path.kind;
  return keeps ? path.class_name : standard_class(path.kind);
}

// Elements that are not known stay OpenSim's defaults.
void append_known(pugi::xml_node node, const char* name, double value) {
  if (!std::isnan(value)) append_number(node, name, value);
}

void require_natural_length(const PathElement& path) {
  constexpr double kRounding = 1e-12;
  const double follows = muscle_natural_length(path);
  if (std::isnan(path.natural_length) && std::isnan(follows)) return;
  if (std::abs(path.natural_length - follows) <= kRounding * std::abs(follows)) return;
  throw InputError(
      path.source.file.empty() ? SourceLocation{"model"} : path.source,
      {fmt::format("the natural length of muscle '{}' cannot stand in an .osim file", path.name),
       fmt::format("{} m, which follows from fibre and tendon", follows),
       fmt::format("{} m", path.natural_length),
       "Change optimal_fiber_length or tendon_slack_length instead."});
}

void append_muscle(pugi::xml_node node, const PathElement& path) {
  require_natural_length(path);
  append_known(node, "max_isometric_force", path.max_isometric_force);
  append_known(node, "optimal_fiber_length", path.optimal_fiber_length);
  append_known(node, "tendon_slack_length", path.tendon_slack_length);
  append_known(node, "pennation_angle_at_optimal", path.pennation_angle);
}

// See write_osim() for the rule.
double stiffness_of(const MusculoskeletalModel& model, const PathElement& tendon) {
  if (!std::isnan(tendon.stiffness)) return tendon.stiffness;
  constexpr double kStretch = 0.033, kForce = 1000.0;
  std::set<int> links;
  for (const PathPoint* end : {&tendon.points.front(), &tendon.points.back()}) {
    if (model.bodies[static_cast<std::size_t>(end->body)].virtual_link) links.insert(end->body);
  }
  double force = 0.0;
  for (const PathElement& path : model.paths) {
    const bool pulls =
        links.contains(path.points.front().body) || links.contains(path.points.back().body);
    if (pulls && path.kind == PathElement::Kind::kMuscle && path.max_isometric_force > 0.0) {
      force += path.max_isometric_force;
    }
  }
  return (force > 0.0 ? force : kForce) / (kStretch * tendon.natural_length);
}

void append_tendon(pugi::xml_node node, const MusculoskeletalModel& model,
                   const PathElement& path) {
  if (!(path.natural_length > 0.0)) {
    throw InputError(path.source.file.empty() ? SourceLocation{"model"} : path.source,
                     {fmt::format("tendon '{}' cannot stand in an .osim file", path.name),
                      "a natural length above 0", fmt::format("{}", path.natural_length),
                      "Give it the length at which it becomes taut."});
  }
  append_number(node, "resting_length", path.natural_length);
  append_number(node, "stiffness", stiffness_of(model, path));
  append_number(node, "dissipation", std::isnan(path.dissipation) ? 0.0 : path.dissipation);
}

[[noreturn]] void reject_length_of_actuator(const PathElement& path) {
  throw InputError(
      path.source.file.empty() ? SourceLocation{"model"} : path.source,
      {fmt::format("the natural length of actuator '{}' cannot stand in an .osim file", path.name),
       "none", fmt::format("{} m", path.natural_length),
       "Make it a tendon, or remove the length."});
}

void append_path(pugi::xml_node set, const MusculoskeletalModel& model, const PathElement& path) {
  require_component_name("a path", path.name, path.source);
  const std::string class_name = class_of(path);
  pugi::xml_node node = append_object(set, class_name, path.name);
  pugi::xml_node geometry = append_object(node, "GeometryPath", "path");
  pugi::xml_node points = append_set(geometry, "PathPointSet");
  for (std::size_t i = 0; i < path.points.size(); ++i) append_point(points, model, path, i);
  switch (path.kind) {
    case PathElement::Kind::kMuscle:
      append_muscle(node, path);
      break;
    case PathElement::Kind::kTendon:
      append_tendon(node, model, path);
      break;
    case PathElement::Kind::kLigament:
      append_known(node, class_name == "Ligament" ? "resting_length" : "slack_length",
                   path.natural_length);
      append_known(node, "pcsa_force", path.pcsa_force);
      break;
    case PathElement::Kind::kActuator:
      if (!std::isnan(path.natural_length)) reject_length_of_actuator(path);
      break;
  }
}

}  // namespace

void append_forces(pugi::xml_node model_node, const MusculoskeletalModel& model) {
  pugi::xml_node set = append_set(model_node, "ForceSet");
  for (const PathElement& path : model.paths) append_path(set, model, path);
}

}  // namespace sinew::osim
