#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <set>
#include <string_view>

#include "model/osim_reader.h"

namespace sinew::osim {
namespace {

struct JointClass {
  const char* name;
  Joint::Kind kind;
  int coordinate_count;  // −1: as many as its SpatialTransform uses
  const char* motions;   // r or t for each coordinate
};

constexpr JointClass kJointClasses[] = {
    {"WeldJoint", Joint::Kind::kWeld, 0, ""},
    {"PinJoint", Joint::Kind::kPin, 1, "r"},
    {"SliderJoint", Joint::Kind::kSlider, 1, "t"},
    {"UniversalJoint", Joint::Kind::kUniversal, 2, "rr"},
    {"BallJoint", Joint::Kind::kBall, 3, "rrr"},
    {"GimbalJoint", Joint::Kind::kGimbal, 3, "rrr"},
    {"PlanarJoint", Joint::Kind::kPlanar, 3, "rtt"},
    {"FreeJoint", Joint::Kind::kFree, 6, "rrrttt"},
    {"EllipsoidJoint", Joint::Kind::kEllipsoid, 3, "rrr"},
    {"CustomJoint", Joint::Kind::kCustom, -1, ""},
};

// A joint as it stands in the file, before bodies are put in order.
struct RawJoint {
  pugi::xml_node node;
  Joint joint;  // parent and child are indices into the file's order of bodies
};

const JointClass* find_joint_class(std::string_view name) {
  for (const JointClass& c : kJointClasses) {
    if (name == c.name) return &c;
  }
  return nullptr;
}

const JointClass* find_joint_class(Joint::Kind kind) {
  for (const JointClass& c : kJointClasses) {
    if (c.kind == kind) return &c;
  }
  return nullptr;
}

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

Coordinate read_coordinate(Reader& reader, pugi::xml_node node) {
  const XmlFile& xml = reader.xml;
  Coordinate c;
  c.name = name_of(node);
  c.source = xml.location(node);
  c.default_value = xml.number(node, "default_value").value_or(0.0);
  c.default_speed = xml.number(node, "default_speed_value").value_or(0.0);
  if (!std::isfinite(c.default_value)) {
    xml.fail(node.child("default_value"),
             {fmt::format("coordinate '{}' has an unusable default", c.name), "a finite number",
              xml.text(node, "default_value"), "Correct the value."});
  }
  c.clamped = xml.boolean(node, "clamped").value_or(false);
  c.locked = xml.boolean(node, "locked").value_or(false);
  if (const pugi::xml_node range = node.child("range")) {
    const std::vector<double> values = xml.numbers(range);
    if (values.size() != 2 || !(values[0] <= values[1])) {
      xml.fail(range, {fmt::format("the range of coordinate '{}' is unusable", c.name),
                       "two numbers, the lower first", xml.text(range), "Correct the range."});
    }
    c.range_min = values[0];
    c.range_max = values[1];
  }
  if (xml.boolean(node, "prescribed").value_or(false)) {
    c.prescribed = find_function(xml, node, "prescribed_function");
    if (!c.prescribed) {
      reader.warn(node, fmt::format("coordinate '{}' is prescribed but has no function; it is left "
                                    "free, as in OpenSim",
                                    c.name));
    }
  }
  return c;
}

Coordinate::Motion custom_motion(const Joint& joint, int coordinate) {
  bool used = false;
  Coordinate::Motion motion = Coordinate::Motion::kCoupled;
  for (std::size_t i = 0; i < 6; ++i) {
    if (joint.axes[i].coordinate != coordinate) continue;
    used = true;
    const auto* linear = std::get_if<LinearFunction>(&joint.axes[i].function.kind);
    if (linear == nullptr) continue;
    if (std::abs(linear->slope * joint.axes[i].function.scale) == 1.0) {
      motion = i < 3 ? Coordinate::Motion::kRotational : Coordinate::Motion::kTranslational;
    }
  }
  return used ? motion : Coordinate::Motion::kRotational;
}

}  // namespace

std::array<pugi::xml_node, 6> transform_axes(const XmlFile& xml, pugi::xml_node joint) {
  static constexpr const char* kNames[] = {"rotation1",    "rotation2",    "rotation3",
                                           "translation1", "translation2", "translation3"};
  std::array<pugi::xml_node, 6> axes;
  const pugi::xml_node transform = joint.child("SpatialTransform");
  if (transform) {
    int position = 0;
    for (const pugi::xml_node axis : transform.children("TransformAxis")) {
      const std::string name = name_of(axis);
      const auto* named = std::find(std::begin(kNames), std::end(kNames), name);
      const auto slot = named != std::end(kNames) ? named - std::begin(kNames) : position;
      if (slot < 6) axes[static_cast<std::size_t>(slot)] = axis;
      ++position;
    }
    return axes;
  }
  // Before version 10901: a list of axes, each saying whether it turns.
  std::size_t next_rotation = 0, next_translation = 3;
  for (const pugi::xml_node axis : set_members(joint, "TransformAxisSet")) {
    std::size_t& next =
        xml.boolean(axis, "is_rotation").value_or(false) ? next_rotation : next_translation;
    if (next_rotation > 3 || next_translation > 6) {
      xml.fail(axis, {"more than three axes of a kind in one joint", "3 at most", "",
                      "Split the joint in two with a massless body between."});
    }
    axes[next] = axis;
    ++next;
  }
  return axes;
}

namespace {

void read_axis(Reader& reader, Joint& joint, std::size_t slot, pugi::xml_node node,
               const std::function<int(const std::string&)>& coordinate_named) {
  TransformAxis& axis = joint.axes[slot];
  axis.axis = reader.xml.vector3(node, "axis").value_or(Eigen::Vector3d::Unit(slot % 3));
  if (!axis.axis.allFinite() || axis.axis.norm() == 0.0) {
    reader.xml.fail(node, {fmt::format("an axis of joint '{}' has no direction", joint.name),
                           "a vector that is not zero", reader.xml.text(node, "axis"),
                           "Give the axis a direction."});
  }
  std::vector<std::string> names = reader.xml.words(node, "coordinates");
  if (names.empty()) names = reader.xml.words(node, "coordinate");
  if (names.size() > 1) {
    reader.xml.fail(node, {fmt::format("an axis of joint '{}' depends on {} coordinates",
                                       joint.name, names.size()),
                           "at most one", reader.xml.text(node, "coordinates"),
                           "Functions of several coordinates are not supported."});
  }
  if (!names.empty()) axis.coordinate = coordinate_named(names[0]);
  const std::optional<ScalarFunction> function = find_function(reader.xml, node, "function");
  axis.function = function.value_or(ScalarFunction{ConstantFunction{}});
  if (!function && axis.coordinate >= 0) {
    reader.warn(node,
                fmt::format("an axis of joint '{}' names coordinate '{}' but no function; the "
                            "coordinate does not move it, as in OpenSim 4",
                            joint.name, names[0]));
  }
}

bool collinear_axes(const TransformAxis& a, const TransformAxis& b) {
  constexpr double kCollinear = 1e-5;  // OpenSim's own bound
  return a.axis.normalized().cross(b.axis.normalized()).norm() < kCollinear;
}

// An axis that the file leaves out moves nothing, but
// Simbody wants it independent of the others.
void choose_free_axis(Joint& joint, const std::array<pugi::xml_node, 6>& axes, std::size_t slot) {
  const std::size_t first = slot < 3 ? 0 : 3;
  for (std::size_t k = 0; k < 3; ++k) {
    TransformAxis& axis = joint.axes[slot];
    axis.axis = Eigen::Vector3d::Unit(static_cast<Eigen::Index>((slot + k) % 3));
    bool independent = true;
    for (std::size_t other = first; other < first + 3; ++other) {
      const bool taken = other < slot || axes[other];
      if (other != slot && taken && collinear_axes(axis, joint.axes[other])) independent = false;
    }
    if (independent) return;
  }
}

void require_at_most_six(Reader& reader, const RawJoint& raw) {
  if (raw.joint.coordinates.size() <= 6) return;
  reader.xml.fail(raw.node, {fmt::format("joint '{}' has too many coordinates", raw.joint.name),
                             "6 at most", std::to_string(raw.joint.coordinates.size()),
                             "Split the joint in two with a massless body "
                             "between."});
}

void require_independent_axes(Reader& reader, const RawJoint& raw) {
  for (const std::size_t first : {0u, 3u}) {
    const auto& a = raw.joint.axes;
    const auto collinear = [&](std::size_t i, std::size_t j) {
      return collinear_axes(a[first + i], a[first + j]);
    };
    if (collinear(0, 1) || collinear(0, 2) || collinear(1, 2)) {
      reader.xml.fail(raw.node,
                      {fmt::format("two {} axes of joint '{}' are parallel",
                                   first == 0 ? "rotation" : "translation", raw.joint.name),
                       "three axes in different directions", "", "Correct an axis."});
    }
  }
}

// OpenSim 4 tells coordinates of one name in different
// joints apart by their paths.
void make_unique(Reader& reader, const Joint& joint, Coordinate& c) {
  if (reader.model.find_coordinate(c.name) < 0) return;
  const std::string qualified = joint.name + "/" + c.name;
  reader.model.warnings.push_back({c.source, fmt::format("another joint has a coordinate called "
                                                         "'{}' too; this one is called "
                                                         "'{}' here and in results",
                                                         c.name, qualified)});
  c.name = qualified;
}

// Adds coordinates to the model and to one joint, and
// finds them by the names of the file.
class JointCoordinates {
 public:
  JointCoordinates(Reader& reader, RawJoint& raw) : reader_(reader), raw_(raw) {}

  void add(Coordinate c) {
    MusculoskeletalModel& model = reader_.model;
    const int index = static_cast<int>(model.coordinates.size());
    c.joint = static_cast<int>(model.joints.size());
    if (!index_by_name_.emplace(c.name, index).second) {
      throw InputError(c.source, {fmt::format("joint '{}' has two coordinates "
                                              "called '{}'",
                                              raw_.joint.name, c.name),
                                  "unique names", "", "Rename one of them."});
    }
    make_unique(reader_, raw_.joint, c);
    raw_.joint.coordinates.push_back(index);
    model.coordinates.push_back(std::move(c));
  }

  // One that the file uses or the kind of joint has
  // without the file describing it.
  void add_implied(std::string name) {
    Coordinate implied;
    implied.name = std::move(name);
    implied.source = raw_.joint.source;
    add(std::move(implied));
  }

  int find_or_add(const std::string& name) {
    const auto found = index_by_name_.find(name);
    if (found != index_by_name_.end()) return found->second;
    add_implied(name);
    reader_.warn(raw_.node, fmt::format("joint '{}' uses coordinate '{}' "
                                        "without describing it; it "
                                        "is free and starts at zero",
                                        raw_.joint.name, name));
    return raw_.joint.coordinates.back();
  }

 private:
  Reader& reader_;
  RawJoint& raw_;
  std::map<std::string, int> index_by_name_;
};

void set_motions(Reader& reader, const Joint& joint) {
  for (std::size_t i = 0; i < joint.coordinates.size(); ++i) {
    reader.model.coordinates[static_cast<std::size_t>(joint.coordinates[i])].motion =
        motion_of(joint, i);
  }
}

void read_custom_joint(Reader& reader, RawJoint& raw, JointCoordinates& coordinates) {
  Joint& joint = raw.joint;
  const auto axes = transform_axes(reader.xml, raw.node);
  for (std::size_t i = 0; i < 6; ++i) {
    if (!axes[i]) continue;
    read_axis(reader, joint, i, axes[i],
              [&](const std::string& name) { return coordinates.find_or_add(name); });
  }
  for (std::size_t i = 0; i < 6; ++i) {
    if (!axes[i]) choose_free_axis(joint, axes, i);
  }
  require_independent_axes(reader, raw);
  require_at_most_six(reader, raw);
  set_motions(reader, joint);
}

void read_standard_joint(Reader& reader, RawJoint& raw, JointCoordinates& coordinates) {
  Joint& joint = raw.joint;
  const JointClass& joint_class = *find_joint_class(joint.kind);
  while (static_cast<int>(joint.coordinates.size()) < joint_class.coordinate_count) {
    coordinates.add_implied(fmt::format("{}_coord_{}", joint.name, joint.coordinates.size()));
  }
  if (static_cast<int>(joint.coordinates.size()) > joint_class.coordinate_count) {
    reader.xml.fail(raw.node, {fmt::format("joint '{}' has too many coordinates", joint.name),
                               std::to_string(joint_class.coordinate_count),
                               std::to_string(joint.coordinates.size()),
                               "Remove coordinates, or use a CustomJoint."});
  }
  set_motions(reader, joint);
}

void read_radii(Reader& reader, RawJoint& raw) {
  const auto radii = reader.xml.vector3(raw.node, "radii_x_y_z");
  if (!radii || !(radii->minCoeff() > 0.0) || !radii->allFinite()) {
    reader.xml.fail(raw.node,
                    {fmt::format("ellipsoid joint '{}' has unusable radii", raw.joint.name),
                     "three positive numbers in <radii_x_y_z>",
                     reader.xml.text(raw.node, "radii_x_y_z"), "Give the radii in metres."});
  }
  raw.joint.radii = *radii;
}

void read_joint_coordinates(Reader& reader, RawJoint& raw) {
  JointCoordinates coordinates(reader, raw);
  std::vector<pugi::xml_node> nodes = set_members(raw.node, "CoordinateSet");
  if (nodes.empty()) nodes = set_members(raw.node, "coordinates");
  for (const pugi::xml_node node : nodes) {
    if (std::string_view(node.name()) == "Coordinate") {
      coordinates.add(read_coordinate(reader, node));
    }
  }
  if (raw.joint.kind == Joint::Kind::kCustom) {
    read_custom_joint(reader, raw, coordinates);
  } else {
    read_standard_joint(reader, raw, coordinates);
  }
  if (raw.joint.kind == Joint::Kind::kEllipsoid) read_radii(reader, raw);
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

const char* joint_class_name(Joint::Kind kind) { return find_joint_class(kind)->name; }

Coordinate::Motion motion_of(const Joint& joint, std::size_t position) {
  if (joint.kind == Joint::Kind::kCustom) return custom_motion(joint, joint.coordinates[position]);
  return find_joint_class(joint.kind)->motions[position] == 'r'
             ? Coordinate::Motion::kRotational
             : Coordinate::Motion::kTranslational;
}

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

int coordinate_index(const Reader& reader, const std::string& reference, pugi::xml_node node) {
  // A path ends in joint/coordinate, which is also what a
  // coordinate whose name is not unique is called.
  const std::size_t slash = reference.find_last_of('/');
  const std::string name = slash == std::string::npos ? reference : reference.substr(slash + 1);
  int index = -1;
  if (slash != std::string::npos && slash > 0) {
    const std::size_t before = reference.find_last_of('/', slash - 1);
    index = reader.model.find_coordinate(
        before == std::string::npos ? reference : reference.substr(before + 1));
  }
  if (index < 0) index = reader.model.find_coordinate(name);
  if (index < 0) {
    reader.xml.fail(node, {fmt::format("<{}> '{}' refers to a coordinate "
                                       "that the model does not have",
                                       node.name(), name_of(node)),
                           "the name of a coordinate", reference, "Correct the name."});
  }
  return index;
}

}  // namespace sinew::osim
