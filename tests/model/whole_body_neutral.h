#pragma once

#include <string>

#include "model/kinematic_tree.h"
#include "model/whole_body.h"

namespace sinew {

/// A whole body with all coordinates at their defaults.
struct Neutral {
  explicit Neutral(const WholeBodyOptions& options)
      : model(whole_body(options)), tree(compile_tree(model)), ws(tree) {
    update_poses(tree, ws);
  }
  MusculoskeletalModel model;
  KinematicTree tree;
  KinematicWorkspace ws;
};

/// Where a body is.
inline RigidTransform pose(const MusculoskeletalModel& model, const KinematicWorkspace& ws,
                           const std::string& body) {
  return ws.X_WB[static_cast<std::size_t>(model.find_body(body))];
}

}  // namespace sinew
