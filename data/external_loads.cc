#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>

#include "data/setup_fields.h"
#include "data/storage_file.h"
#include "data/text.h"
#include "data/tool_setup.h"

namespace sinew {
namespace {

namespace fs = std::filesystem;
using std::string_view;

// 0, 1 or 2 for a label that ends in x, y, z or 1, 2, 3; else -1.
int axis_of(string_view label) {
  constexpr string_view kAxes = "xyz123XYZ";
  const std::size_t found = label.empty() ? kAxes.npos : kAxes.find(label.back());
  return found == kAxes.npos ? -1 : static_cast<int>(found % 3);
}

// True where only an axis follows the identifier, perhaps behind a separator.
bool only_axis_follows(string_view rest) {
  if (rest.size() == 2 && string_view("_.- ").find(rest.front()) != rest.npos) {
    rest.remove_prefix(1);
  }
  return rest.size() == 1 && axis_of(rest) >= 0;
}

std::vector<std::string> columns_of(const std::string& identifier,
                                    const std::vector<std::string>& labels) {
  std::vector<std::string> columns;
  for (const std::string& label : labels) {
    if (label.starts_with(identifier)) columns.push_back(label);
  }
  if (columns.size() > 3) {
    std::erase_if(columns, [&](const std::string& label) {
      return !only_axis_follows(string_view(label).substr(identifier.size()));
    });
  }
  std::array<std::string, 3> by_axis;
  for (const std::string& label : columns) {
    if (const int axis = axis_of(label); axis >= 0) by_axis[static_cast<std::size_t>(axis)] = label;
  }
  const bool ordered = columns.size() == 3 && std::none_of(by_axis.begin(), by_axis.end(),
                                                           [](const auto& s) { return s.empty(); });
  if (ordered) columns.assign(by_axis.begin(), by_axis.end());
  return columns;
}

std::string identifier_of(const XmlFile& xml, pugi::xml_node force, const char* name) {
  const std::string identifier = xml.text(force, name);
  return text::equals_ignoring_case(identifier, "Unassigned") ? "" : identifier;
}

// OpenSim 4 may write a path in the model where earlier versions have the body's name.
std::string body_of(const XmlFile& xml, pugi::xml_node force, const char* name) {
  const std::string body = xml.text(force, name);
  for (const string_view folder : {"/bodyset/", "/"}) {
    const bool inside = body.starts_with(folder) && body.find('/', folder.size()) == body.npos;
    if (inside) return body.substr(folder.size());
  }
  return body;
}

void check_force(const XmlFile& xml, pugi::xml_node node, const ExternalForce& force) {
  if (force.applied_to_body.empty()) {
    xml.fail(node, {fmt::format("external force '{}' names no body", force.name),
                    "<applied_to_body>", "", "Name the body that the force acts on."});
  }
  if (force.force_identifier.empty() && force.torque_identifier.empty()) {
    xml.fail(node, {fmt::format("external force '{}' has neither force nor torque", force.name),
                    "<force_identifier> or <torque_identifier>", "",
                    "Name what the columns of the data begin with."});
  }
  if (force.force_identifier.empty() && !force.point_identifier.empty()) {
    xml.fail(node, {fmt::format("external force '{}' has a point but no force", force.name),
                    "<force_identifier> beside <point_identifier>", "",
                    "Name the force's columns or remove the point's."});
  }
}

ExternalForce parse_force(const XmlFile& xml, pugi::xml_node node) {
  const string_view kind = node.name();
  if (kind == "PrescribedForce") {
    xml.fail(node, {"external loads as PrescribedForce, from before OpenSim 2.4, are not supported",
                    "<ExternalForce>", fmt::format("<{}>", kind),
                    "Open the file in OpenSim and save it again."});
  }
  if (kind != "ExternalForce") {
    xml.fail(node, {"an external load of an unknown kind", "<ExternalForce>",
                    fmt::format("<{}>", kind), "Remove the load."});
  }
  ExternalForce force;
  force.line = xml.location(node).line;
  force.name = node.attribute("name").value();
  force.applies =
      xml.boolean(node, "appliesForce").value_or(!xml.boolean(node, "isDisabled").value_or(false));
  force.applied_to_body = body_of(xml, node, "applied_to_body");
  const std::string force_frame = body_of(xml, node, "force_expressed_in_body");
  if (!force_frame.empty()) force.force_expressed_in_body = force_frame;
  const std::string point_frame = body_of(xml, node, "point_expressed_in_body");
  if (!point_frame.empty()) force.point_expressed_in_body = point_frame;
  force.force_identifier = identifier_of(xml, node, "force_identifier");
  force.point_identifier = identifier_of(xml, node, "point_identifier");
  force.torque_identifier = identifier_of(xml, node, "torque_identifier");
  if (force.applies) check_force(xml, node, force);
  return force;
}

struct Part {
  const char* element;
  const std::string* identifier;
  std::vector<std::string>* columns;
};

std::array<Part, 3> parts_of(ExternalForce& force) {
  return {{{"force_identifier", &force.force_identifier, &force.force_columns},
           {"point_identifier", &force.point_identifier, &force.point_columns},
           {"torque_identifier", &force.torque_identifier, &force.torque_columns}}};
}

void guess_columns(ExternalLoadsSetup& setup) {
  for (ExternalForce& force : setup.forces) {
    for (const Part& part : parts_of(force)) {
      if (part.identifier->empty()) continue;
      for (const char* axis : {"x", "y", "z"}) part.columns->push_back(*part.identifier + axis);
    }
  }
}

void read_kinematics(SetupFields& fields, ExternalLoadsSetup& setup) {
  setup.model_kinematics_file = fields.file("external_loads_model_kinematics_file");
  setup.kinematics_cutoff =
      fields.number("lowpass_cutoff_frequency_for_load_kinematics").value_or(-1.0);
  if (setup.model_kinematics_file.empty()) return;
  setup.warnings.push_back(
      {location_of(setup, "external_loads_model_kinematics_file"),
       "<external_loads_model_kinematics_file> is deprecated; OpenSim 4 does not read it"});
}

}  // namespace

void bind_columns(ExternalLoadsSetup& setup, const std::vector<std::string>& labels,
                  const std::string& data_name) {
  for (ExternalForce& force : setup.forces) {
    for (const Part& part : parts_of(force)) {
      part.columns->clear();
      if (part.identifier->empty() || !force.applies) continue;
      std::vector<std::string> columns = columns_of(*part.identifier, labels);
      if (columns.size() != 3) {
        throw InputError(
            {setup.path, force.line},
            {fmt::format("<{}> '{}' of external force '{}' does not fit the columns of {}",
                         part.element, *part.identifier, force.name, data_name),
             "exactly 3 labels that begin with it", fmt::format("{}", columns.size()),
             "Correct the identifier or the labels."});
      }
      *part.columns = std::move(columns);
    }
  }
}

ExternalLoadsSetup read_external_loads(const fs::path& path) {
  const XmlFile xml(path);
  const pugi::xml_node loads = find_tool(xml, {"ExternalLoads"});
  ExternalLoadsSetup setup;
  setup.path = xml.path();
  for (const pugi::xml_node node : loads.child("objects").children()) {
    if (node.type() == pugi::node_element) setup.forces.push_back(parse_force(xml, node));
  }
  if (setup.forces.empty()) setup.warnings.push_back({xml.location(loads), "has no forces"});
  SetupFields fields(xml, {loads}, setup.lines);
  setup.data_file = fields.file("datafile");
  read_kinematics(fields, setup);
  std::error_code error;
  if (fs::is_regular_file(setup.data_file, error)) {
    bind_columns(setup, read_storage_labels(setup.data_file), setup.data_file.string());
  } else {
    guess_columns(setup);
  }
  return setup;
}

}  // namespace sinew
