#pragma once

#include <random>

#include "ik/tracking.h"
#include "model/whole_body.h"

namespace sinew {

/// The detailed whole body with all its markers, wires and virtual links, and poses of it.
struct WholeBodyProblem {
  MusculoskeletalModel model = whole_body();
  KinematicTree tree = compile_tree(model);
  TrackingProblem tracking = bind();

  // Every unknown off its default by up to `size`, within its bounds.
  KinematicWorkspace workspace(unsigned seed, double size) const {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> off(-size, size);
    std::vector<double> step(static_cast<std::size_t>(tree.unknown_count()));
    for (double& each : step) each = off(random);
    KinematicWorkspace ws(tree);
    advance(tree, tree.default_q, step, ws.q);
    update_kinematics(tree, ws);
    return ws;
  }

  // Markers where such a pose has them, links and coordinates where the model has them.
  IkTargets targets_at(unsigned seed, double size) const {
    IkTargets targets(tracking.problem);
    set_targets(tracking, markers_of(workspace(seed, size)), 0, targets);
    return targets;
  }

 private:
  MarkerTrajectories markers_of(const KinematicWorkspace& ws) const {
    MarkerTrajectories markers;
    markers.rate = 100.0;
    markers.time = Eigen::VectorXd::Zero(1);
    markers.p_WM.resize(1, static_cast<Eigen::Index>(3 * model.markers.size()));
    for (std::size_t i = 0; i < model.markers.size(); ++i) {
      const Marker& marker = model.markers[i];
      markers.names.push_back(marker.name);
      markers.p_WM.block<1, 3>(0, static_cast<Eigen::Index>(3 * i)) =
          (ws.X_WB[static_cast<std::size_t>(marker.body)] * marker.p_BM).transpose();
    }
    return markers;
  }
  TrackingProblem bind() const {
    KinematicWorkspace ws(tree);
    update_kinematics(tree, ws);
    return bind_recording(model, tree, {"pose", markers_of(ws), {}}, nullptr, nullptr);
  }
};

}  // namespace sinew
