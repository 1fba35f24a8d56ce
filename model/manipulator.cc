#include "model/manipulator.h"

#include <fmt/format.h>

#include <stdexcept>

namespace sinew {

double manipulator_link_length(int links) { return 1.5 / (3.0 * links - 2.0); }

MusculoskeletalModel make_manipulator(int links) {
  if (links < 1) {
    throw std::invalid_argument(
        fmt::format("a manipulator of {} links cannot be built; expected 1 or more", links));
  }
  MusculoskeletalModel model;
  model.name = fmt::format("manipulator_{}", links);
  model.bodies.emplace_back().name = "ground";
  const double length = manipulator_link_length(links);
  for (int i = 1; i <= links; ++i) {
    Body body;
    body.name = fmt::format("link_{}", i);
    body.mass = 1.0;  // [kg] any: kinematics does not depend on it, Simbody wants one
    body.I_BCm = Eigen::Matrix3d::Identity();
    model.bodies.push_back(body);
    Joint joint;
    joint.name = fmt::format("joint_{}", i);
    joint.kind = Joint::Kind::kBall;
    joint.parent = i - 1;
    joint.child = i;
    if (i > 1) joint.X_PF.p.z() = length;
    for (const char axis : {'x', 'y', 'z'}) {
      Coordinate coordinate;
      coordinate.name = fmt::format("joint_{}_{}", i, axis);
      coordinate.joint = i - 1;
      joint.coordinates.push_back(static_cast<int>(model.coordinates.size()));
      model.coordinates.push_back(coordinate);
    }
    model.joints.push_back(joint);
  }
  Marker tip;
  tip.name = "tip";
  tip.body = links;
  tip.p_BM.z() = length / 3.0;
  model.markers.push_back(tip);
  validate(model);
  return model;
}

}  // namespace sinew
