#include <cmath>

#include "model/osim_raw_joint.h"

namespace sinew::osim {
namespace {

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

const char* joint_class_name(Joint::Kind kind) { return find_joint_class(kind)->name; }

Coordinate::Motion motion_of(const Joint& joint, std::size_t position) {
  if (joint.kind == Joint::Kind::kCustom) return custom_motion(joint, joint.coordinates[position]);
  return find_joint_class(joint.kind)->motions[position] == 'r'
             ? Coordinate::Motion::kRotational
             : Coordinate::Motion::kTranslational;
}

}  // namespace sinew::osim
