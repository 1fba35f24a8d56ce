#include "model/osim_writer.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <pugixml.hpp>
#include <sstream>

#include "model/osim_elements.h"
#include "model/osim_reader.h"

namespace sinew {
namespace osim {
namespace {

constexpr int kDocumentVersion = 40000;  // the first of OpenSim 4

void append_bodies(pugi::xml_node model_node, const MusculoskeletalModel& model) {
  append_object(model_node, "Ground", "ground");
  pugi::xml_node set = append_set(model_node, "BodySet");
  for (std::size_t b = 1; b < model.bodies.size(); ++b) {
    const Body& body = model.bodies[b];
    require_component_name("a body", body.name, body.source);
    pugi::xml_node node = append_object(set, "Body", body.name);
    append_number(node, "mass", body.virtual_link ? kVirtualLinkMass : body.mass);
    append_vector(node, "mass_center", body.p_BCm);
    const Eigen::Matrix3d I =
        body.virtual_link ? Eigen::Matrix3d(kVirtualLinkInertia * Eigen::Matrix3d::Identity())
                          : body.I_BCm;
    const double inertia[] = {I(0, 0), I(1, 1), I(2, 2), I(0, 1), I(0, 2), I(1, 2)};
    append_numbers(node, "inertia", inertia);
  }
}

void append_coupler(pugi::xml_node set, const MusculoskeletalModel& model,
                    const CoordinateCoupler& coupler) {
  const auto name_of = [&](int c) { return model.coordinates[static_cast<std::size_t>(c)].name; };
  pugi::xml_node node = append_object(set, "CoordinateCouplerConstraint", coupler.name);
  append_boolean(node, "isEnforced", true);
  append_function(node.append_child("coupled_coordinates_function"), coupler.function, "");
  append_text(node, "independent_coordinate_names", name_of(coupler.independent));
  append_text(node, "dependent_coordinate_name", name_of(coupler.dependent));
}

void append_weld(pugi::xml_node set, const MusculoskeletalModel& model,
                 const WeldConstraint& weld) {
  pugi::xml_node node = append_object(set, "WeldConstraint", weld.name);
  append_boolean(node, "isEnforced", true);
  append_text(node, "socket_frame1", "frame1");
  append_text(node, "socket_frame2", "frame2");
  pugi::xml_node frames = node.append_child("frames");
  append_offset_frame(frames, "frame1", body_path(model, weld.body1), weld.X_B1F1);
  append_offset_frame(frames, "frame2", body_path(model, weld.body2), weld.X_B2F2);
}

void append_point_constraint(pugi::xml_node set, const MusculoskeletalModel& model,
                             const PointConstraint& point) {
  pugi::xml_node node = append_object(set, "PointConstraint", point.name);
  append_boolean(node, "isEnforced", true);
  append_text(node, "socket_body_1", body_path(model, point.body1));
  append_text(node, "socket_body_2", body_path(model, point.body2));
  append_vector(node, "location_body_1", point.p_B1P1);
  append_vector(node, "location_body_2", point.p_B2P2);
}

void append_constraints(pugi::xml_node model_node, const MusculoskeletalModel& model) {
  pugi::xml_node set = append_set(model_node, "ConstraintSet");
  for (const CoordinateCoupler& coupler : model.couplers) append_coupler(set, model, coupler);
  for (const WeldConstraint& weld : model.welds) append_weld(set, model, weld);
  for (const PointConstraint& point : model.point_constraints) {
    append_point_constraint(set, model, point);
  }
}

void append_markers(pugi::xml_node model_node, const MusculoskeletalModel& model) {
  pugi::xml_node set = append_set(model_node, "MarkerSet");
  for (const Marker& marker : model.markers) {
    require_component_name("a marker", marker.name, marker.source);
    append_marker(set, model, marker);
  }
}

}  // namespace

void append_marker(pugi::xml_node objects, const MusculoskeletalModel& model,
                   const Marker& marker) {
  pugi::xml_node node = append_object(objects, "Marker", marker.name);
  append_text(node, "socket_parent_frame", body_path(model, marker.body));
  append_vector(node, "location", marker.p_BM);
  append_boolean(node, "fixed", marker.fixed);
}

}  // namespace osim

std::string write_osim(const MusculoskeletalModel& model) {
  pugi::xml_document document;
  pugi::xml_node declaration = document.append_child(pugi::node_declaration);
  declaration.append_attribute("version").set_value("1.0");
  declaration.append_attribute("encoding").set_value("UTF-8");
  pugi::xml_node root = document.append_child("OpenSimDocument");
  root.append_attribute("Version").set_value(osim::kDocumentVersion);
  pugi::xml_node node = osim::append_object(root, "Model", osim::component_name(model.name));
  osim::append_vector(node, "gravity", model.gravity);
  osim::append_text(node, "length_units", "meters");
  osim::append_text(node, "force_units", "N");
  osim::append_bodies(node, model);
  osim::append_joints(node, model);
  osim::append_constraints(node, model);
  osim::append_markers(node, model);
  osim::append_forces(node, model);
  std::ostringstream out;
  document.save(out, "  ");
  return out.str();
}

std::vector<Warning> losses_of_osim(const MusculoskeletalModel& model) {
  std::vector<Warning> losses;
  if (const std::string name = osim::component_name(model.name); name != model.name) {
    losses.push_back({{},
                      fmt::format("OpenSim refuses blanks and \\ / * + in names: the model "
                                  "'{}' is written as '{}'",
                                  model.name, name)});
  }
  std::map<std::string, std::vector<const UnsupportedElement*>> by_class;
  for (const UnsupportedElement& element : model.unsupported) {
    by_class[element.class_name].push_back(&element);
  }
  for (const auto& [class_name, elements] : by_class) {
    losses.push_back({elements[0]->source,
                      fmt::format("<{}> is not written, as Sinew does not treat it ({} of them, "
                                  "first: '{}')",
                                  class_name, elements.size(), elements[0]->name)});
  }
  const auto wraps = [](const PathElement& path) { return !path.wrap_objects.empty(); };
  const auto first = std::find_if(model.paths.begin(), model.paths.end(), wraps);
  if (first != model.paths.end()) {
    losses.push_back(
        {first->source, fmt::format("{} paths are written without the surfaces that they wrap "
                                    "over, which Sinew does not treat (first: '{}')",
                                    std::count_if(first, model.paths.end(), wraps), first->name)});
  }
  return losses;
}

}  // namespace sinew
