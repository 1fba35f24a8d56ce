#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <string_view>

#include "model/osim_raw_joint.h"

namespace sinew::osim {
namespace {

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
