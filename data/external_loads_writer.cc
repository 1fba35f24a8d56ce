#include "data/external_loads_writer.h"

#include <pugixml.hpp>
#include <sstream>
#include <string>
#include <system_error>

#include "data/output_file.h"

namespace sinew {
namespace {

void add(pugi::xml_node parent, const char* name, const std::string& text) {
  parent.append_child(name).text().set(text.c_str());
}

std::string data_name(const std::filesystem::path& setup, const std::filesystem::path& data) {
  std::error_code error;
  const auto folder = std::filesystem::absolute(setup, error).parent_path();
  const auto relative = std::filesystem::absolute(data, error).lexically_relative(folder);
  const bool below = !error && !relative.empty() && *relative.begin() != "..";
  return below ? relative.generic_string() : data.generic_string();
}

}  // namespace

void write_external_loads(const std::filesystem::path& path, const ExternalLoadsSetup& setup) {
  pugi::xml_document document;
  auto declaration = document.append_child(pugi::node_declaration);
  declaration.append_attribute("version") = "1.0";
  declaration.append_attribute("encoding") = "UTF-8";
  auto root = document.append_child("OpenSimDocument");
  root.append_attribute("Version") = "40000";
  auto loads = root.append_child("ExternalLoads");
  loads.append_attribute("name") = path.stem().string().c_str();
  auto objects = loads.append_child("objects");
  for (const ExternalForce& force : setup.forces) {
    auto node = objects.append_child("ExternalForce");
    node.append_attribute("name") = force.name.c_str();
    add(node, "isDisabled", force.applies ? "false" : "true");
    add(node, "applied_to_body", force.applied_to_body);
    add(node, "force_expressed_in_body", force.force_expressed_in_body);
    add(node, "point_expressed_in_body", force.point_expressed_in_body);
    add(node, "force_identifier", force.force_identifier);
    add(node, "point_identifier", force.point_identifier);
    add(node, "torque_identifier", force.torque_identifier);
  }
  add(loads, "datafile", data_name(path, setup.data_file));
  std::ostringstream text;
  document.save(text, "  ");
  write_file_atomically(path, text.str());
}

}  // namespace sinew
