#pragma once

#include "model/musculoskeletal_model.h"

namespace sinew {

/// A pendulum on a pendulum: both turn about ground's z axis, bodies hang along −y at angle zero.
/// Body `upper` turns about ground's origin, `lower` about the point (0, −0.4, 0) of `upper`.
inline MusculoskeletalModel two_link_model() {
  MusculoskeletalModel model;
  model.name = "two links";
  model.bodies.resize(3);
  model.bodies[0].name = "ground";
  model.bodies[1].name = "upper";
  model.bodies[2].name = "lower";
  for (int b = 1; b <= 2; ++b) {
    const std::string name = b == 1 ? "shoulder" : "elbow";
    Body& body = model.bodies[static_cast<std::size_t>(b)];
    body.mass = b == 1 ? 2.0 : 1.5;
    body.p_BCm = {0.0, -0.2, 0.0};
    body.I_BCm = Eigen::Vector3d(0.03, 0.004, 0.031).asDiagonal();
    Joint joint;
    joint.name = name;
    joint.kind = Joint::Kind::kPin;
    joint.parent = b - 1;
    joint.child = b;
    joint.X_PF.p = {0.0, b == 1 ? 0.0 : -0.4, 0.0};
    joint.coordinates = {b - 1};
    model.joints.push_back(joint);
    Coordinate coordinate;
    coordinate.name = name + "_angle";
    coordinate.joint = b - 1;
    coordinate.range_min = -1.0;
    coordinate.range_max = 2.5;
    coordinate.default_value = b == 1 ? 0.0 : 0.25;
    model.coordinates.push_back(coordinate);
  }
  validate(model);
  return model;
}

}  // namespace sinew
