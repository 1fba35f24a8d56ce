#include <fmt/format.h>

#include <map>
#include <set>

#include "model/osim_raw_joint.h"

namespace sinew::osim {
namespace {

RigidTransform old_frame(const XmlFile& xml, pugi::xml_node node, const char* location,
                         const char* orientation) {
  RigidTransform X;
  X.p = xml.vector3(node, location).value_or(Eigen::Vector3d::Zero());
  X.R = rotation_from_body_xyz(xml.vector3(node, orientation).value_or(Eigen::Vector3d::Zero()));
  return X;
}

RawJoint start_joint(Reader& reader, pugi::xml_node node, const std::string& fallback_name) {
  const JointClass* joint_class = find_joint_class(node.name());
  if (joint_class == nullptr) {
    reader.xml.fail(node,
                    {fmt::format("<{}> is a kind of joint that is not supported", node.name()),
                     "WeldJoint, PinJoint, SliderJoint, UniversalJoint, BallJoint, "
                     "GimbalJoint, PlanarJoint, FreeJoint, EllipsoidJoint or CustomJoint",
                     "", "Rewrite it as a CustomJoint."});
  }
  RawJoint raw;
  raw.node = node;
  raw.joint.kind = joint_class->kind;
  raw.joint.name = name_of(node).empty() ? fallback_name : name_of(node);
  raw.joint.source = reader.xml.location(node);
  if (reader.xml.boolean(node, "reverse").value_or(false)) {
    reader.xml.fail(node, {fmt::format("joint '{}' is reversed", raw.joint.name), "<reverse> false",
                           "true", "Swap its parent and child."});
  }
  return raw;
}

// Version 3 and older: the joint stands in its child body and names its parent.
RawJoint read_nested_joint(Reader& reader, pugi::xml_node node, const std::string& body_name,
                           int child) {
  RawJoint raw = start_joint(reader, node, body_name);
  const std::string parent = reader.xml.text(node, "parent_body");
  if (parent.empty()) {
    reader.xml.fail(node, {fmt::format("joint '{}' names no parent", raw.joint.name),
                           "<parent_body> with a body's name", "",
                           "Name the body that the joint hangs on, or ground."});
  }
  const FixedFrame frame = reader.frames.resolve(parent, "", node);
  raw.joint.parent = frame.body;
  raw.joint.child = child;
  raw.joint.X_PF =
      frame.X_BF * old_frame(reader.xml, node, "location_in_parent", "orientation_in_parent");
  const bool renamed = node.child("location_in_child") || node.child("orientation_in_child");
  raw.joint.X_BM = old_frame(reader.xml, node, renamed ? "location_in_child" : "location",
                             renamed ? "orientation_in_child" : "orientation");
  return raw;
}

// Version 4: the joint stands in the JointSet and refers to two frames, often its own.
RawJoint read_socket_joint(Reader& reader, pugi::xml_node node) {
  RawJoint raw = start_joint(reader, node, "");
  reader.frames.add_frames(raw.joint.name, node);
  const auto frame = [&](const char* socket, const char* old_socket, const char* old_location,
                         const char* old_orientation, int& body) {
    std::string reference = frame_reference(reader.xml, node, socket, socket);
    if (reference.empty()) reference = frame_reference(reader.xml, node, old_socket, old_socket);
    if (reference.empty()) {
      reader.xml.fail(node, {fmt::format("joint '{}' names no {}", raw.joint.name, socket),
                             fmt::format("<socket_{}> with a body or frame", socket), "",
                             "Name the body that the joint connects there."});
    }
    const FixedFrame found = reader.frames.resolve(reference, raw.joint.name, node);
    body = found.body;
    return found.X_BF * old_frame(reader.xml, node, old_location, old_orientation);
  };
  raw.joint.X_PF = frame("parent_frame", "parent_body", "location_in_parent",
                         "orientation_in_parent", raw.joint.parent);
  raw.joint.X_BM = frame("child_frame", "child_body", "location_in_child", "orientation_in_child",
                         raw.joint.child);
  return raw;
}

std::vector<RawJoint> collect_joints(Reader& reader) {
  std::vector<RawJoint> joints;
  int body = 0;
  for (const pugi::xml_node node : set_members(reader.model_node, "BodySet")) {
    if (name_of(node) == "ground") continue;
    ++body;
    for (const pugi::xml_node joint : node.child("Joint").children()) {
      if (joint.type() != pugi::node_element) continue;
      joints.push_back(read_nested_joint(reader, joint, name_of(node), body));
    }
  }
  for (const pugi::xml_node node : set_members(reader.model_node, "JointSet")) {
    joints.push_back(read_socket_joint(reader, node));
  }
  return joints;
}

// Puts bodies after their parents, keeping the file's order of joints otherwise.
// Throws for a body carried by two joints, or by joints that never reach ground.
std::vector<RawJoint> sort_outward(Reader& reader, std::vector<RawJoint> raw) {
  const auto body_name = [&](int b) {
    return reader.model.bodies[static_cast<std::size_t>(b)].name;
  };
  std::map<int, const RawJoint*> carrier;
  for (const RawJoint& r : raw) {
    if (r.joint.child == 0) {
      reader.xml.fail(r.node, {fmt::format("joint '{}' has ground as its child", r.joint.name),
                               "a child that moves", "", "Swap its parent and child."});
    }
    const auto [other, fresh] = carrier.emplace(r.joint.child, &r);
    if (!fresh) {
      reader.xml.fail(
          r.node, {fmt::format("body '{}' is the child of two joints, '{}' and '{}'",
                               body_name(r.joint.child), other->second->joint.name, r.joint.name),
                   "one joint a body", "",
                   "Close the loop with a WeldConstraint or PointConstraint instead, or "
                   "swap parent and child of one of them."});
    }
  }
  std::vector<RawJoint> sorted;
  std::set<int> placed = {0};
  std::vector<bool> done(raw.size(), false);
  for (bool progress = true; progress;) {
    progress = false;
    for (std::size_t i = 0; i < raw.size(); ++i) {
      if (done[i] || !placed.contains(raw[i].joint.parent)) continue;
      placed.insert(raw[i].joint.child);
      sorted.push_back(raw[i]);
      done[i] = progress = true;
    }
  }
  for (std::size_t i = 0; i < raw.size(); ++i) {
    if (done[i]) continue;
    // Walk towards the root to say what is wrong: a circle, or a chain that ends in the air.
    std::string chain = body_name(raw[i].joint.child);
    std::set<int> seen;
    for (int b = raw[i].joint.parent; carrier.contains(b) && seen.insert(b).second;
         b = carrier.at(b)->joint.parent) {
      chain += " <- " + body_name(b);
    }
    reader.xml.fail(raw[i].node, {fmt::format("the joints of '{}' never reach ground ({})",
                                              body_name(raw[i].joint.child), chain),
                                  "a chain of joints that starts at ground, without a circle", "",
                                  "Correct a parent."});
  }
  return sorted;
}

// A body that no joint carries floats, as in OpenSim.
void add_free_joints(Reader& reader, std::vector<RawJoint>& joints) {
  std::set<int> carried;
  for (const RawJoint& r : joints) carried.insert(r.joint.child);
  for (std::size_t b = 1; b < reader.model.bodies.size(); ++b) {
    if (carried.contains(static_cast<int>(b))) continue;
    const Body& body = reader.model.bodies[b];
    RawJoint raw;
    raw.joint.name = body.name + "_to_ground";
    raw.joint.kind = Joint::Kind::kFree;
    raw.joint.child = static_cast<int>(b);
    raw.joint.source = body.source;
    joints.insert(joints.begin(), raw);
    reader.model.warnings.push_back(
        {body.source,
         fmt::format("no joint carries body '{}'; it is left free in ground", body.name)});
  }
}

// Nothing but reports refer to joints by name, so two of
// one name need not stop anyone.
void rename_repeated(Reader& reader, Joint& joint, std::set<std::string>& names) {
  if (names.insert(joint.name).second) return;
  const std::string repeated = joint.name;
  for (int i = 2; !names.insert(joint.name).second; ++i) {
    joint.name = fmt::format("{}_{}", repeated, i);
  }
  reader.model.warnings.push_back({joint.source, fmt::format("another joint is called '{}' too; "
                                                             "this one is called '{}' here",
                                                             repeated, joint.name)});
}

}  // namespace

void read_joints(Reader& reader) {
  std::vector<RawJoint> joints = collect_joints(reader);
  add_free_joints(reader, joints);
  joints = sort_outward(reader, std::move(joints));

  // From here on bodies stand in the order of their
  // joints; frames follow.
  std::vector<Body> sorted_bodies = {reader.model.bodies[0]};
  std::map<int, int> new_index = {{0, 0}};
  for (const RawJoint& raw : joints) {
    new_index[raw.joint.child] = static_cast<int>(sorted_bodies.size());
    sorted_bodies.push_back(reader.model.bodies[static_cast<std::size_t>(raw.joint.child)]);
  }
  reader.model.bodies = std::move(sorted_bodies);
  for (std::size_t b = 0; b < reader.model.bodies.size(); ++b) {
    reader.frames.set_body(reader.model.bodies[b].name, static_cast<int>(b));
  }
  std::set<std::string> names;
  for (RawJoint& raw : joints) {
    rename_repeated(reader, raw.joint, names);
    raw.joint.parent = new_index.at(raw.joint.parent);
    raw.joint.child = new_index.at(raw.joint.child);
    read_joint_coordinates(reader, raw);
    reader.model.joints.push_back(raw.joint);
  }
}

}  // namespace sinew::osim
