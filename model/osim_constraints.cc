#include <fmt/format.h>

#include <string_view>

#include "model/osim_reader.h"

namespace sinew::osim {
namespace {

bool is_enforced(const Reader& reader, pugi::xml_node node) {
  return reader.xml.boolean(node, "isEnforced")
      .value_or(!reader.xml.boolean(node, "isDisabled").value_or(false));
}

void read_coupler(Reader& reader, pugi::xml_node node) {
  const XmlFile& xml = reader.xml;
  CoordinateCoupler coupler;
  coupler.name = name_of(node);
  coupler.source = xml.location(node);
  std::vector<std::string> independent = xml.words(node, "independent_coordinate_names");
  if (independent.size() != 1) {
    xml.fail(node, {fmt::format("coupler '{}' has the wrong number of independent coordinates",
                                coupler.name),
                    "1", std::to_string(independent.size()),
                    "Functions of several coordinates are not supported."});
  }
  coupler.independent = coordinate_index(reader, independent[0], node);
  coupler.dependent = coordinate_index(reader, xml.text(node, "dependent_coordinate_name"), node);
  const auto function = find_function(xml, node, "coupled_coordinates_function");
  if (!function) {
    xml.fail(node,
             {fmt::format("coupler '{}' has no function", coupler.name),
              "<coupled_coordinates_function> with a function in it", "", "Add the function."});
  }
  coupler.function = *function;
  coupler.function.scale *= xml.number(node, "scale_factor").value_or(1.0);
  reader.model.couplers.push_back(coupler);
}

FixedFrame constraint_body(Reader& reader, pugi::xml_node node, const char* socket,
                           const char* old_name) {
  const std::string reference = frame_reference(reader.xml, node, socket, old_name);
  if (reference.empty()) {
    reader.xml.fail(node, {fmt::format("constraint '{}' names no {}", name_of(node), old_name),
                           fmt::format("<socket_{}> or <{}> with a body", socket, old_name), "",
                           "Name the body, or disable the constraint."});
  }
  return reader.frames.resolve(reference, name_of(node), node);
}

RigidTransform offset(const XmlFile& xml, pugi::xml_node node, const char* location,
                      const char* orientation) {
  RigidTransform X;
  X.p = xml.vector3(node, location).value_or(Eigen::Vector3d::Zero());
  X.R = rotation_from_body_xyz(xml.vector3(node, orientation).value_or(Eigen::Vector3d::Zero()));
  return X;
}

void read_weld(Reader& reader, pugi::xml_node node) {
  reader.frames.add_frames(name_of(node), node);
  const FixedFrame f1 = constraint_body(reader, node, "frame1", "body_1");
  const FixedFrame f2 = constraint_body(reader, node, "frame2", "body_2");
  WeldConstraint weld;
  weld.name = name_of(node);
  weld.source = reader.xml.location(node);
  weld.body1 = f1.body;
  weld.body2 = f2.body;
  weld.X_B1F1 = f1.X_BF * offset(reader.xml, node, "location_body_1", "orientation_body_1");
  weld.X_B2F2 = f2.X_BF * offset(reader.xml, node, "location_body_2", "orientation_body_2");
  reader.model.welds.push_back(weld);
}

void read_point(Reader& reader, pugi::xml_node node) {
  reader.frames.add_frames(name_of(node), node);
  const FixedFrame f1 = constraint_body(reader, node, "body_1", "body_1");
  const FixedFrame f2 = constraint_body(reader, node, "body_2", "body_2");
  PointConstraint point;
  point.name = name_of(node);
  point.source = reader.xml.location(node);
  point.body1 = f1.body;
  point.body2 = f2.body;
  point.p_B1P1 = f1.X_BF * offset(reader.xml, node, "location_body_1", "").p;
  point.p_B2P2 = f2.X_BF * offset(reader.xml, node, "location_body_2", "").p;
  reader.model.point_constraints.push_back(point);
}

}  // namespace

void read_constraints(Reader& reader) {
  for (const pugi::xml_node node : set_members(reader.model_node, "ConstraintSet")) {
    if (!is_enforced(reader, node)) continue;
    const std::string_view kind = node.name();
    if (kind == "CoordinateCouplerConstraint") {
      read_coupler(reader, node);
    } else if (kind == "WeldConstraint") {
      read_weld(reader, node);
    } else if (kind == "PointConstraint") {
      read_point(reader, node);
    } else {
      reader.model.unsupported.push_back({node.name(), name_of(node),
                                          UnsupportedElement::Effect::kKinematics,
                                          reader.xml.location(node)});
      reader.warn(node, fmt::format("<{}> '{}' is not supported: it will not be kept", node.name(),
                                    name_of(node)));
    }
  }
}

}  // namespace sinew::osim
