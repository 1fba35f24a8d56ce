#pragma once

#include <Eigen/Core>
#include <array>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "data/xml_file.h"
#include "model/musculoskeletal_model.h"

/// The parts of the .osim reader, shared by its source files only. Callers use model/osim_file.h.
namespace sinew::osim {

/// A frame that elements refer to: fixed on a body.
struct FixedFrame {
  int body = 0;
  RigidTransform X_BF;
};

/// The frames of a document by name, and how references such as `/bodyset/tibia_r`,
/// `../ground_offset` or `tibia_r` find them.
class FrameTable {
 public:
  explicit FrameTable(const XmlFile& xml) : xml_(xml) {}

  void add_body(const std::string& name, int body);
  /// Gives a registered body its final index.
  void set_body(const std::string& name, int body) { by_path_.at(name).body = body; }
  /// Registers every offset and station-defined frame below `owner` (a Body, Ground, Joint,
  /// constraint or the Model), under `owner_name/frame_name`. Doing so twice changes nothing.
  void add_frames(const std::string& owner_name, pugi::xml_node owner) {
    add_frames(owner_name, owner_name, owner);
  }
  void add_station(const std::string& name, pugi::xml_node node);

  /// The frame that `reference` names, seen from the element `owner_name`; `node` is where it
  /// stands, for errors. Throws InputError where there is none or frames refer to each other in a
  /// circle.
  FixedFrame resolve(const std::string& reference, const std::string& owner_name,
                     pugi::xml_node node) const;

 private:
  struct Entry {
    std::string owner;
    std::string enclosing;  // what ".." means: the owner, or the frame that this frame stands in
    pugi::xml_node node;    // null for a body
    int body = -1;
  };
  void add_frames(const std::string& owner_name, const std::string& enclosing,
                  pugi::xml_node parent);
  const Entry* find(const std::string& reference, const std::string& owner_name) const;
  FixedFrame resolve_entry(const Entry& entry, int depth) const;
  FixedFrame resolve_reference(const std::string& reference, const std::string& owner_name,
                               pugi::xml_node node, int depth) const;
  FixedFrame resolve_station_frame(const Entry& entry, int depth) const;
  FixedFrame resolve_station(const std::string& reference, pugi::xml_node node, int depth) const;

  const XmlFile& xml_;
  std::map<std::string, Entry> by_path_;  // "owner/frame" or "body"
  std::map<std::string, std::vector<std::string>> by_last_name_;
  std::map<std::string, pugi::xml_node> stations_;
};

/// What the parts of the reader share while one document is read.
struct Reader {
  const XmlFile& xml;
  pugi::xml_node model_node;
  MusculoskeletalModel model;
  FrameTable frames;

  explicit Reader(const XmlFile& file) : xml(file), frames(file) {}
  void warn(pugi::xml_node node, std::string text);
};

/// Children of <Set><objects>, or of <Set> itself where a file leaves <objects> out.
std::vector<pugi::xml_node> set_members(pugi::xml_node parent, const char* set_name);

std::string name_of(pugi::xml_node node);

/// The function element itself (LinearFunction, SimmSpline, …). Throws InputError for an unknown
/// kind or for data that do not make a function.
ScalarFunction read_function(const XmlFile& xml, pugi::xml_node element);

/// The function that `parent` holds: in <wrapper> where it has one, else directly.
std::optional<ScalarFunction> find_function(const XmlFile& xml, pugi::xml_node parent,
                                            const char* wrapper);

/// Reads the whole model of a document.
MusculoskeletalModel read_document(const XmlFile& xml);

/// The axes of a custom joint, rotation1 to translation3; null where the file leaves one out.
std::array<pugi::xml_node, 6> transform_axes(const XmlFile& xml, pugi::xml_node joint);

/// A body's inertia before version 4, an element a component.
inline constexpr std::array<const char*, 6> kOldInertia = {
    "inertia_xx", "inertia_yy", "inertia_zz", "inertia_xy", "inertia_xz", "inertia_yz"};
/// Ixx Iyy Izz Ixy Ixz Iyz as a <Body> has them; zero where it has none.
std::array<double, 6> read_inertia_components(const XmlFile& xml, pugi::xml_node node);

void read_bodies(Reader& reader);
void read_joints(Reader& reader);
void read_constraints(Reader& reader);
void read_markers(Reader& reader);
void read_forces(Reader& reader);
/// OpenSim refuses a body without mass that carries no other, so a virtual link is written with a
/// milligram, a thousandth of the lightest bone, and the inertia of a drop of 1 cm.
constexpr double kVirtualLinkMass = 1e-6;      // [kg]
constexpr double kVirtualLinkInertia = 1e-10;  // [kg m²]

/// Makes virtual links of bodies of no more than that mass that hang on a free joint, carry no
/// other body and have a path end on them. Needs the paths.
void mark_virtual_links(MusculoskeletalModel& model);

/// What an element of this class with a path is to Sinew.
PathElement::Kind path_kind(std::string_view class_name);

/// The element that describes a joint of this kind.
const char* joint_class_name(Joint::Kind kind);

/// How the position-th coordinate of a joint counts. In a custom joint, one that turns about or
/// shifts along an axis one to one is rotational or translational, one that only drives functions
/// is coupled (OpenSim 4's rule).
Coordinate::Motion motion_of(const Joint& joint, std::size_t position);

/// Index of a coordinate by name or by path; throws InputError naming `node`.
int coordinate_index(const Reader& reader, const std::string& reference, pugi::xml_node node);

/// <socket_NEW>, <connectors>…NEW…, or <OLD>: the reference that an element makes to a frame.
std::string frame_reference(const XmlFile& xml, pugi::xml_node node, const char* socket,
                            const char* old_name);

}  // namespace sinew::osim
