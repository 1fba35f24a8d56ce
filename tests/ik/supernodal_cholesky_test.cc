#include "ik/supernodal_cholesky.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

#include "ik/gauss_newton.h"
#include "tests/ik/random_problem.h"

namespace sinew {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

struct RandomMatrix {
  std::vector<std::vector<int>> cliques;
  MatrixXd H;  // positive definite, zero outside the cliques
};

RandomMatrix random_matrix(int n, int cliques, int largest, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> entry(-1.0, 1.0);
  RandomMatrix result{{}, 0.1 * MatrixXd::Identity(n, n)};
  std::vector<int> all(static_cast<std::size_t>(n));
  std::iota(all.begin(), all.end(), 0);
  for (int c = 0; c < cliques; ++c) {
    std::shuffle(all.begin(), all.end(), random);
    const auto size = std::uniform_int_distribution<std::ptrdiff_t>(1, largest)(random);
    const std::vector<int> clique(all.begin(), all.begin() + size);
    VectorXd row = VectorXd::Zero(n);
    for (const int i : clique) row[i] = entry(random);
    result.H += row * row.transpose();
    result.cliques.push_back(clique);
  }
  return result;
}

double& entry(SupernodalCholesky& factor, int row, int column) {
  return factor.values()[static_cast<std::size_t>(factor.offset(row, column))];
}

void fill(const RandomMatrix& random, SupernodalCholesky& factor) {
  factor.clear();
  for (const std::vector<int>& clique : random.cliques) {
    for (const int i : clique) {
      for (const int j : clique) {
        if (i >= j) entry(factor, i, j) = random.H(i, j);
      }
    }
  }
  for (int i = 0; i < factor.size(); ++i) entry(factor, i, i) = random.H(i, i);
}

class RandomPatterns : public testing::TestWithParam<unsigned> {};
INSTANTIATE_TEST_SUITE_P(SupernodalCholesky, RandomPatterns, testing::Range(0u, 12u));

TEST_P(RandomPatterns, SolveAsADenseFactorizationDoes) {
  const int n = 5 + 11 * static_cast<int>(GetParam());
  const RandomMatrix random = random_matrix(n, n, 4, GetParam());
  SupernodalCholesky factor(n, random.cliques);
  std::vector<char> held(static_cast<std::size_t>(n), 0);
  const VectorXd b = VectorXd::LinSpaced(n, -1.0, 2.0);
  for (const double shift : {0.0, 0.5}) {
    fill(random, factor);
    ASSERT_TRUE(factor.factorize(shift, held));
    VectorXd x = b;
    factor.solve(x);
    const MatrixXd shifted = random.H + shift * MatrixXd::Identity(n, n);
    EXPECT_LE((x - shifted.llt().solve(b)).norm(), 1e-11 * b.norm() * x.norm());
  }
  // Held rows and columns are those of the identity, and H is still there to be factorized again.
  MatrixXd reduced = random.H;
  for (int i = 1; i < n; i += 3) {
    held[static_cast<std::size_t>(i)] = 1;
    reduced.row(i).setZero();
    reduced.col(i).setZero();
    reduced(i, i) = 1.0;
  }
  ASSERT_TRUE(factor.factorize(0.0, held));
  VectorXd x = b;
  factor.solve(x);
  EXPECT_LE((x - reduced.llt().solve(b)).norm(), 1e-11 * b.norm() * x.norm());
}

TEST(SupernodalCholesky, SaysSoWhenTheMatrixIsNotPositiveDefinite) {
  const std::vector<std::vector<int>> cliques = {{0, 1}, {1, 2}};
  SupernodalCholesky factor(3, cliques);
  const std::vector<char> held(3, 0);
  factor.clear();
  entry(factor, 0, 0) = entry(factor, 1, 1) = entry(factor, 2, 2) = 1.0;
  entry(factor, 2, 1) = 2.0;
  EXPECT_FALSE(factor.factorize(0.0, held));
  EXPECT_TRUE(factor.factorize(1.5, held));
}

// An arrow pointing down and right: eliminated from its tip it stays an arrow.
TEST(SupernodalCholesky, KeepsOutZerosThatStayZero) {
  constexpr int kSize = 50;
  std::vector<std::vector<int>> cliques;
  for (int i = 0; i + 1 < kSize; ++i) cliques.push_back({i, kSize - 1});
  EXPECT_EQ(SupernodalCholesky(kSize, cliques).nonzeros(), 2 * kSize - 1);
  for (std::vector<int>& clique : cliques) clique[1] = 0, clique[0] += 1;
  EXPECT_EQ(SupernodalCholesky(kSize, cliques).nonzeros(), kSize * (kSize + 1) / 2);
}

// JᵀΣJ of problems with all kinds of residuals stays within the pattern announced for it, and the
// factor holds the whole of it.
TEST_P(RandomPatterns, HoldTheCurvatureOfEveryProblem) {
  const RandomProblem p = random_problem(GetParam(), GetParam() % 2 == 1);
  const KinematicWorkspace ws = p.workspace();
  CostCurvature curvature(p.tree, p.problem);
  curvature.update(p.tree, p.problem, p.targets, ws);
  const int n = p.tree.unknown_count();
  const auto cliques = curvature.reversed_cliques(p.tree, p.problem);
  SupernodalCholesky factor(n, cliques);
  MatrixXd H(n, n), pattern = MatrixXd::Identity(n, n);
  curvature.matrix(p.problem, p.targets, ws, H);
  std::vector<int> offsets;
  for (const CostCurvature::Entry& each : curvature.entries()) {
    ASSERT_GE(each.row, each.column);
    offsets.push_back(factor.offset(each.row, each.column));
    ASSERT_GE(offsets.back(), 0);
  }
  curvature.add_reversed(p.problem, p.targets, ws, offsets, factor.values());
  for (const std::vector<int>& clique : cliques) {
    for (const int i : clique) {
      for (const int j : clique) pattern(i, j) = 1.0;
    }
  }
  for (int j = 0; j < n; ++j) {
    for (int i = j; i < n; ++i) {
      const double expected = H(n - 1 - i, n - 1 - j);
      if (pattern(i, j) == 0.0) {
        EXPECT_EQ(expected, 0.0) << i << ", " << j;
      } else {
        EXPECT_EQ(entry(factor, i, j), expected) << i << ", " << j;
      }
    }
  }
  EXPECT_GT(H.norm(), 0.0);
}

}  // namespace
}  // namespace sinew
