#pragma once

#include <span>
#include <string>
#include <vector>

#include "model/musculoskeletal_model.h"
#include "model/simbody.h"
#include "model/simbody_model.h"

namespace sinew {

/// Makes up for an error of Simbody's function-based mobilizer (3.7 and, by its source, since),
/// which carries OpenSim's custom joints. Its Ḣ takes the angular velocities of the frames between
/// the three turns,
///   ω_1 = w_1 θ̇_1,   ω_2 = w_1 θ̇_1 + w_2 θ̇_2,   w_k the turns' axes in F,
/// from the first and the first two *coordinates* of the joint instead of the first and the first
/// two *turns*. That is right only if turn k is driven by coordinate k. A knee whose second and
/// third turns follow its flexion gets a wrong acceleration f_2' f_3' q̇² w_3 × w_2; a joint that
/// lists its coordinates in another order than its turns, wrong Coriolis terms altogether. Poses
/// and velocities are right, so the work that the resulting torques do is not the change of energy.
///
/// The joint's acceleration at u̇ = 0,
///   α_FM = Σ_k w_k f_k'' q̇² + (ω_1 × w_2) θ̇_2 + (ω_2 × w_3) θ̇_3,
/// minus what Simbody has, is carried outward as an error ΔA_B of every body's acceleration; the
/// inertial wrench −M_B ΔA_B, given to Simbody's inverse dynamics as a force on the body, makes its
/// result exact. Where Simbody is right, that wrench is zero to rounding.
class CustomJointCorrection {
 public:
  /// The custom joints whose accelerations Simbody gets wrong, by name: one of turns 1 and 3 moves
  /// beside turn 2 and is driven by another coordinate than Simbody supposes, or one of turns 1 and
  /// 2 beside turn 3.
  static std::vector<std::string> affected_joints(const MusculoskeletalModel& model);

  /// Finds the custom joints in which two turns or more move. `compiled` must outlive this.
  CustomJointCorrection(const MusculoskeletalModel& model, const SimbodyModel& compiled);

  /// Adds −M_B ΔA_B of every body to F_B_W, [moment about the body's origin; force] in ground.
  /// q, q_dot: by coordinate; state: realized to Velocity at both. errors: a workspace of one
  /// element a body. O(bodies), nothing at all for a model without such joints.
  void add_body_forces(std::span<const double> q, std::span<const double> q_dot,
                       const SimTK::State& state, std::span<SimTK::SpatialVec> errors,
                       SimTK::Vector_<SimTK::SpatialVec>& F_B_W) const;

 private:
  struct Turn {
    Eigen::Vector3d axis;
    int coordinate;
    CompiledFunction function;
  };
  struct Link {
    int parent;
    SimTK::MobilizedBodyIndex parent_index, index;
    double mass;
    SimTK::Vec3 p_BCm, p_BM;
    SimTK::Mat33 I_BCm;
    Eigen::Matrix3d R_PF;
    std::vector<Turn> turns;  // empty: the joint needs no correction
  };

  static Eigen::Vector3d velocity_dependent_acceleration(const Link& link,
                                                         std::span<const double> q,
                                                         std::span<const double> q_dot);

  const SimTK::SimbodyMatterSubsystem& matter_;
  std::vector<Link> links_;  // links_[b − 1] carries body b
  bool needed_ = false;
};

}  // namespace sinew
