#include "model/osim_elements.h"

#include <fmt/format.h>

#include "data/text.h"

namespace sinew::osim {
namespace {

// OpenSim's ComponentPath refuses these in names.
constexpr const char* kRefused = "\\/*+ \t\n\r";

}  // namespace

pugi::xml_node append_object(pugi::xml_node parent, const std::string& class_name,
                             const std::string& name) {
  pugi::xml_node node = parent.append_child(class_name.c_str());
  node.append_attribute("name").set_value(name.c_str());
  return node;
}

void append_text(pugi::xml_node parent, const std::string& name, const std::string& text) {
  parent.append_child(name.c_str()).text().set(text.c_str());
}

void append_number(pugi::xml_node parent, const std::string& name, double value) {
  append_text(parent, name, text::format_number(value));
}

void append_numbers(pugi::xml_node parent, const std::string& name,
                    std::span<const double> values) {
  std::string joined;
  for (const double value : values) {
    if (!joined.empty()) joined += ' ';
    joined += text::format_number(value);
  }
  append_text(parent, name, joined);
}

void append_vector(pugi::xml_node parent, const std::string& name, const Eigen::Vector3d& value) {
  append_numbers(parent, name, {value.data(), 3});
}

void append_boolean(pugi::xml_node parent, const std::string& name, bool value) {
  append_text(parent, name, value ? "true" : "false");
}

pugi::xml_node append_set(pugi::xml_node parent, const std::string& set_name) {
  return parent.append_child(set_name.c_str()).append_child("objects");
}

void append_offset_frame(pugi::xml_node frames, const std::string& name,
                         const std::string& body_path, const RigidTransform& X_BF) {
  pugi::xml_node frame = append_object(frames, "PhysicalOffsetFrame", name);
  append_text(frame, "socket_parent", body_path);
  append_vector(frame, "translation", X_BF.p);
  append_vector(frame, "orientation", body_xyz_from_rotation(X_BF.R));
}

std::string body_path(const MusculoskeletalModel& model, int body) {
  return body == 0 ? "/ground" : "/bodyset/" + model.bodies[static_cast<std::size_t>(body)].name;
}

std::string name_in_joint(const MusculoskeletalModel& model, int coordinate) {
  const Coordinate& c = model.coordinates[static_cast<std::size_t>(coordinate)];
  const std::string prefix = model.joints[static_cast<std::size_t>(c.joint)].name + "/";
  return c.name.starts_with(prefix) ? c.name.substr(prefix.size()) : c.name;
}

std::string coordinate_path(const MusculoskeletalModel& model, int coordinate) {
  const int joint = model.coordinates[static_cast<std::size_t>(coordinate)].joint;
  return fmt::format("/jointset/{}/{}", model.joints[static_cast<std::size_t>(joint)].name,
                     name_in_joint(model, coordinate));
}

std::string component_name(std::string name) {
  for (std::size_t i = name.find_first_of(kRefused); i != std::string::npos;
       i = name.find_first_of(kRefused, i)) {
    name[i] = '_';
  }
  return name;
}

void require_component_name(const std::string& what, const std::string& name,
                            const SourceLocation& source) {
  if (!name.empty() && name.find_first_of(kRefused) == std::string::npos) return;
  throw InputError(source.file.empty() ? SourceLocation{"model"} : source,
                   {fmt::format("the name of {} cannot stand in an .osim file", what),
                    "a name without blanks and \\ / * +", fmt::format("'{}'", name), "Rename it."});
}

}  // namespace sinew::osim
