#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "model/musculoskeletal_model.h"

namespace sinew {

/// The model compiled for inverse kinematics: flat arrays in which every link stands after its
/// parent, so that one loop outward gives all poses and one loop inward all joint torques.
/// Immutable; everything that changes while solving is in KinematicWorkspace. Link b is body b of
/// the description; link 0 is ground.
///
/// Three sets of numbers:
///  q  what the joints' poses are functions of: one for every coordinate of the description, or
///  four
///     (w, x, y, z) for a ball joint that steps as a quaternion;
///  v  tangent directions, one a degree of freedom; v = q̇ except in quaternion joints, where v is
///     the angular velocity of M in F. A column of S belongs to each;
///  x  the unknowns: those v that are neither dependent (couplers), locked nor prescribed.
/// Dependent coordinates are eliminated: q_dependent = function(q_independent), and gradients
/// follow by the chain rule.
struct KinematicTree {
  enum class Kind : unsigned char { kWeld, kSteps, kEllipsoid, kBall, kFree };

  /// One factor of a joint's pose: a turn about, or a shift along, an axis by function(q).
  struct Step {
    Eigen::Vector3d axis;
    int q = -1;  // −1: constant
    int v = -1;
    int function = -1;      // index into functions; −1: the coordinate itself
    double constant = 0.0;  // value where q is −1
  };

  struct Link {
    int parent = -1;
    Kind kind = Kind::kWeld;
    int first_q = 0, q_count = 0;
    int first_v = 0, v_count = 0;
    int first_step = 0, rotation_count = 0, translation_count = 0;
    RigidTransform X_PF, X_MB;
    Eigen::Vector3d radii = Eigen::Vector3d::Zero();
  };

  /// q[dependent] = function(q[independent]).
  struct Coupling {
    int dependent_q, dependent_v;
    int independent_q, independent_v;
    int function;
  };

  struct Prescribed {
    int q;
    int function;  // of time [s]
  };

  struct Options {
    /// Ball and free joints as quaternions, free of the singularity of their angles. Their
    /// coordinates then have no q of their own (q_of_coordinate is −1), cannot be locked, clamped
    /// or coupled.
    bool quaternions = false;
    /// Locked and prescribed coordinates become unknowns like the others.
    bool ignore_locks = false;
  };

  std::vector<Link> links;
  std::vector<Step> steps;
  std::vector<CompiledFunction> functions;
  std::vector<Coupling> couplings;  // sources before their dependents
  std::vector<int> coupling_of_v;   // index of the coupling that sets v, or −1
  std::vector<Prescribed> prescribed;
  std::vector<int> q_of_coordinate;  // per coordinate of the description
  std::vector<int> v_of_coordinate;
  std::vector<int> q_of_v;  // −1 in quaternion joints
  std::vector<int> link_of_v;
  std::vector<double> default_q;
  std::vector<int> unknown_v;        // x → v, increasing
  std::vector<int> unknown_of_v;     // v → x, −1 where v is no unknown
  std::vector<double> lower, upper;  // bounds of each unknown's q; ±infinity where unbounded

  int link_count() const { return static_cast<int>(links.size()); }
  int q_count() const { return static_cast<int>(default_q.size()); }
  int v_count() const { return static_cast<int>(link_of_v.size()); }
  int unknown_count() const { return static_cast<int>(unknown_v.size()); }
};

/// Compiles a description that has passed validate(). Throws InputError where a locked, clamped or
/// coupled coordinate belongs to a joint that is to step as a quaternion.
KinematicTree compile_tree(const MusculoskeletalModel& model);
KinematicTree compile_tree(const MusculoskeletalModel& model,
                           const KinematicTree::Options& options);

/// All that changes while solving, sized once.
struct KinematicWorkspace {
  std::vector<double> q;
  std::vector<RigidTransform> X_WB;  // links
  std::vector<Vector6d> S;           // v: twist of the link per unit v, world axes, at its origin
  // Steps that move: twist of the link per unit of the step's own length or angle, and the first
  // and second derivative of that by the coordinate. What the second derivatives of the cost need.
  std::vector<Vector6d> step_twist;
  std::vector<double> step_slope, step_curvature;
  std::vector<double> coupling_slope;  // couplings: d dependent / d independent
  std::vector<Vector6d> F;             // links: wrench on the link, world axes, at its origin
  std::vector<Vector6d> f;             // links: F accumulated inward
  std::vector<double> g;               // v: joint torque, see joint_torques()

  explicit KinematicWorkspace(const KinematicTree& tree);
};

/// Sets prescribed coordinates to their values at `time`.
void prescribe(const KinematicTree& tree, double time, std::span<double> q);

/// Poses of all links and the columns S, from workspace.q, whose dependent entries it sets.
/// O(links).
void update_kinematics(const KinematicTree& tree, KinematicWorkspace& workspace);

/// Poses only: no S. For line searches.
void update_poses(const KinematicTree& tree, KinematicWorkspace& workspace);

/// The inward half of recursive Newton-Euler, eqs. (27)(28) of Ayusawa & Nakamura 2012:
/// f_j = F_j + Σ_children X f_c, g = Sᵀ f, for every v by itself. Needs update_kinematics().
/// O(links).
void joint_torques(const KinematicTree& tree, KinematicWorkspace& workspace);

/// Chain rule through the couplings: g of an independent coordinate takes on what its dependents
/// carry. Entries of dependent v keep their own torque.
void fold_couplings(const KinematicTree& tree, KinematicWorkspace& workspace);

/// q ⊞ step: advances the unknowns by `step` (x), clipping bounded ones, and writes q_out.
/// Dependent entries are stale until the next update.
void advance(const KinematicTree& tree, std::span<const double> q, std::span<const double> step,
             std::span<double> q_out);

/// Calls use(x, b, S, scale) for every unknown x that moves `link`: S is the column of one of the
/// joints on the way to the root, b that joint's link, and scale the slope of the couplings in
/// between (1 for the joint's own coordinate). An x can come up more than once.
template <typename Use>
void for_each_mover(const KinematicTree& tree, const KinematicWorkspace& workspace, int link,
                    const Use& use) {
  for (int b = link; b > 0; b = tree.links[static_cast<std::size_t>(b)].parent) {
    const KinematicTree::Link& ancestor = tree.links[static_cast<std::size_t>(b)];
    for (int v = ancestor.first_v; v < ancestor.first_v + ancestor.v_count; ++v) {
      int source = v;
      double scale = 1.0;
      for (int c = tree.coupling_of_v[static_cast<std::size_t>(v)]; c >= 0;
           c = tree.coupling_of_v[static_cast<std::size_t>(source)]) {
        scale *= workspace.coupling_slope[static_cast<std::size_t>(c)];
        source = tree.couplings[static_cast<std::size_t>(c)].independent_v;
      }
      const int x = tree.unknown_of_v[static_cast<std::size_t>(source)];
      if (x >= 0) use(x, b, workspace.S[static_cast<std::size_t>(v)], scale);
    }
  }
}

/// Jacobian of the world position of point p_BQ of a link with respect to x, eq. (13)'s J_Bp, built
/// column by column over the link's ancestors. J: 3 × unknowns, overwritten.
void station_jacobian(const KinematicTree& tree, const KinematicWorkspace& workspace, int link,
                      const Eigen::Vector3d& p_BQ, Eigen::Ref<Eigen::Matrix3Xd> J);

/// As station_jacobian, of the link's angular velocity (J_Bω).
void rotation_jacobian(const KinematicTree& tree, const KinematicWorkspace& workspace, int link,
                       Eigen::Ref<Eigen::Matrix3Xd> J);

}  // namespace sinew
