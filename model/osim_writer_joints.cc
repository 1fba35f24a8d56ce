#include <fmt/format.h>

#include "model/osim_elements.h"
#include "model/osim_reader.h"

namespace sinew::osim {
namespace {

void append_coordinate(pugi::xml_node parent, const MusculoskeletalModel& model, int index) {
  const Coordinate& c = model.coordinates[static_cast<std::size_t>(index)];
  const std::string name = name_in_joint(model, index);
  require_component_name(fmt::format("coordinate '{}'", c.name), name, c.source);
  pugi::xml_node node = append_object(parent, "Coordinate", name);
  append_number(node, "default_value", c.default_value);
  append_number(node, "default_speed_value", c.default_speed);
  const double range[] = {c.range_min, c.range_max};
  append_numbers(node, "range", range);
  append_boolean(node, "clamped", c.clamped);
  append_boolean(node, "locked", c.locked);
  append_boolean(node, "prescribed", c.prescribed.has_value());
  if (c.prescribed) {
    append_function(node.append_child("prescribed_function"), *c.prescribed, "");
  }
}

// A document does not say how a coordinate counts; readers tell by its joint.
void require_motion(const Joint& joint, const Coordinate& c, Coordinate::Motion read_back) {
  static constexpr const char* kMotions[] = {"rotational", "translational", "coupled"};
  if (c.motion == read_back) return;
  throw InputError(
      c.source.file.empty() ? SourceLocation{"model"} : c.source,
      {fmt::format("the motion type of coordinate '{}' cannot stand in an .osim file", c.name),
       fmt::format("{}, as joint '{}' makes it", kMotions[static_cast<int>(read_back)], joint.name),
       kMotions[static_cast<int>(c.motion)], "Correct its motion type."});
}

void append_spatial_transform(pugi::xml_node parent, const MusculoskeletalModel& model,
                              const Joint& joint) {
  static constexpr const char* kSteps[] = {"rotation1",    "rotation2",    "rotation3",
                                           "translation1", "translation2", "translation3"};
  pugi::xml_node transform = parent.append_child("SpatialTransform");
  for (std::size_t i = 0; i < joint.axes.size(); ++i) {
    const TransformAxis& step = joint.axes[i];
    pugi::xml_node node = append_object(transform, "TransformAxis", kSteps[i]);
    append_text(node, "coordinates",
                step.coordinate < 0 ? "" : name_in_joint(model, step.coordinate));
    append_vector(node, "axis", step.axis);
    append_function(node, step.function, "function");
  }
}

void append_joint(pugi::xml_node set, const MusculoskeletalModel& model, const Joint& joint) {
  require_component_name("a joint", joint.name, joint.source);
  const std::string parent = model.bodies[static_cast<std::size_t>(joint.parent)].name + "_offset";
  const std::string child = model.bodies[static_cast<std::size_t>(joint.child)].name + "_offset";
  pugi::xml_node node = append_object(set, joint_class_name(joint.kind), joint.name);
  append_text(node, "socket_parent_frame", parent);
  append_text(node, "socket_child_frame", child);
  if (!joint.coordinates.empty()) {
    pugi::xml_node coordinates = node.append_child("coordinates");
    for (const int c : joint.coordinates) append_coordinate(coordinates, model, c);
  }
  pugi::xml_node frames = node.append_child("frames");
  append_offset_frame(frames, parent, body_path(model, joint.parent), joint.X_PF);
  append_offset_frame(frames, child, body_path(model, joint.child), joint.X_BM);
  if (joint.kind == Joint::Kind::kCustom) append_spatial_transform(node, model, joint);
  if (joint.kind == Joint::Kind::kEllipsoid) append_vector(node, "radii_x_y_z", joint.radii);
}

}  // namespace

void append_joints(pugi::xml_node model_node, const MusculoskeletalModel& model) {
  pugi::xml_node set = append_set(model_node, "JointSet");
  for (const Joint& joint : model.joints) {
    for (std::size_t i = 0; i < joint.coordinates.size(); ++i) {
      require_motion(joint, model.coordinates[static_cast<std::size_t>(joint.coordinates[i])],
                     motion_of(joint, i));
    }
    append_joint(set, model, joint);
  }
}

}  // namespace sinew::osim
