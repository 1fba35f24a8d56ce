#include "ik/residual_rows.h"

#include <gtest/gtest.h>

#include "ik/curvature.h"
#include "tests/ik/random_problem.h"

namespace sinew {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr unsigned kSeeds = 10;

class ResidualRowsOf : public testing::TestWithParam<ResidualKind> {};
INSTANTIATE_TEST_SUITE_P(EveryKind, ResidualRowsOf, testing::ValuesIn(kResidualKinds));

// f = ½ bᵀb, g = Aᵀb, B = AᵀA: three independent ways to each.
TEST_P(ResidualRowsOf, MakeTheCostItsGradientAndItsCurvature) {
  for (unsigned seed = 0; seed < kSeeds; ++seed) {
    const RandomProblem p = only(random_problem(seed, seed % 2 == 1), GetParam());
    KinematicWorkspace ws = p.workspace();
    const int n = p.tree.unknown_count();
    VectorXd g(n);
    const double f = decomposed_gradient(p.tree, p.problem, p.targets, ws, g);
    CostCurvature curvature(p.tree, p.problem);
    MatrixXd B(n, n);
    curvature.update(p.tree, p.problem, p.targets, ws);
    curvature.matrix(p.problem, p.targets, ws, B);
    ResidualRows rows(p.tree, p.problem);
    for (int repeat = 0; repeat < 2; ++repeat) {  // the second time over what the first left
      rows.update(p.tree, p.problem, p.targets, ws);
      const MatrixXd A = rows.A.topRows(rows.count);
      const VectorXd b = rows.b.head(rows.count);
      EXPECT_NEAR(0.5 * b.squaredNorm(), f, 1e-13 * f);
      EXPECT_LE((A.transpose() * b - g).norm(), 1e-12 * (1.0 + g.norm()));
      EXPECT_LE((A.transpose() * A - B).norm(), 1e-12 * (1.0 + B.norm()));
    }
  }
}

TEST(ResidualRows, HaveNoneForWhatIsNotMeasuredAndForSlackWires) {
  RandomProblem p = random_problem(0, false);
  KinematicWorkspace ws = p.workspace();
  EXPECT_EQ(row_count(p.problem),
            3 * (20 + 10 + 5 + 5) + 24 + 24 + static_cast<int>(p.problem.coordinates.size()));
  p = only(p, ResidualKind::kWire);
  for (WireResidual& wire : p.problem.wires) wire.natural_length = 100.0;
  ResidualRows rows(p.tree, p.problem);
  rows.update(p.tree, p.problem, p.targets, ws);
  EXPECT_EQ(rows.count, 0);
  p.problem.wires[0].natural_length = 0.0;
  rows.update(p.tree, p.problem, p.targets, ws);
  EXPECT_EQ(rows.count, 1);
}

TEST(ResidualRows, TakeSemidefiniteWeights) {
  RandomProblem p = only(random_problem(1, false), ResidualKind::kPosition);
  RandomValues values(2);
  for (PositionResidual& r : p.problem.positions) {
    const Eigen::Vector3d normal = values.vector(1.0);
    r.weight = normal * normal.transpose();  // along one direction only, as of a camera's image
  }
  KinematicWorkspace ws = p.workspace();
  VectorXd g(p.tree.unknown_count());
  const double f = decomposed_gradient(p.tree, p.problem, p.targets, ws, g);
  ResidualRows rows(p.tree, p.problem);
  rows.update(p.tree, p.problem, p.targets, ws);
  EXPECT_NEAR(0.5 * rows.b.head(rows.count).squaredNorm(), f, 1e-13 * f);
  EXPECT_LE((rows.A.topRows(rows.count).transpose() * rows.b.head(rows.count) - g).norm(),
            1e-12 * g.norm());
}

}  // namespace
}  // namespace sinew
