#include <fmt/format.h>

#include <algorithm>
#include <string_view>

#include "model/osim_reader.h"

namespace sinew::osim {
namespace {

using Effect = UnsupportedElement::Effect;

// `x_location` … of a moving point, with the coordinate that drives it.
void read_moving_location(Reader& reader, pugi::xml_node node, PathPoint& point) {
  static constexpr const char* kLetters[] = {"x", "y", "z"};
  for (std::size_t i = 0; i < 3; ++i) {
    const std::string location = fmt::format("{}_location", kLetters[i]);
    const std::string coordinate = fmt::format("{}_coordinate", kLetters[i]);
    const auto function = find_function(reader.xml, node, location.c_str());
    if (!function) {
      reader.xml.fail(node,
                      {fmt::format("moving path point '{}' has no <{}>", point.name, location),
                       "a function of a coordinate", "", "Add the function."});
    }
    point.location[i].function = *function;
    const std::string reference =
        frame_reference(reader.xml, node, coordinate.c_str(), coordinate.c_str());
    if (!reference.empty()) {
      point.location[i].coordinate = coordinate_index(reader, reference, node);
    }
  }
}

void read_condition(Reader& reader, pugi::xml_node node, PathPoint& point) {
  const std::vector<double> range = reader.xml.numbers(node.child("range"));
  if (range.size() != 2) {
    reader.xml.fail(node,
                    {fmt::format("conditional path point '{}' has an unusable range", point.name),
                     "two numbers in <range>", reader.xml.text(node, "range"),
                     "Give the coordinate's lowest and highest value on the path."});
  }
  point.condition_min = std::min(range[0], range[1]);
  point.condition_max = std::max(range[0], range[1]);
  point.condition_coordinate =
      coordinate_index(reader, frame_reference(reader.xml, node, "coordinate", "coordinate"), node);
}

PathPoint::Kind point_kind(Reader& reader, pugi::xml_node node) {
  const std::string_view kind = node.name();
  if (kind == "PathPoint" || kind == "MusclePoint") return PathPoint::Kind::kFixed;
  if (kind == "ConditionalPathPoint" || kind == "MuscleViaPoint") {
    return PathPoint::Kind::kConditional;
  }
  if (kind == "MovingPathPoint" || kind == "MovingMusclePoint") return PathPoint::Kind::kMoving;
  reader.xml.fail(
      node,
      {fmt::format("<{}> is a kind of path point that is not supported", node.name()),
       "PathPoint, ConditionalPathPoint or MovingPathPoint", "", "Replace it by a PathPoint."});
}

PathPoint read_path_point(Reader& reader, pugi::xml_node node, const std::string& owner) {
  PathPoint point;
  point.name = name_of(node);
  point.kind = point_kind(reader, node);
  const std::string reference = frame_reference(reader.xml, node, "parent_frame", "body");
  if (reference.empty()) {
    reader.xml.fail(node, {fmt::format("a path point of '{}' names no body", owner),
                           "<socket_parent_frame> or <body> with a body's name", "",
                           "Name the body that carries the point."});
  }
  const FixedFrame frame = reader.frames.resolve(reference, "", node);
  point.body = frame.body;
  point.p_BP = frame.X_BF * reader.xml.vector3(node, "location").value_or(Eigen::Vector3d::Zero());
  if (point.kind == PathPoint::Kind::kConditional) read_condition(reader, node, point);
  if (point.kind == PathPoint::Kind::kMoving) read_moving_location(reader, node, point);
  return point;
}

}  // namespace

PathElement::Kind path_kind(std::string_view class_name) {
  if (class_name.find("Ligament") != std::string_view::npos) return PathElement::Kind::kLigament;
  if (class_name == "PathSpring") return PathElement::Kind::kTendon;
  if (class_name == "PathActuator") return PathElement::Kind::kActuator;
  return PathElement::Kind::kMuscle;
}

namespace {

void read_path(Reader& reader, pugi::xml_node node, pugi::xml_node path) {
  const XmlFile& xml = reader.xml;
  PathElement element;
  element.name = name_of(node);
  element.class_name = node.name();
  element.kind = path_kind(element.class_name);
  element.source = xml.location(node);
  const char* points = path.child("MusclePointSet") ? "MusclePointSet" : "PathPointSet";
  for (const pugi::xml_node point : set_members(path, points)) {
    element.points.push_back(read_path_point(reader, point, element.name));
  }
  if (element.points.size() < 2) {
    xml.fail(node, {fmt::format("the path of '{}' has too few points", element.name), "2 or more",
                    std::to_string(element.points.size()), "Add points, or remove the muscle."});
  }
  const char* wraps = path.child("MuscleWrapSet") ? "MuscleWrapSet" : "PathWrapSet";
  for (const pugi::xml_node wrap : set_members(path, wraps)) {
    element.wrap_objects.push_back(xml.text(wrap, "wrap_object"));
  }
  element.max_isometric_force = xml.number(node, "max_isometric_force").value_or(kNaN);
  element.optimal_fiber_length = xml.number(node, "optimal_fiber_length").value_or(kNaN);
  element.tendon_slack_length = xml.number(node, "tendon_slack_length").value_or(kNaN);
  element.pennation_angle = xml.number(node, "pennation_angle_at_optimal")
                                .value_or(xml.number(node, "pennation_angle").value_or(kNaN));
  element.natural_length = element.kind == PathElement::Kind::kMuscle
                               ? muscle_natural_length(element)
                               : xml.number(node, "resting_length")
                                     .value_or(xml.number(node, "slack_length").value_or(kNaN));
  if (element.kind == PathElement::Kind::kTendon) {
    element.stiffness = xml.number(node, "stiffness").value_or(kNaN);
    element.dissipation = xml.number(node, "dissipation").value_or(kNaN);
  }
  if (element.kind == PathElement::Kind::kLigament) {
    element.pcsa_force = xml.number(node, "pcsa_force").value_or(kNaN);
  }
  reader.model.paths.push_back(std::move(element));
}

// A body that has no weight and that only paths hold is a furcation.
bool is_virtual_link(const MusculoskeletalModel& model, int b) {
  const Body& body = model.bodies[static_cast<std::size_t>(b)];
  const double heaviest = std::max(body.I_BCm(0, 0), std::max(body.I_BCm(1, 1), body.I_BCm(2, 2)));
  if (body.mass > kVirtualLinkMass || heaviest > kVirtualLinkInertia) return false;
  if (model.joints[static_cast<std::size_t>(b) - 1].kind != Joint::Kind::kFree) return false;
  const auto hangs_on_it = [b](const Joint& joint) { return joint.parent == b; };
  if (std::any_of(model.joints.begin(), model.joints.end(), hangs_on_it)) return false;
  return std::any_of(model.paths.begin(), model.paths.end(), [b](const PathElement& path) {
    return path.points.front().body == b || path.points.back().body == b;
  });
}

// Forces that inverse dynamics would have to apply; everything else in a ForceSet is an actuator,
// whose effort is what inverse dynamics finds.
bool acts_without_command(std::string_view class_name) {
  for (const std::string_view passive :
       {"Spring", "Bushing", "LimitForce", "HuntCrossley", "ElasticFoundation", "HalfSpaceForce",
        "ExpressionBased", "PrescribedForce", "SmoothSphere", "ExternalForce", "Blankevoort"}) {
    if (class_name.find(passive) != std::string_view::npos) return true;
  }
  return false;
}

}  // namespace

void mark_virtual_links(MusculoskeletalModel& model) {
  for (std::size_t b = 1; b < model.bodies.size(); ++b) {
    if (!is_virtual_link(model, static_cast<int>(b))) continue;
    model.bodies[b].virtual_link = true;
    model.bodies[b].mass = 0.0;
    model.bodies[b].I_BCm.setZero();
  }
}

void read_forces(Reader& reader) {
  std::size_t wrapped = 0, passive = 0;
  pugi::xml_node first_wrapped, first_passive;
  std::vector<pugi::xml_node> forces = set_members(reader.model_node, "ForceSet");
  // Version 1 keeps muscles in an ActuatorSet.
  for (const pugi::xml_node node : set_members(reader.model_node, "ActuatorSet")) {
    forces.push_back(node);
  }
  for (const pugi::xml_node node : forces) {
    pugi::xml_node path = node.child("GeometryPath");
    if (!path && node.child("MusclePointSet")) path = node;
    if (path) {
      read_path(reader, node, path);
      if (!reader.model.paths.back().wrap_objects.empty() && wrapped++ == 0) first_wrapped = node;
      continue;
    }
    const bool acts = acts_without_command(node.name());
    reader.model.unsupported.push_back({node.name(), name_of(node),
                                        acts ? Effect::kDynamics : Effect::kNone,
                                        reader.xml.location(node)});
    if (acts && passive++ == 0) first_passive = node;
  }
  if (wrapped > 0) {
    reader.warn(
        first_wrapped,
        fmt::format("{} muscle or ligament paths run over wrap objects, which are not "
                    "supported: their lengths are those of the straight paths (first: '{}')",
                    wrapped, name_of(first_wrapped)));
  }
  if (passive > 0) {
    reader.warn(
        first_passive,
        fmt::format("{} forces that act without a muscle are not applied in inverse dynamics; "
                    "their effort is part of the generalized forces (first: <{}> '{}')",
                    passive, first_passive.name(), name_of(first_passive)));
  }
}

}  // namespace sinew::osim
