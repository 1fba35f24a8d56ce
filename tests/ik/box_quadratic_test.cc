#include "ik/box_quadratic.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <random>
#include <stdexcept>

namespace sinew {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

struct Problem {
  MatrixXd H;
  VectorXd g, lower, upper;

  Problem(Index n, unsigned seed) {
    std::mt19937 random(seed);
    std::normal_distribution<double> normal;
    const MatrixXd A = MatrixXd::NullaryExpr(n, n, [&] { return normal(random); });
    H = A * A.transpose() + 0.1 * MatrixXd::Identity(n, n);
    g = VectorXd::NullaryExpr(n, [&] { return 3.0 * normal(random); });
    lower = VectorXd::NullaryExpr(n, [&] { return -std::abs(normal(random)); });
    upper = VectorXd::NullaryExpr(n, [&] { return std::abs(normal(random)); });
  }
  double value(const VectorXd& p) const { return g.dot(p) + 0.5 * p.dot(H * p); }
};

// Every choice of what is free, below and above, solved; the lowest feasible one is the minimum.
VectorXd by_enumeration(const Problem& problem) {
  const Index n = problem.g.size();
  VectorXd best;
  int choices = 1;
  for (Index i = 0; i < n; ++i) choices *= 3;
  for (int choice = 0; choice < choices; ++choice) {
    VectorXd p = VectorXd::Zero(n);
    std::vector<Index> free;
    for (Index i = 0, rest = choice; i < n; ++i, rest /= 3) {
      if (rest % 3 == 0) free.push_back(i);
      if (rest % 3 == 1) p[i] = problem.lower[i];
      if (rest % 3 == 2) p[i] = problem.upper[i];
    }
    if (!free.empty()) {
      const VectorXd rhs = -(problem.g + problem.H * p)(free);
      const VectorXd x = problem.H(free, free).llt().solve(rhs);
      for (std::size_t i = 0; i < free.size(); ++i) p[free[i]] = x[static_cast<Index>(i)];
    }
    const bool feasible =
        (p.array() >= problem.lower.array()).all() && (p.array() <= problem.upper.array()).all();
    if (feasible && (best.size() == 0 || problem.value(p) < problem.value(best))) best = p;
  }
  return best;
}

TEST(BoxQuadratic, IsTheBestOfAllFaces) {
  for (unsigned seed = 1; seed <= 50; ++seed) {
    const Problem problem(5, seed);
    const VectorXd p = minimize_in_box(problem.H, problem.g, problem.lower, problem.upper);
    EXPECT_LT((p - by_enumeration(problem)).cwiseAbs().maxCoeff(), 1e-9) << seed;
  }
}

// The conditions of Karush, Kuhn and Tucker, which only the minimum of a convex problem meets.
TEST(BoxQuadratic, MeetsTheConditionsOfAMinimum) {
  const Problem problem(80, 7);
  const VectorXd p = minimize_in_box(problem.H, problem.g, problem.lower, problem.upper);
  const VectorXd slope = problem.g + problem.H * p;
  int held = 0;
  for (Index i = 0; i < p.size(); ++i) {
    EXPECT_GE(p[i], problem.lower[i]);
    EXPECT_LE(p[i], problem.upper[i]);
    if (p[i] == problem.lower[i]) {
      EXPECT_GE(slope[i], -1e-9);
      ++held;
    } else if (p[i] == problem.upper[i]) {
      EXPECT_LE(slope[i], 1e-9);
      ++held;
    } else {
      EXPECT_NEAR(slope[i], 0.0, 1e-9);
    }
  }
  EXPECT_GT(held, 10);
}

TEST(BoxQuadratic, WithoutBoundsThatMatterIsNewtons) {
  Problem problem(12, 3);
  problem.lower.setConstant(-1e3);
  problem.upper.setConstant(1e3);
  const VectorXd p = minimize_in_box(problem.H, problem.g, problem.lower, problem.upper);
  EXPECT_LT((problem.H * p + problem.g).cwiseAbs().maxCoeff(), 1e-9);
}

TEST(BoxQuadratic, RefusesAStartOutsideTheBox) {
  Problem problem(3, 1);
  problem.lower[1] = 0.5;
  problem.upper[1] = 1.0;
  try {
    minimize_in_box(problem.H, problem.g, problem.lower, problem.upper);
    FAIL() << "accepted";
  } catch (const std::invalid_argument& error) {
    EXPECT_STREQ(error.what(), "minimize_in_box: bounds 1 are 0.5 and 1; expected 0 within");
  }
}

}  // namespace
}  // namespace sinew
