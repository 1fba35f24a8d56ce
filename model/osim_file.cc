#include "model/osim_file.h"

#include <fmt/format.h>

#include <set>
#include <utility>

#include "model/osim_reader.h"

namespace sinew {
namespace osim {

void Reader::warn(pugi::xml_node node, std::string text) {
  model.warnings.push_back({xml.location(node), std::move(text)});
}

std::string name_of(pugi::xml_node node) { return node.attribute("name").value(); }

std::vector<pugi::xml_node> set_members(pugi::xml_node parent, const char* set_name) {
  std::vector<pugi::xml_node> members;
  const pugi::xml_node set = parent.child(set_name);
  const pugi::xml_node objects = set.child("objects");
  for (const pugi::xml_node node : (objects ? objects : set).children()) {
    if (node.type() == pugi::node_element && std::string_view(node.name()) != "groups") {
      members.push_back(node);
    }
  }
  return members;
}

void read_markers(Reader& reader) {
  std::set<std::string> names;
  for (const pugi::xml_node node : set_members(reader.model_node, "MarkerSet")) {
    if (std::string_view(node.name()) != "Marker") continue;
    Marker marker;
    marker.name = name_of(node);
    marker.source = reader.xml.location(node);
    const std::string reference = frame_reference(reader.xml, node, "parent_frame", "body");
    if (reference.empty()) {
      reader.xml.fail(node, {fmt::format("marker '{}' names no body", marker.name),
                             "<socket_parent_frame> or <body> with a body's name", "",
                             "Name the body that carries the marker."});
    }
    if (!names.insert(marker.name).second) {
      reader.xml.fail(node, {fmt::format("two markers are called '{}'", marker.name),
                             "unique names", "", "Rename one of them."});
    }
    const FixedFrame frame = reader.frames.resolve(reference, "", node);
    marker.body = frame.body;
    marker.p_BM =
        frame.X_BF * reader.xml.vector3(node, "location").value_or(Eigen::Vector3d::Zero());
    marker.fixed = reader.xml.boolean(node, "fixed").value_or(false);
    reader.model.markers.push_back(marker);
  }
}

namespace {

// Versions older than the first that OpenSim's own reader converts have another layout of joints.
constexpr int kOldestVersion = 10000;

int read_version(const XmlFile& xml) {
  const pugi::xml_node root = xml.root();
  if (std::string_view(root.name()) != "OpenSimDocument") {
    xml.fail(root, {"is not an OpenSim document", "<OpenSimDocument> as root",
                    fmt::format("<{}>", root.name()), "Name an .osim model."});
  }
  const int version = root.attribute("Version").as_int(-1);
  if (version < kOldestVersion) {
    xml.fail(root,
             {"has no usable document version", "Version=\"10901\" or later",
              root.attribute("Version").value(), "Open the model in OpenSim and save it again."});
  }
  return version;
}

void check_units(const XmlFile& xml, pugi::xml_node model, const char* name,
                 std::initializer_list<const char*> accepted) {
  const std::string unit = xml.text(model, name);
  if (unit.empty() || unit == "Unassigned") return;  // OpenSim then takes SI, and so do we
  for (const char* good : accepted) {
    if (unit == good) return;
  }
  xml.fail(model.child(name), {fmt::format("<{}> is not supported", name), *accepted.begin(), unit,
                               "Scale the model to SI units."});
}

}  // namespace

MusculoskeletalModel read_document(const XmlFile& xml) {
  const int version = read_version(xml);
  Reader reader(xml);
  reader.model_node = xml.root().child("Model");
  if (!reader.model_node) {
    xml.fail(xml.root(), {"holds no model", "a <Model> element",
                          fmt::format("<{}>", xml.root().first_child().name()),
                          "Is it a setup file? Name an .osim model."});
  }
  reader.model.name = name_of(reader.model_node);
  reader.model.document_version = version;
  check_units(xml, reader.model_node, "length_units", {"meters", "m", "metres", "meter"});
  check_units(xml, reader.model_node, "force_units", {"N", "Newtons", "newtons"});
  if (const auto gravity = xml.vector3(reader.model_node, "gravity")) {
    reader.model.gravity = *gravity;
  }
  read_bodies(reader);
  if (reader.model.bodies.size() < 2) {
    xml.fail(reader.model_node, {"the model has no bodies", "at least one <Body> in its <BodySet>",
                                 "", "Name a model that has bodies."});
  }
  read_joints(reader);
  read_constraints(reader);
  read_markers(reader);
  read_forces(reader);
  mark_virtual_links(reader.model);
  validate(reader.model);
  return std::move(reader.model);
}

}  // namespace osim

MusculoskeletalModel read_osim(const std::filesystem::path& path) {
  return osim::read_document(XmlFile(path));
}

MusculoskeletalModel parse_osim(std::string name, std::string content) {
  return osim::read_document(XmlFile(std::move(name), std::move(content)));
}

}  // namespace sinew
