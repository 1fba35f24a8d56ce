#include "ik/articulated_cg.h"

#include <gtest/gtest.h>

#include "tests/ik/factorized_direction.h"
#include "tests/ik/random_problem.h"
#include "tests/ik/whole_body_problem.h"

namespace sinew {
namespace {

struct Directions {
  Eigen::VectorXd factorized, conjugate;
  int iterations = 0;
};

Directions both_directions(const KinematicTree& tree, const IkProblem& problem,
                           const IkTargets& targets, KinematicWorkspace& ws,
                           const std::vector<int>& held, double damping) {
  const int n = tree.unknown_count();
  const Eigen::VectorXd zero = Eigen::VectorXd::Zero(n);
  Iterate at{tree,
             problem,
             &targets,
             ws,
             0,
             0.0,
             zero,
             zero,
             zero,
             zero,
             std::vector<char>(static_cast<std::size_t>(n), 0)};
  at.f = decomposed_gradient(tree, problem, targets, ws, at.g);
  for (const int x : held) {
    at.held[static_cast<std::size_t>(x)] = 1;
    at.g[x] = 0.0;
  }
  Directions result{zero, zero};
  FactorizedDirection factorized(tree, problem, damping);
  EXPECT_TRUE(factorized.compute(at, result.factorized));
  ArticulatedCg conjugate(tree, problem,
                          {.damping = damping, .tolerance = 1e-12, .max_iterations = 20 * n});
  conjugate.start();
  EXPECT_TRUE(conjugate.compute(at, result.conjugate));
  result.iterations = conjugate.iterations();
  return result;
}

class ArticulatedCgDirection : public testing::TestWithParam<std::tuple<unsigned, bool>> {};
INSTANTIATE_TEST_SUITE_P(Random, ArticulatedCgDirection,
                         testing::Combine(testing::Range(0u, 12u), testing::Bool()));

// Residuals of every kind, couplings and wires across any joints.
TEST_P(ArticulatedCgDirection, IsTheFactorizedOne) {
  const auto [seed, quaternions] = GetParam();
  const RandomProblem p = random_problem(seed, quaternions);
  KinematicWorkspace ws = p.workspace();
  for (const std::vector<int>& held : {std::vector<int>{}, std::vector<int>{2, 7}}) {
    const Directions d = both_directions(p.tree, p.problem, p.targets, ws, held, 1e-6);
    EXPECT_LT((d.conjugate - d.factorized).norm(), 1e-8 * d.factorized.norm()) << d.iterations;
    for (const int x : held) EXPECT_EQ(d.conjugate[x], 0.0);
  }
}

TEST(ArticulatedCgDirection, IsTheFactorizedOneOnTheWholeBody) {
  const WholeBodyProblem p;
  KinematicWorkspace ws = p.workspace(3, 0.1);
  const IkTargets targets = p.targets_at(4, 0.1);
  const Directions d = both_directions(p.tree, p.tracking.problem, targets, ws, {},
                                       ArticulatedCg::Options{}.damping);
  EXPECT_LT((d.conjugate - d.factorized).norm(), 1e-8 * d.factorized.norm()) << d.iterations;
}

}  // namespace
}  // namespace sinew
