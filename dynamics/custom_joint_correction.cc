#include "dynamics/custom_joint_correction.h"

#include <algorithm>
#include <array>
#include <utility>

namespace sinew {
namespace {

SimTK::Mat33 to_mat33(const Eigen::Matrix3d& m) {
  return {m(0, 0), m(0, 1), m(0, 2), m(1, 0), m(1, 1), m(1, 2), m(2, 0), m(2, 1), m(2, 2)};
}

// Per turn, which of the joint's own coordinates drives it; −1 if it stands still.
std::array<int, 3> drivers(const Joint& joint) {
  std::array<int, 3> result{-1, -1, -1};
  for (std::size_t k = 0; k < 3 && joint.kind == Joint::Kind::kCustom; ++k) {
    const TransformAxis& turn = joint.axes[k];
    if (turn.coordinate < 0 || CompiledFunction(turn.function).is_constant()) continue;
    result[k] = turn.coordinate - joint.coordinates.front();
  }
  return result;
}

bool has_moving_turns(const Joint& joint) {
  const auto d = drivers(joint);
  return std::count(d.begin(), d.end(), -1) < 2;
}

// Simbody takes ω_1 from coordinate 0 and ω_2 from all but coordinate 2 (which not all joints
// have); what it adds to them along the turned axis itself does no harm.
bool is_affected(const Joint& joint) {
  const auto [first, second, third] = drivers(joint);
  const bool wrong_omega_1 = first > 0 || third == 0;
  const bool wrong_omega_2 = first == 2 || second == 2;
  return (second >= 0 && wrong_omega_1) || (third >= 0 && wrong_omega_2);
}

}  // namespace

std::vector<std::string> CustomJointCorrection::affected_joints(const MusculoskeletalModel& model) {
  std::vector<std::string> names;
  for (const Joint& joint : model.joints) {
    if (is_affected(joint)) names.push_back(joint.name);
  }
  return names;
}

CustomJointCorrection::CustomJointCorrection(const MusculoskeletalModel& model,
                                             const SimbodyModel& compiled)
    : matter_(compiled.matter()) {
  for (const Joint& joint : model.joints) {
    const Body& body = model.bodies[static_cast<std::size_t>(joint.child)];
    Link link{joint.parent,
              compiled.body(joint.parent),
              compiled.body(joint.child),
              body.mass,
              to_simtk(body.p_BCm),
              to_simtk(joint.X_BM.p),
              to_mat33(body.I_BCm),
              joint.X_PF.R,
              {}};
    if (has_moving_turns(joint)) {
      needed_ = true;
      for (std::size_t k = 0; k < 3; ++k) {
        const TransformAxis& step = joint.axes[k];
        link.turns.push_back(
            {step.axis.normalized(), step.coordinate, CompiledFunction(step.function)});
      }
    }
    links_.push_back(std::move(link));
  }
}

// α_FM of the header, in F.
Eigen::Vector3d CustomJointCorrection::velocity_dependent_acceleration(
    const Link& link, std::span<const double> q, std::span<const double> q_dot) {
  Eigen::Vector3d omega = Eigen::Vector3d::Zero(), alpha = Eigen::Vector3d::Zero();
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  for (const Turn& turn : link.turns) {
    const auto c = static_cast<std::size_t>(turn.coordinate);
    const double value = turn.coordinate < 0 ? 0.0 : q[c];
    const double rate = turn.coordinate < 0 ? 0.0 : q_dot[c];
    const auto f = turn.function.evaluate(value);
    const Eigen::Vector3d w = R * turn.axis;
    alpha += w * (f.ddf * rate * rate) + omega.cross(w) * (f.df * rate);
    omega += w * (f.df * rate);
    R = R * Eigen::AngleAxisd(f.f, turn.axis).toRotationMatrix();
  }
  return alpha;
}

void CustomJointCorrection::add_body_forces(std::span<const double> q,
                                            std::span<const double> q_dot,
                                            const SimTK::State& state,
                                            std::span<SimTK::SpatialVec> errors,
                                            SimTK::Vector_<SimTK::SpatialVec>& F_B_W) const {
  if (!needed_) return;
  errors[0] = SimTK::SpatialVec(SimTK::Vec3(0), SimTK::Vec3(0));
  for (std::size_t b = 1; b <= links_.size(); ++b) {
    const Link& link = links_[b - 1];
    const SimTK::MobilizedBody& parent = matter_.getMobilizedBody(link.parent_index);
    const SimTK::MobilizedBody& body = matter_.getMobilizedBody(link.index);
    const SimTK::Rotation& R_WB = body.getBodyRotation(state);
    const SimTK::Vec3 p_BM_W = R_WB * link.p_BM;
    const SimTK::Vec3 p_PM_W =
        body.getBodyOriginLocation(state) + p_BM_W - parent.getBodyOriginLocation(state);

    SimTK::Vec3 turn_error(0);
    if (!link.turns.empty()) {
      const SimTK::Vec3 w_WP = parent.getBodyAngularVelocity(state);
      const SimTK::Vec3 w_PB_W = body.getBodyAngularVelocity(state) - w_WP;
      const SimTK::Vec3 simbodys =
          matter_.getTotalCoriolisAcceleration(state, link.index)[0] -
          matter_.getTotalCoriolisAcceleration(state, link.parent_index)[0] - w_WP % w_PB_W;
      const Eigen::Vector3d alpha_P = link.R_PF * velocity_dependent_acceleration(link, q, q_dot);
      turn_error = parent.getBodyRotation(state) * to_simtk(alpha_P) - simbodys;
    }

    const SimTK::SpatialVec& of_parent = errors[static_cast<std::size_t>(link.parent)];
    const SimTK::Vec3 alpha = of_parent[0] + turn_error;
    const SimTK::Vec3 a = of_parent[1] + of_parent[0] % p_PM_W - alpha % p_BM_W;
    errors[b] = SimTK::SpatialVec(alpha, a);

    const SimTK::Vec3 p_BCm_W = R_WB * link.p_BCm;
    const SimTK::Vec3 force = link.mass * (a + alpha % p_BCm_W);
    const SimTK::Vec3 moment = R_WB * (link.I_BCm * (~R_WB * alpha)) + p_BCm_W % force;
    F_B_W[link.index] -= SimTK::SpatialVec(moment, force);
  }
}

}  // namespace sinew
