#pragma once

#include "ik/curvature.h"
#include "ik/direction.h"
#include "ik/supernodal_cholesky.h"

namespace sinew {

/// (JᵀΣJ + μE) d = −g by the sparse factorization alone: GaussNewton without what it does about
/// wires and bounds along the way. μ = damping times the mean diagonal.
class FactorizedDirection : public Direction {
 public:
  FactorizedDirection(const KinematicTree& tree, const IkProblem& problem, double damping)
      : damping_(damping),
        curvature_(tree, problem),
        factor_(tree.unknown_count(), curvature_.reversed_cliques(tree, problem)) {
    for (const CostCurvature::Entry& entry : curvature_.entries()) {
      offsets_.push_back(factor_.offset(entry.row, entry.column));
    }
  }
  void start() override {}
  bool scales_its_step() const override { return true; }
  bool compute(const Iterate& at, Eigen::Ref<Eigen::VectorXd> d) override {
    curvature_.update(at.tree, at.problem, *at.targets, at.workspace);
    factor_.clear();
    curvature_.add_reversed(at.problem, *at.targets, at.workspace, offsets_, factor_.values());
    const std::vector<char> held(at.held.rbegin(), at.held.rend());
    if (!factor_.factorize(damping_ * factor_.mean_diagonal(), held)) return false;
    d = -at.g.reverse();
    factor_.solve(d);
    d.reverseInPlace();
    return true;
  }

 private:
  double damping_;
  CostCurvature curvature_;
  SupernodalCholesky factor_;
  std::vector<int> offsets_;
};

}  // namespace sinew
