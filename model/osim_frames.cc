#include <fmt/format.h>

#include <string_view>

#include "model/osim_reader.h"

namespace sinew::osim {
namespace {

// Offset frames on offset frames: real models stack two; more than this is a circle.
constexpr int kMaxFrameDepth = 50;

std::string last_name(const std::string& path) {
  const std::size_t slash = path.find_last_of('/');
  return slash == std::string::npos ? path : path.substr(slash + 1);
}

// "…/jointset/hip_r/femur_r_offset" → "hip_r/femur_r_offset".
std::string last_two_names(const std::string& path) {
  const std::size_t last = path.find_last_of('/');
  if (last == std::string::npos || last == 0) return path;
  const std::size_t before = path.find_last_of('/', last - 1);
  return before == std::string::npos ? path : path.substr(before + 1);
}

bool is_frame(std::string_view class_name) {
  return class_name == "PhysicalOffsetFrame" || class_name == "StationDefinedFrame";
}

}  // namespace

void FrameTable::add_body(const std::string& name, int body) {
  by_path_[name] = {name, {}, {}, body};
  by_last_name_[name].push_back(name);
}

void FrameTable::add_frames(const std::string& owner_name, const std::string& enclosing,
                            pugi::xml_node parent) {
  for (const pugi::xml_node child : parent.children()) {
    const std::string_view class_name = child.name();
    if (is_frame(class_name)) {
      const std::string key = owner_name + "/" + name_of(child);
      if (!by_path_.contains(key)) by_last_name_[name_of(child)].push_back(key);
      by_path_[key] = {owner_name, enclosing, child, -1};
      add_frames(owner_name, name_of(child), child);
    } else if (class_name == "Station") {
      add_station(name_of(child), child);
    } else if (class_name == "frames" || class_name == "components" ||
               class_name == "ComponentSet" || class_name == "objects") {
      add_frames(owner_name, enclosing, child);
    }
  }
}

void FrameTable::add_station(const std::string& name, pugi::xml_node node) {
  stations_[name] = node;
}

const FrameTable::Entry* FrameTable::find(const std::string& reference,
                                          const std::string& owner_name) const {
  const auto at = [&](const std::string& key) {
    const auto found = by_path_.find(key);
    return found == by_path_.end() ? nullptr : &found->second;
  };
  const std::string last = last_name(reference);
  // A plain name is a frame of the element itself before it is a body.
  if (const Entry* own = at(owner_name + "/" + last);
      own && reference.find('/') == std::string::npos)
    return own;
  if (const Entry* two = at(last_two_names(reference)); two && two->node) return two;
  if (const Entry* body = at(last); body && body->body >= 0) return body;
  if (const Entry* own = at(owner_name + "/" + last)) return own;
  const auto named = by_last_name_.find(last);
  return named != by_last_name_.end() && named->second.size() == 1 ? at(named->second[0]) : nullptr;
}

FixedFrame FrameTable::resolve(const std::string& reference, const std::string& owner_name,
                               pugi::xml_node node) const {
  return resolve_reference(reference, owner_name, node, 0);
}

FixedFrame FrameTable::resolve_reference(const std::string& reference,
                                         const std::string& owner_name, pugi::xml_node node,
                                         int depth) const {
  const Entry* entry = find(reference, owner_name);
  if (entry == nullptr) {
    xml_.fail(node, {fmt::format("<{}> '{}' refers to a body or frame that the model does not have",
                                 node.name(), name_of(node)),
                     "the name of a body, ground or an offset frame", reference,
                     "Correct the name or add the body."});
  }
  if (depth > kMaxFrameDepth) {
    xml_.fail(node,
              {fmt::format("the frames around '{}' refer to each other in a circle", reference),
               "a chain of frames that ends at a body", "", "Correct a frame's parent."});
  }
  return resolve_entry(*entry, depth);
}

FixedFrame FrameTable::resolve_entry(const Entry& entry, int depth) const {
  if (entry.body >= 0) return {entry.body, {}};
  if (std::string_view(entry.node.name()) == "StationDefinedFrame") {
    return resolve_station_frame(entry, depth);
  }
  std::string parent = frame_reference(xml_, entry.node, "parent", "parent");
  if (parent.empty() || parent == "..") parent = entry.enclosing;
  const FixedFrame base = resolve_reference(parent, entry.owner, entry.node, depth + 1);
  RigidTransform X_PF;
  X_PF.p = xml_.vector3(entry.node, "translation").value_or(Eigen::Vector3d::Zero());
  X_PF.R = rotation_from_body_xyz(
      xml_.vector3(entry.node, "orientation").value_or(Eigen::Vector3d::Zero()));
  return {base.body, base.X_BF * X_PF};
}

FixedFrame FrameTable::resolve_station(const std::string& reference, pugi::xml_node node,
                                       int depth) const {
  const auto station = stations_.find(last_name(reference));
  if (station == stations_.end()) {
    xml_.fail(node,
              {fmt::format("'{}' refers to a station that the model does not have", name_of(node)),
               "the name of a Station", reference, "Correct the name or add the station."});
  }
  const std::string parent = frame_reference(xml_, station->second, "parent_frame", "body");
  const FixedFrame base = resolve_reference(parent, "", station->second, depth + 1);
  const Eigen::Vector3d p =
      xml_.vector3(station->second, "location").value_or(Eigen::Vector3d::Zero());
  return {base.body, {Eigen::Matrix3d::Identity(), base.X_BF * p}};
}

// Axes from three points: `ab_axis` runs from a to b, `ab_x_ac_axis` along (b − a) × (c − a), the
// third completes a right-handed frame; a leading minus reverses an axis.
FixedFrame FrameTable::resolve_station_frame(const Entry& entry, int depth) const {
  const auto station = [&](const char* socket) {
    return resolve_station(frame_reference(xml_, entry.node, socket, socket), entry.node, depth);
  };
  const FixedFrame origin = station("origin_point");
  const Eigen::Vector3d a = station("point_a").X_BF.p;
  const Eigen::Vector3d ab = station("point_b").X_BF.p - a;
  const Eigen::Vector3d normal = ab.cross(station("point_c").X_BF.p - a);
  if (!(normal.norm() > 0.0)) {
    xml_.fail(entry.node,
              {fmt::format("the points of frame '{}' lie on a line", name_of(entry.node)),
               "three points that span a plane", "", "Move a point."});
  }
  const auto axis_of = [&](const char* name, const char* standard, double& sign) {
    std::string text = xml_.text(entry.node, name);
    if (text.empty()) text = standard;
    sign = text.starts_with('-') ? -1.0 : 1.0;
    const char letter = text.back();
    if (letter < 'x' || letter > 'z') {
      xml_.fail(entry.node,
                {fmt::format("<{}> names no axis", name), "+x, +y, +z, -x, -y or -z", text, ""});
    }
    return letter - 'x';
  };
  double sign1 = 1.0, sign2 = 1.0;
  const int axis1 = axis_of("ab_axis", "+x", sign1);
  const int axis2 = axis_of("ab_x_ac_axis", "+y", sign2);
  if (axis1 == axis2) {
    xml_.fail(entry.node,
              {"<ab_axis> and <ab_x_ac_axis> are the same axis", "two different axes", "", ""});
  }
  FixedFrame frame = origin;
  frame.X_BF.R.col(axis1) = sign1 * ab.normalized();
  frame.X_BF.R.col(axis2) = sign2 * normal.normalized();
  const int axis3 = 3 - axis1 - axis2;
  frame.X_BF.R.col(axis3) =
      frame.X_BF.R.col((axis3 + 1) % 3).cross(frame.X_BF.R.col((axis3 + 2) % 3));
  return frame;
}

std::string frame_reference(const XmlFile& xml, pugi::xml_node node, const char* socket,
                            const char* old_name) {
  const std::string current = xml.text(node, fmt::format("socket_{}", socket).c_str());
  if (!current.empty()) return current;
  for (const pugi::xml_node connector : node.child("connectors").children()) {
    if (std::string_view(connector.attribute("name").value()) == socket) {
      return xml.text(connector, "connectee_name");
    }
  }
  const std::string named = xml.text(node, fmt::format("socket_{}_connectee_name", socket).c_str());
  return named.empty() ? xml.text(node, old_name) : named;
}

}  // namespace sinew::osim
