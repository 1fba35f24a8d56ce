#pragma once

#include <string_view>

#include "model/osim_reader.h"

namespace sinew::osim {

/// What the name of a joint's element says.
struct JointClass {
  const char* name;
  Joint::Kind kind;
  int coordinate_count;  // −1: as many as its SpatialTransform uses
  const char* motions;   // r or t for each coordinate
};

/// Null for a kind that is not supported.
const JointClass* find_joint_class(std::string_view name);
const JointClass* find_joint_class(Joint::Kind kind);

/// A joint as it stands in the file, before bodies are put in order.
struct RawJoint {
  pugi::xml_node node;
  Joint joint;  // parent and child are indices into the file's order of bodies
};

/// Reads a joint's coordinates into the model and its axes into the joint. Throws InputError for
/// more coordinates than the kind of joint has, axes without direction or parallel ones, and radii
/// that are not positive.
void read_joint_coordinates(Reader& reader, RawJoint& raw);

}  // namespace sinew::osim
