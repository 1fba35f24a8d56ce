#include "dynamics/reference_dynamics.h"

#include <fmt/format.h>

#include <Eigen/LU>

namespace sinew {

using Eigen::Vector3d;

ReferenceDynamics::ReferenceDynamics(const MusculoskeletalModel& model)
    : skeleton_(skeleton_of(model)),
      coordinate_count_(model.coordinates.size()),
      compiled_(skeleton_.model),
      tree_(compile_tree(skeleton_.model)),
      kinematics_(tree_),
      state_(compiled_.default_state()),
      u_dot_(state_.getNU(), 0.0),
      residual_(state_.getNU(), 0.0),
      gravity_(compiled_.matter().getNumBodies()),
      applied_(compiled_.matter().getNumBodies()) {
  if (model.joints.empty() || model.joints[0].coordinates.size() != 6) {
    throw InputError({model.name, 0},
                     {"the root cannot move freely", "6 coordinates in the first joint", "", ""});
  }
  for (const Joint& joint : skeleton_.model.joints) {
    if (joint.kind == Joint::Kind::kBall || joint.kind == Joint::Kind::kFree) {
      throw InputError(
          joint.source,
          {fmt::format("joint '{}' has speeds that are not its coordinates' rates", joint.name), "",
           "", "Replace it by a CustomJoint."});
    }
  }
}

void ReferenceDynamics::set_motion(std::span<const double> q, std::span<const double> q_dot,
                                   std::span<const double> q_ddot) {
  for (std::size_t c = 0; c < skeleton_.coordinates.size(); ++c) {
    const int coordinate = static_cast<int>(c);
    const auto whole = static_cast<std::size_t>(skeleton_.coordinates[c]);
    kinematics_.q[static_cast<std::size_t>(tree_.q_of_coordinate[c])] = q[whole];
    state_.updQ()[compiled_.q_index(coordinate)] = q[whole];
    state_.updU()[compiled_.u_index(coordinate)] = q_dot[whole];
    u_dot_[compiled_.u_index(coordinate)] = q_ddot[whole];
  }
  update_kinematics(tree_, kinematics_);
  compiled_.system().realize(state_, SimTK::Stage::Velocity);
  gravity_.setToZero();
  for (std::size_t b = 1; b < skeleton_.model.bodies.size(); ++b) {
    const Body& body = skeleton_.model.bodies[b];
    const Vector3d weight = body.mass * skeleton_.model.gravity;
    const Vector3d arm = kinematics_.X_WB[b].R * body.p_BCm;
    gravity_[compiled_.body(static_cast<int>(b))] =
        SimTK::SpatialVec(to_simtk(arm.cross(weight)), to_simtk(weight));
  }
}

Vector3d ReferenceDynamics::mass_center() const {
  return to_eigen(compiled_.matter().calcSystemMassCenterLocationInGround(state_));
}

Eigen::VectorXd ReferenceDynamics::solve(const SimTK::Vector_<SimTK::SpatialVec>& applied) {
  compiled_.matter().calcResidualForceIgnoringConstraints(
      state_, SimTK::Vector(state_.getNU(), 0.0), applied, u_dot_, residual_);
  Eigen::VectorXd tau(compiled_.coordinate_count());
  for (int c = 0; c < tau.size(); ++c) tau[c] = residual_[compiled_.u_index(c)];
  return tau;
}

Vector6d ReferenceDynamics::required_wrench() {
  const Eigen::VectorXd tau = solve(gravity_);
  Matrix6d S;
  Vector6d root;
  for (int k = 0; k < 6; ++k) {
    const int c = skeleton_.model.joints[0].coordinates[static_cast<std::size_t>(k)];
    S.row(k) =
        kinematics_.S[static_cast<std::size_t>(tree_.v_of_coordinate[static_cast<std::size_t>(c)])];
    root[k] = tau[c];
  }
  Vector6d wrench = S.partialPivLu().solve(root);  // about the root's origin
  wrench.head<3>() += kinematics_.X_WB[1].p.cross(wrench.tail<3>());
  return wrench;
}

Eigen::VectorXd ReferenceDynamics::generalized_forces(std::span<const int> bodies,
                                                      std::span<const FloorLoad> loads) {
  applied_ = gravity_;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const int body = skeleton_.bodies[static_cast<std::size_t>(bodies[i])];
    const Vector3d arm = loads[i].point - kinematics_.X_WB[static_cast<std::size_t>(body)].p;
    const Vector3d moment = arm.cross(loads[i].force) + loads[i].torque;
    applied_[compiled_.body(body)] += SimTK::SpatialVec(to_simtk(moment), to_simtk(loads[i].force));
  }
  const Eigen::VectorXd tau = solve(applied_);
  Eigen::VectorXd by_coordinate =
      Eigen::VectorXd::Zero(static_cast<Eigen::Index>(coordinate_count_));
  for (std::size_t c = 0; c < skeleton_.coordinates.size(); ++c) {
    by_coordinate[skeleton_.coordinates[c]] = tau[static_cast<Eigen::Index>(c)];
  }
  return by_coordinate;
}

}  // namespace sinew
