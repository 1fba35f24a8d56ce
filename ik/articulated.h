#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "ik/direction.h"
#include "ik/internal_rows.h"

namespace sinew {

/// Gauss-Newton and Newton directions in O(links), without any matrix larger than 6×6: the
/// quadratic model of the cost is minimized by one inward and one outward sweep, as
/// articulated-body dynamics solves for accelerations (Featherstone 2008, ch. 7, with stiffness in
/// place of inertia).
///
/// With the twist v_k of link k at its origin, X_k the shift from its parent and S_k its joint's
/// columns,
///   v_k = X_k v_p(k) + S_k d_k                                                               (N1)
///   m(d) = Σ g_kᵀd_k + ½ Σ v_kᵀK_k v_k + Σ d_kᵀB_k X_k v_p(k) + ½ Σ d_kᵀ(C_k + μE)d_k         (N2)
/// K_k is the stiffness of the link's residuals, (N3). Newton adds their geometric stiffness, (N4),
/// the second derivatives of rotations, B_k = ½ S_kᵀ[m× f×; f× 0] with the wrench [m; f] that the
/// gradient's inward sweep left at the link (N5), and C_k, the same within a joint of several steps
/// plus the second derivatives of the steps' functions. Elimination inward, (N6):
///   U = K^A S + Bᵀ, D = SᵀU + C + μE, K^A_p += Xᵀ(K^A − U D⁻¹Uᵀ)X, p^A_p += Xᵀ(p^A − U D⁻¹ Sᵀp^A)
/// and substitution outward, (N7): d = −D⁻¹(Uᵀ X v_p + Sᵀp^A).
///
/// μ is raised until every D is positive definite, and follows the ratio of actual to expected
/// decrease (Nielsen's rule, as in GaussNewton). `kAutomatic` otherwise starts with Gauss-Newton,
/// which needs the fewest iterations where residuals vanish, and turns to Newton for the rest of
/// the frame when that ratio shows that Gauss-Newton's model misses curvature: at singular
/// postures, and where residuals stay large. It takes Newton as well where that leads to a small
/// step, kSmallStep, at the start of a frame and after every small step.
///
/// A wire or distance across one joint depends on that joint's own steps only: its stiffness w jjᵀ
/// is added to the joint's D, exactly. The tree's couplings and residuals across several joints do
/// not fit one sweep; see articulated_sweep_fits(). Newton is approximate in ellipsoid joints, for
/// residuals between links and for orientation weights other than a multiple of E, where
/// Gauss-Newton's part stands in.
/// Allocates at construction only.
class Articulated : public Direction {
 public:
  using Model = NewtonModel;

  struct Options {
    // μ at the start, times the largest stiffness of a link. On the manipulator's case B with 400
    // links, 1e-6 takes 14 iterations; starting from 1e-12, the first step turns joints by 30,000
    // rad and 140 follow.
    double damping = 1e-6;
  };

  Articulated(const KinematicTree& tree, const IkProblem& problem, Model model,
              const Options& options);

  void start() override;
  bool compute(const Iterate& at, Eigen::Ref<Eigen::VectorXd> d) override;
  bool scales_its_step() const override { return true; }
  bool wants_retry() const override { return true; }
  double expected_decrease() const override { return expected_; }
  void learn(double accepted_length, double actual_decrease) override;

  /// μ of the last direction.
  double damping() const { return mu_; }

 private:
  void collect_stiffness(const Iterate& at, bool newton);
  void collect_joint_stiffness(const Iterate& at);
  bool sweep_inward(const Iterate& at, bool newton);
  void sweep_outward(const Iterate& at, Eigen::Ref<Eigen::VectorXd> d);
  template <int kColumns>
  bool eliminate(const Iterate& at, int link, std::span<const int> columns, bool newton);
  template <typename Matrix>
  void add_joint_curvature(const Iterate& at, int link, std::span<const int> columns,
                           Matrix& D) const;
  void add_to_parent(const Iterate& at, int link);
  bool sweep(const Iterate& at, Eigen::Ref<Eigen::VectorXd> d);
  bool dispatch(const Iterate& at, int link, bool newton);

  Model model_;
  Options options_;
  InternalRows rows_;
  std::vector<Matrix6d> joint_stiffness_;  // links: of the residuals across its joint, by columns
  std::vector<Matrix6d> stiffness_;        // links: K of the residuals alone
  std::vector<Matrix6d> K_;              // links: K^A, after elimination what the parent takes over
  std::vector<Vector6d> p_;              // links: p^A, likewise
  std::vector<Vector6d> twist_;          // links: v of (N1)
  std::vector<Vector6d> gain_;           // v: column of (D⁻¹Uᵀ)ᵀ
  std::vector<double> offset_;           // v: D⁻¹Sᵀp^A
  std::vector<double> torque_, spring_;  // v: of coordinate targets
  std::vector<char> active_;             // v: an unknown that no bound holds
  double mu_ = kNaN, growth_ = 2.0, scale_ = 1.0;
  double expected_ = kNaN;
  double needed_mu_ = 0.0;  // what the D that was not definite asks for
  int rejected_ = 0;        // directions in a row
  bool newton_ = false;     // what kAutomatic takes now
  bool near_ = false;       // because the last step was small or is still to come
  double step_ = kNaN;      // largest entry of the last direction
};

/// True if the tree has no couplings and the problem no residual between links across more than one
/// joint, so that one sweep solves (N2) exactly.
bool articulated_sweep_fits(const KinematicTree& tree, const IkProblem& problem);

/// True if it does and an iteration by the sweep costs less than one by GaussNewton's
/// factorization, by a count of operations: the sweep takes the same for every link and column, the
/// factorization the square of the number of unknowns from each one to the root. On gait models, 20
/// links with 10 to 15 unknowns on the way, the factorization costs less; on a chain of 3 unknowns
/// a link the sweep does from about 20 links. O(links).
bool articulated_sweep_is_faster(const KinematicTree& tree, const IkProblem& problem);

}  // namespace sinew
