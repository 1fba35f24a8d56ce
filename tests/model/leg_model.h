#pragma once

#include <string>

#include "model/musculoskeletal_model.h"

/// A pelvis on two legs, mirror images of each other in Z: hips, knees and ankles are pins about Z,
/// thighs and shanks 0.4 m long, every body's frame parallel to the world's at zero. Four muscles a
/// leg; the gastrocnemii and the soleus end within 5 mm of each other on the heel. Small enough
/// that lengths are known in closed form.
namespace sinew {

class LegModelBuilder {
 public:
  MusculoskeletalModel build() {
    model_.name = "legs";
    model_.bodies.emplace_back();
    model_.bodies[0].name = "ground";
    add_body("pelvis", 10.0, {0, 0.05, 0}, Joint::Kind::kPlanar, 0, {0, 0.9, 0},
             {"tilt", "tx", "ty"});
    for (const std::string side : {"_r", "_l"}) add_leg(side, side == "_r" ? 1.0 : -1.0);
    for (const std::string side : {"_r", "_l"}) add_muscles(side, side == "_r" ? 1.0 : -1.0);
    validate(model_);
    return model_;
  }

 private:
  void add_body(const std::string& name, double mass, const Eigen::Vector3d& p_BCm,
                Joint::Kind kind, int parent, const Eigen::Vector3d& place,
                const std::vector<std::string>& coordinates) {
    Body body;
    body.name = name;
    body.mass = mass;
    body.p_BCm = p_BCm;
    body.I_BCm = Eigen::Vector3d(0.02, 0.01, 0.02).asDiagonal();
    model_.bodies.push_back(body);
    Joint joint;
    joint.name = name + "_joint";
    joint.kind = kind;
    joint.parent = parent;
    joint.child = static_cast<int>(model_.bodies.size()) - 1;
    joint.X_PF.p = place;
    for (std::size_t i = 0; i < coordinates.size(); ++i) {
      Coordinate c;
      c.name = coordinates[i];
      c.joint = joint.child - 1;
      c.motion = i == 0 ? Coordinate::Motion::kRotational : Coordinate::Motion::kTranslational;
      c.range_min = -1.0;
      c.range_max = 1.0;
      joint.coordinates.push_back(static_cast<int>(model_.coordinates.size()));
      model_.coordinates.push_back(c);
    }
    model_.joints.push_back(joint);
  }

  void add_marker(const std::string& name, const std::string& body, const Eigen::Vector3d& p_BM) {
    model_.markers.push_back({name, model_.find_body(body), p_BM, false, {}});
  }

  void add_leg(const std::string& side, double z) {
    const auto pin = Joint::Kind::kPin;
    add_body("femur" + side, 5.0, {0, -0.2, 0}, pin, 1, {0, 0, 0.1 * z}, {"hip" + side});
    const int femur = model_.find_body("femur" + side);
    add_body("tibia" + side, 3.0, {0, -0.2, 0}, pin, femur, {0, -0.4, 0}, {"knee" + side});
    const int tibia = model_.find_body("tibia" + side);
    add_body("calcn" + side, 1.0, {0.05, -0.02, 0}, pin, tibia, {0, -0.4, 0}, {"ankle" + side});
    const std::string letter = z > 0 ? "R" : "L";
    add_marker(letter + "KNE", "femur" + side, {0, -0.4, 0.05 * z});
    add_marker(letter + "HEE", "calcn" + side, {-0.06, -0.03, 0});
  }

  PathPoint point(const std::string& body, const Eigen::Vector3d& p_BP) const {
    PathPoint point;
    point.body = model_.find_body(body);
    point.p_BP = p_BP;
    return point;
  }

  // Slack by a tenth at the given neutral length.
  void add_muscle(const std::string& name, double force, double length,
                  std::vector<PathPoint> points) {
    PathElement muscle;
    muscle.name = name;
    muscle.class_name = "Millard2012EquilibriumMuscle";
    muscle.points = std::move(points);
    for (std::size_t i = 0; i < muscle.points.size(); ++i) {
      muscle.points[i].name = name + "-P" + std::to_string(i + 1);
    }
    muscle.max_isometric_force = force;
    muscle.optimal_fiber_length = 0.2 * length;
    muscle.tendon_slack_length = 0.8 * length;
    muscle.pennation_angle = 0.1;
    muscle.natural_length = muscle_natural_length(muscle);
    model_.paths.push_back(muscle);
  }

  void add_muscles(const std::string& side, double z) {
    const std::string femur = "femur" + side, tibia = "tibia" + side, calcn = "calcn" + side;
    add_muscle("flexor" + side, 1000.0, 0.23,
               {point("pelvis", {0.1, 0, 0.1 * z}), point(femur, {0, -0.2, 0})});
    add_muscle("gas_med" + side, 1500.0, 0.44,
               {point(femur, {-0.02, -0.39, -0.02 * z}), point(calcn, {-0.05, -0.03, -0.002 * z})});
    add_muscle("gas_lat" + side, 700.0, 0.44,
               {point(femur, {-0.02, -0.39, 0.02 * z}), point(calcn, {-0.05, -0.03, 0.002 * z})});
    add_muscle("soleus" + side, 3500.0, 0.33,
               {point(tibia, {-0.02, -0.1, 0}), point(calcn, {-0.05, -0.032, 0})});
  }

  MusculoskeletalModel model_;
};

inline MusculoskeletalModel leg_model() { return LegModelBuilder().build(); }

}  // namespace sinew
