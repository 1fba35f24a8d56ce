#include "model/osim_document.h"

#include <fmt/format.h>

#include <map>
#include <set>
#include <sstream>
#include <string_view>

#include "model/osim_elements.h"
#include "model/osim_reader.h"
#include "model/osim_scaling.h"

namespace sinew {
namespace {

using osim::name_of;
using osim::set_members;
using osim::set_numbers;

// Document versions in which a marker refers to its body by <body>, and in which sockets still had
// the long name.
constexpr int kFirstSockets = 30501, kFirstShortSockets = 30517;

std::string last_name(const std::string& path) { return path.substr(path.find_last_of('/') + 1); }

// A new line as deep as the children of `parent`, so that the document stays readable.
void append_new_line(pugi::xml_node parent, int up) {
  int depth = -up;
  for (pugi::xml_node node = parent; node.parent(); node = node.parent()) ++depth;
  parent.append_child(pugi::node_pcdata)
      .set_value(("\n" + std::string(static_cast<std::size_t>(std::max(0, depth)), '\t')).c_str());
}

pugi::xml_node marker_objects(pugi::xml_node model_node) {
  pugi::xml_node set = model_node.child("MarkerSet");
  if (!set) {
    append_new_line(model_node, 0);
    set = model_node.append_child("MarkerSet");
  }
  pugi::xml_node objects = set.child("objects");
  return objects ? objects : set.append_child("objects");
}

void remove_with_line(pugi::xml_node node) {
  pugi::xml_node parent = node.parent();
  const pugi::xml_node blank = node.previous_sibling();
  if (blank && blank.type() == pugi::node_pcdata) parent.remove_child(blank);
  parent.remove_child(node);
}

void set_location(pugi::xml_node marker, const Eigen::Vector3d& p) {
  pugi::xml_node location = marker.child("location");
  if (!location) location = marker.append_child("location");
  set_numbers(location, {p.data(), 3});
}

struct NewMarker {
  std::string name, body_or_frame;
  bool on_body = true;
  Eigen::Vector3d location;
  bool fixed = false;
};

// As the document's version writes it.
void append_marker(pugi::xml_node objects, int version, const NewMarker& marker) {
  append_new_line(objects, 0);
  pugi::xml_node node = osim::append_object(objects, "Marker", marker.name);
  const auto line = [&] { append_new_line(node, 0); };
  line();
  if (version < kFirstSockets) {
    osim::append_text(node, "body", last_name(marker.body_or_frame));
  } else {
    const std::string path = !marker.on_body ? marker.body_or_frame
                             : marker.body_or_frame == "ground"
                                 ? "/ground"
                                 : "/bodyset/" + marker.body_or_frame;
    osim::append_text(
        node,
        version < kFirstShortSockets ? "socket_parent_frame_connectee_name" : "socket_parent_frame",
        path);
  }
  line();
  osim::append_vector(node, "location", marker.location);
  line();
  osim::append_boolean(node, "fixed", marker.fixed);
  append_new_line(node, 1);
}

// The markers of a MarkerSet file; a marker's body must be one of `model`.
std::vector<NewMarker> read_marker_set(const XmlFile& xml, const MusculoskeletalModel& model) {
  const pugi::xml_node root = xml.root();
  if (std::string_view(root.name()) != "MarkerSet" && !root.child("MarkerSet")) {
    xml.fail(root, {"holds no markers", "an OpenSimDocument with a <MarkerSet>",
                    fmt::format("<{}> with <{}>", root.name(), root.first_child().name()),
                    "Name a file with a marker set."});
  }
  std::vector<NewMarker> markers;
  std::set<std::string> names;
  const pugi::xml_node parent = root.child("MarkerSet") ? root : pugi::xml_node();
  for (const pugi::xml_node node :
       parent ? set_members(parent, "MarkerSet") : set_members(root.parent(), "MarkerSet")) {
    if (std::string_view(node.name()) != "Marker") continue;
    NewMarker marker;
    marker.name = name_of(node);
    if (marker.name.empty() || !names.insert(marker.name).second) {
      xml.fail(node, {marker.name.empty() ? "a marker has no name"
                                          : fmt::format("two markers are called '{}'", marker.name),
                      "unique names", "", "Rename one of them."});
    }
    const std::string reference = osim::frame_reference(xml, node, "parent_frame", "body");
    marker.body_or_frame = last_name(reference);
    if (model.find_body(marker.body_or_frame) < 0) {
      xml.fail(node, {fmt::format("marker '{}' is on a body that model '{}' does not have",
                                  marker.name, model.name),
                      "the name of a body of the model", reference,
                      "Correct the name, or remove the marker."});
    }
    marker.location = xml.vector3(node, "location").value_or(Eigen::Vector3d::Zero());
    if (!marker.location.allFinite()) {
      xml.fail(node, {fmt::format("the location of marker '{}' is not finite", marker.name),
                      "three finite numbers", xml.text(node, "location"), "Correct the location."});
    }
    marker.fixed = xml.boolean(node, "fixed").value_or(false);
    markers.push_back(marker);
  }
  return markers;
}

}  // namespace

OsimDocument::OsimDocument(const std::filesystem::path& path)
    : xml_(std::make_unique<XmlFile>(path, XmlFile::Keep::kEverything)),
      model_(osim::read_document(*xml_)) {}

OsimDocument::OsimDocument(std::string name, std::string content)
    : xml_(std::make_unique<XmlFile>(std::move(name), std::move(content),
                                     XmlFile::Keep::kEverything)),
      model_(osim::read_document(*xml_)) {}

void OsimDocument::rename(const std::string& name) {
  pugi::xml_node model = xml_->root().child("Model");
  pugi::xml_attribute attribute = model.attribute("name");
  if (!attribute) attribute = model.append_attribute("name");
  attribute.set_value(osim::component_name(name).c_str());
  model_.name = attribute.value();
}

void OsimDocument::merge_markers(const std::filesystem::path& marker_set) {
  const XmlFile xml(marker_set);
  const std::vector<NewMarker> markers = read_marker_set(xml, model_);
  const pugi::xml_node model_node = xml_->root().child("Model");
  pugi::xml_node objects = marker_objects(model_node);
  std::set<std::string> replaced;
  for (const NewMarker& marker : markers) replaced.insert(marker.name);
  for (const pugi::xml_node node : set_members(model_node, "MarkerSet")) {
    if (replaced.contains(name_of(node))) remove_with_line(node);
  }
  for (const NewMarker& marker : markers) {
    append_marker(objects, model_.document_version, marker);
  }
  append_new_line(objects, 1);
  model_ = osim::read_document(*xml_);
}

std::vector<Warning> OsimDocument::scale(const ScaleFactors& factors, const ScaleOptions& options) {
  options.validate();
  validate(factors, model_);
  osim::DocumentScaler scaler(*xml_, factors);
  const std::vector<double> before = default_path_lengths(model_);
  scaler.scale_masses(options);
  scaler.scale_places();
  model_ = osim::read_document(*xml_);
  scaler.scale_lengths(before, default_path_lengths(model_));
  model_ = osim::read_document(*xml_);
  return scaler.warnings();
}

void OsimDocument::set_markers(const std::vector<Marker>& markers) {
  std::map<std::string, const Marker*> wanted;
  for (const Marker& marker : markers) wanted[marker.name] = &marker;
  osim::Reader reader(*xml_);
  reader.model_node = xml_->root().child("Model");
  osim::read_bodies(reader);
  osim::read_joints(reader);
  for (const pugi::xml_node node : set_members(reader.model_node, "MarkerSet")) {
    const auto found = wanted.find(name_of(node));
    if (found == wanted.end()) {
      remove_with_line(node);
      continue;
    }
    const Marker& now = model_.markers[static_cast<std::size_t>(model_.find_marker(found->first))];
    if (now.p_BM == found->second->p_BM) continue;
    const osim::FixedFrame frame =
        reader.frames.resolve(osim::frame_reference(*xml_, node, "parent_frame", "body"), "", node);
    set_location(node, frame.X_BF.inverse() * found->second->p_BM);
  }
  model_ = osim::read_document(*xml_);
}

std::string write_marker_set(const MusculoskeletalModel& model) {
  pugi::xml_document document;
  pugi::xml_node root = document.append_child("OpenSimDocument");
  root.append_attribute("Version").set_value(40000);
  pugi::xml_node objects = osim::append_set(root, "MarkerSet");
  for (const Marker& marker : model.markers) osim::append_marker(objects, model, marker);
  std::ostringstream out;
  document.save(out, "  ", pugi::format_indent);
  return out.str();
}

}  // namespace sinew
