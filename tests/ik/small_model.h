#pragma once

#include <string>

#include "model/musculoskeletal_model.h"

namespace sinew {

inline MusculoskeletalModel empty_model() {
  MusculoskeletalModel model;
  model.name = "small";
  model.bodies.emplace_back();
  model.bodies[0].name = "ground";
  return model;
}

/// Adds body<b> on a joint whose coordinates are called q<c>, and returns b. motions: a letter for
/// every coordinate, r or t.
inline int add_body(MusculoskeletalModel& model, int parent, Joint::Kind kind,
                    const std::string& motions, const Eigen::Vector3d& p_PF = {0, 0, 0}) {
  const int b = static_cast<int>(model.bodies.size());
  model.bodies.emplace_back();
  model.bodies.back().name = "body" + std::to_string(b);
  Joint& joint = model.joints.emplace_back();
  joint.name = "joint" + std::to_string(b);
  joint.kind = kind;
  joint.parent = parent;
  joint.child = b;
  joint.X_PF.p = p_PF;
  for (const char motion : motions) {
    joint.coordinates.push_back(static_cast<int>(model.coordinates.size()));
    Coordinate& c = model.coordinates.emplace_back();
    c.name = "q" + std::to_string(joint.coordinates.back());
    c.joint = b - 1;
    c.motion = motion == 'r' ? Coordinate::Motion::kRotational : Coordinate::Motion::kTranslational;
  }
  return b;
}

inline void clamp(Coordinate& coordinate, double range_min, double range_max) {
  coordinate.clamped = true;
  coordinate.range_min = range_min;
  coordinate.range_max = range_max;
}

}  // namespace sinew
