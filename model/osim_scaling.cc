#include "model/osim_scaling.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <set>
#include <string_view>

#include "data/text.h"

namespace sinew::osim {
namespace {

using Eigen::Vector3d;
using std::string_view;

bool is_one_of(string_view name, std::initializer_list<const char*> names) {
  return std::any_of(names.begin(), names.end(), [&](const char* n) { return name == n; });
}

bool is_path_point(string_view name) {
  return is_one_of(name, {"PathPoint", "ConditionalPathPoint", "MovingPathPoint", "MusclePoint",
                          "MuscleViaPoint", "MovingMusclePoint"});
}

bool is_moving_point(string_view name) {
  return name == "MovingPathPoint" || name == "MovingMusclePoint";
}

// What has a place on a body and stays there when OpenSim scales a model.
bool stays_in_place(string_view name) {
  return name.starts_with("Contact") ||
         is_one_of(name, {"PointToPointSpring", "ConstantDistanceConstraint",
                          "PointOnLineConstraint", "PointActuator", "TorqueActuator"});
}

// Puts a function into a MultiplierFunction, or its factor into the one that is there.
void multiply_function(const XmlFile& xml, pugi::xml_node function, double factor) {
  if (string_view(function.name()) == "MultiplierFunction") {
    const double scale = xml.number(function, "scale").value_or(1.0) * factor;
    pugi::xml_node node = function.child("scale");
    if (!node) node = function.append_child("scale");
    set_numbers(node, {&scale, 1});
    return;
  }
  pugi::xml_node multiplier = function.parent().insert_child_before("MultiplierFunction", function);
  // Without a wrapper the name of the function is what ties it to its property.
  if (const string_view name = function.attribute("name").value(); !name.empty()) {
    multiplier.append_attribute("name").set_value(function.attribute("name").value());
  }
  multiplier.append_child("function").append_move(function);
  set_numbers(multiplier.append_child("scale"), {&factor, 1});
}

// The function that find_function() reads.
pugi::xml_node function_node(pugi::xml_node parent, const char* wrapper) {
  const pugi::xml_node wrapped = parent.child(wrapper);
  for (const pugi::xml_node element : (wrapped ? wrapped : parent).children()) {
    if (element.type() != pugi::node_element) continue;
    if (wrapped || string_view(element.attribute("name").value()) == wrapper) return element;
  }
  return {};
}

bool is_elsewhere(const char* name) { return !is_one_of(name, {"BodySet", "JointSet", "Ground"}); }

}  // namespace

void set_text(pugi::xml_node node, const std::string& text) {
  for (pugi::xml_node child = node.first_child(); child;) {
    const pugi::xml_node next = child.next_sibling();
    if (child.type() == pugi::node_pcdata || child.type() == pugi::node_cdata) {
      node.remove_child(child);
    }
    child = next;
  }
  node.append_child(pugi::node_pcdata).set_value(text.c_str());
}

void set_numbers(pugi::xml_node node, std::span<const double> values) {
  std::string text;
  for (const double value : values) {
    text += (text.empty() ? "" : " ") + text::format_number(value);
  }
  set_text(node, text);
}

std::vector<pugi::xml_node> path_nodes(pugi::xml_node model_node) {
  std::vector<pugi::xml_node> nodes;
  for (const char* set : {"ForceSet", "ActuatorSet"}) {
    for (const pugi::xml_node node : set_members(model_node, set)) {
      if (node.child("GeometryPath") || node.child("MusclePointSet")) nodes.push_back(node);
    }
  }
  return nodes;
}

DocumentScaler::DocumentScaler(const XmlFile& xml, const ScaleFactors& factors)
    : xml_(xml), factors_(factors), reader_(xml) {
  reader_.model_node = xml.root().child("Model");
  read_bodies(reader_);
  read_joints(reader_);
  read_constraints(reader_);
  read_forces(reader_);
  mark_virtual_links(reader_.model);
}

// Ground, growing by 1, where nothing of that name is known: such an element is of no use to
// OpenSim either, and stays as it is.
int DocumentScaler::body_of(const std::string& reference, const std::string& owner,
                            pugi::xml_node node) {
  try {
    return reader_.frames.resolve(reference, owner, node).body;
  } catch (const InputError&) {
    warnings_.push_back({xml_.location(node),
                         fmt::format("<{}> '{}' refers to '{}', which the model does not have; it "
                                     "is not scaled",
                                     node.name(), name_of(node), reference)});
    return 0;
  }
}

void DocumentScaler::grow(pugi::xml_node parent, const char* name, const Vector3d& f) {
  const auto value = xml_.vector3(parent, name);
  if (!value) return;
  const Vector3d grown = value->cwiseProduct(f);
  if (grown != *value) set_numbers(parent.child(name), {grown.data(), 3});
}

void DocumentScaler::grow(pugi::xml_node parent, const char* name, double factor) {
  const auto value = xml_.number(parent, name);
  if (!value || factor == 1.0) return;
  const double grown = *value * factor;
  set_numbers(parent.child(name), {&grown, 1});
}

void DocumentScaler::scale_places() {
  for (const pugi::xml_node node : set_members(reader_.model_node, "BodySet")) {
    visit(node, name_of(node), std::max(0, reader_.model.find_body(name_of(node))));
  }
  for (const pugi::xml_node node : set_members(reader_.model_node, "JointSet")) {
    visit(node, name_of(node), 0);
  }
  for (const pugi::xml_node node : reader_.model_node.children()) {
    if (node.type() != pugi::node_element || !is_elsewhere(node.name())) continue;
    if (node.child("objects")) {
      visit_members(node);
    } else {
      visit(node, "", 0);
    }
  }
  report_unscaled();
}

// Forces, constraints, markers, …: each may have frames of its own.
void DocumentScaler::visit_members(pugi::xml_node set) {
  for (const pugi::xml_node node : set.child("objects").children()) {
    if (node.type() != pugi::node_element) continue;
    if (string_view(set.name()) == "ComponentSet") {
      visit(node, "", 0);
      continue;
    }
    reader_.frames.add_frames(name_of(node), node);
    visit(node, name_of(node), 0);
  }
}

void DocumentScaler::visit(pugi::xml_node node, const std::string& owner, int body) {
  if (node.type() != pugi::node_element) return;
  if (stays_in_place(node.name())) unscaled_[node.name()].push_back(node);
  if (scale_known(node, owner, body)) visit_children(node, owner, body);
}

void DocumentScaler::visit_children(pugi::xml_node node, const std::string& owner, int body) {
  // Functions are moved while they are scaled, so the next sibling is looked up first.
  for (pugi::xml_node child = node.first_child(); child;) {
    const pugi::xml_node next = child.next_sibling();
    visit(child, owner, body);
    child = next;
  }
}

// Scales what belongs to this element; true if its children are to be looked at, `body` being the
// one that carries them.
bool DocumentScaler::scale_known(pugi::xml_node node, const std::string& owner, int& body) {
  const string_view name = node.name();
  const string_view within = node.parent().parent().name();
  if (name == "Body") {
    grow(node, "mass_center", factors_of(body));
    grow(node.child("VisibleObject"), "scale_factors", factors_of(body));
    scale_geometry(node, factors_of(body));
  } else if (name == "PhysicalOffsetFrame") {
    body = body_of(name_of(node), owner, node);
    grow(node, "translation", factors_of(body));
    scale_geometry(node, factors_of(body));
  } else if (name.ends_with("Joint") && (within == "JointSet" || within == "Body")) {
    scale_joint(node, body);
  } else if (within == "WrapObjectSet") {
    scale_wrap_object(node, factors_of(body));
  } else if (is_path_point(name) || name == "Marker" || name == "Station") {
    const Vector3d& f =
        factors_of(body_of(frame_reference(xml_, node, "parent_frame", "body"), "", node));
    grow(node, "location", f);
    if (is_moving_point(name)) scale_moving_point(node, f);
    return false;
  } else if (name == "CoordinateCouplerConstraint") {
    scale_coupler(node);
    return false;
  } else if (node.child("location_body_1") || node.child("location_body_2")) {
    scale_two_bodies(node, owner);
  }
  return true;
}

// An old joint stands in its child; one of a JointSet is told by name and, as names may repeat, by
// where it stands.
const Joint* DocumentScaler::find_joint(pugi::xml_node node, int body) const {
  const std::vector<Joint>& joints = reader_.model.joints;
  if (body > 0) return &joints[static_cast<std::size_t>(body) - 1];
  const int named = reader_.model.find_joint(name_of(node));
  const SourceLocation at = xml_.location(node);
  if (named >= 0 && joints[static_cast<std::size_t>(named)].source == at) {
    return &joints[static_cast<std::size_t>(named)];
  }
  const auto found = std::find_if(joints.begin(), joints.end(),
                                  [&](const Joint& joint) { return joint.source == at; });
  return found == joints.end() ? nullptr : &*found;
}

void DocumentScaler::scale_joint(pugi::xml_node node, int body) {
  const Joint* joint = find_joint(node, body);
  if (joint == nullptr) return;
  const Vector3d& parent = factors_of(joint->parent);
  grow(node, "location_in_parent", parent);
  grow(node, "location", factors_of(joint->child));
  grow(node, "location_in_child", factors_of(joint->child));
  grow(node, "radii_x_y_z", parent);
  scale_shifts(node, *joint);
}

void DocumentScaler::scale_shifts(pugi::xml_node joint_node, const Joint& joint) {
  if (joint.kind != Joint::Kind::kCustom) return;
  const auto axes = transform_axes(xml_, joint_node);
  for (std::size_t i = 3; i < 6; ++i) {
    const pugi::xml_node function = axes[i] ? function_node(axes[i], "function") : pugi::xml_node();
    if (!function) continue;
    const double factor = translation_scale(joint.axes[i], factors_of(joint.parent));
    const auto* constant = std::get_if<ConstantFunction>(&joint.axes[i].function.kind);
    if (factor == 1.0 || (constant != nullptr && constant->value == 0.0)) continue;
    multiply_function(xml_, function, factor);
  }
}

void DocumentScaler::scale_moving_point(pugi::xml_node node, const Vector3d& f) {
  static constexpr std::array<const char*, 3> kLocations = {"x_location", "y_location",
                                                            "z_location"};
  for (std::size_t i = 0; i < 3; ++i) {
    const pugi::xml_node function = function_node(node, kLocations[i]);
    const double factor = f[static_cast<Eigen::Index>(i)];
    if (function && factor != 1.0) multiply_function(xml_, function, factor);
  }
}

void DocumentScaler::scale_coupler(pugi::xml_node node) {
  const std::string name = xml_.text(node, "dependent_coordinate_name");
  const int c = reader_.model.find_coordinate(name.substr(name.find_last_of('/') + 1));
  if (c < 0) return;
  const Coordinate& dependent = reader_.model.coordinates[static_cast<std::size_t>(c)];
  if (dependent.motion != Coordinate::Motion::kTranslational) return;
  const Joint& joint = reader_.model.joints[static_cast<std::size_t>(dependent.joint)];
  if (!node.child("scale_factor")) node.append_child("scale_factor").text().set(1);
  grow(node, "scale_factor", coupler_scale(joint, c, factors_of(joint.parent)));
}

// Points of constraints, and frames of bushings and welds before version 4.
void DocumentScaler::scale_two_bodies(pugi::xml_node node, const std::string& owner) {
  for (const char* number : {"1", "2"}) {
    const std::string location = fmt::format("location_body_{}", number);
    const std::string body = fmt::format("body_{}", number);
    std::string reference = frame_reference(xml_, node, body.c_str(), body.c_str());
    if (reference.empty()) {
      const std::string frame = fmt::format("frame{}", number);
      reference = frame_reference(xml_, node, frame.c_str(), frame.c_str());
    }
    if (!reference.empty()) {
      grow(node, location.c_str(), factors_of(body_of(reference, owner, node)));
    }
  }
}

// OpenSim's rules: places by the body's factors, sizes by how long the object's own axes become.
void DocumentScaler::scale_wrap_object(pugi::xml_node node, const Vector3d& f) {
  grow(node, "translation", f);
  const Eigen::Matrix3d R =
      rotation_from_body_xyz(xml_.vector3(node, "xyz_body_rotation").value_or(Vector3d::Zero()));
  Vector3d growth;  // of the object's axes
  for (int i = 0; i < 3; ++i) growth[i] = R.col(i).cwiseProduct(f).norm();
  const double across = 0.5 * (growth.x() + growth.y());
  const string_view name = node.name();
  if (name == "WrapSphere") {
    grow(node, "radius", f.mean());
  } else if (name == "WrapCylinder") {
    grow(node, "radius", across);
    grow(node, "length", growth.z());
  } else if (name == "WrapEllipsoid") {
    grow(node, "dimensions", growth);
  } else if (name == "WrapTorus") {
    grow(node, "inner_radius", across);
    grow(node, "outer_radius", across);
  } else {
    unscaled_[node.name()].push_back(node);
  }
}

void DocumentScaler::scale_geometry(pugi::xml_node frame, const Vector3d& f) {
  for (const pugi::xml_node geometry : frame.child("attached_geometry").children()) {
    grow(geometry, "scale_factors", f);
  }
}

void DocumentScaler::scale_masses(const ScaleOptions& options) {
  struct Entry {
    pugi::xml_node node;
    BodyInertia inertia;
  };
  std::vector<Entry> entries;
  double total = 0.0;
  for (const pugi::xml_node node : set_members(reader_.model_node, "BodySet")) {
    const int b = reader_.model.find_body(name_of(node));
    if (b <= 0 || reader_.model.bodies[static_cast<std::size_t>(b)].virtual_link) continue;
    const std::array<double, 6> c = read_inertia_components(xml_, node);
    BodyInertia inertia{xml_.number(node, "mass").value_or(0.0), {}};
    inertia.I_BCm << c[0], c[3], c[4], c[3], c[1], c[5], c[4], c[5], c[2];
    entries.push_back(
        {node, scale_inertia(inertia, factors_of(b), !options.preserve_mass_distribution)});
    total += entries.back().inertia.mass;
  }
  const double ratio = options.mass ? mass_ratio(total, *options.mass, xml_.path()) : 1.0;
  for (Entry& entry : entries) {
    const double mass = entry.inertia.mass * ratio;
    const Eigen::Matrix3d I = entry.inertia.I_BCm * ratio;
    const std::array<double, 6> c = {I(0, 0), I(1, 1), I(2, 2), I(0, 1), I(0, 2), I(1, 2)};
    if (pugi::xml_node node = entry.node.child("mass")) set_numbers(node, {&mass, 1});
    if (pugi::xml_node node = entry.node.child("inertia")) {
      set_numbers(node, c);
      continue;
    }
    for (std::size_t i = 0; i < 6; ++i) {
      if (pugi::xml_node node = entry.node.child(kOldInertia[i])) set_numbers(node, {&c[i], 1});
    }
  }
}

void DocumentScaler::scale_lengths(std::span<const double> before, std::span<const double> after) {
  const std::vector<pugi::xml_node> nodes = path_nodes(reader_.model_node);
  std::size_t wrapped = 0;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    if (!(before[i] > 0.0)) continue;
    const PathElement& path = reader_.model.paths[i];
    for (const char* length :
         {"optimal_fiber_length", "tendon_slack_length", "resting_length", "slack_length"}) {
      grow(nodes[i], length, after[i] / before[i]);
    }
    if (!path.wrap_objects.empty() && path.kind != PathElement::Kind::kActuator) ++wrapped;
  }
  if (wrapped == 0) return;
  warnings_.push_back(
      {{xml_.path(), 0},
       fmt::format("{} paths run over wrap objects; their fibre, tendon and resting lengths grow "
                   "with the straight path in the default pose",
                   wrapped)});
}

void DocumentScaler::report_unscaled() {
  for (const auto& [name, nodes] : unscaled_) {
    warnings_.push_back(
        {xml_.location(nodes[0]),
         fmt::format("{} <{}> stay as they are: OpenSim does not scale them either (first: '{}')",
                     nodes.size(), name, name_of(nodes[0]))});
  }
}

}  // namespace sinew::osim
