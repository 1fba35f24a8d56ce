#include <gtest/gtest.h>

#include <Eigen/Cholesky>

#include "ik/bfgs.h"
#include "ik/conjugate_gradient.h"
#include "ik/levenberg_marquardt.h"
#include "ik/minimizer.h"
#include "tests/ik/random_problem.h"
#include "tests/ik/small_model.h"

/// Directions one by one, against what can be computed by hand.
namespace sinew {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// Where a problem stands, with nothing known yet.
template <typename Problem>
Iterate iterate_of(const Problem& p, KinematicWorkspace& ws) {
  const int n = p.tree.unknown_count();
  return {.tree = p.tree,
          .problem = p.problem,
          .targets = &p.targets,
          .workspace = ws,
          .g = VectorXd::Zero(n),
          .s = VectorXd::Zero(n),
          .y = VectorXd::Zero(n),
          .previous_d = VectorXd::Zero(n),
          .held = std::vector<char>(static_cast<std::size_t>(n), 0)};
}

// f = ½ Σ w q²: sliders with targets at zero.
struct Quadratic {
  KinematicTree tree;
  IkProblem problem;
  IkTargets targets{IkProblem{}};

  explicit Quadratic(const std::vector<double>& weights) {
    MusculoskeletalModel model = empty_model();
    for (std::size_t i = 0; i < weights.size(); ++i) {
      add_body(model, static_cast<int>(i), Joint::Kind::kSlider, "t");
      const int q = static_cast<int>(i);
      problem.coordinates.push_back({q, q, weights[i]});
      targets.coordinates.push_back(0.0);
    }
    tree = compile_tree(model);
  }
};

// With an interpolated line search, which is exact on a parabola.
MinimizerOptions exact_search(Method method) {
  MinimizerOptions options = paper_options(method);
  options.always_interpolate = true;
  options.cost_tolerance = 0.0;
  options.record_iterations = true;
  return options;
}

TEST(SteepestDescent, TakesTheStepsOfTheTextbook) {
  const Quadratic p({1.0, 4.0});
  Minimizer minimizer(p.tree, p.problem, exact_search(Method::kSteepestDescent));
  std::vector<double> q = {4.0, 1.0};
  const Summary& summary = minimizer.minimize(p.targets, q);
  // g = (4, 4), α = gᵀg / gᵀHg = 0.4: to (2.4, −0.6). Then g = (2.4, −2.4): by symmetry every step
  // has the same length and leaves 0.36 of the cost.
  EXPECT_EQ(summary.initial_cost, 10.0);
  ASSERT_GE(summary.rows.size(), 10u);
  for (std::size_t k = 0; k < 10; ++k) {
    EXPECT_NEAR(summary.rows[k].step_length, 0.4, 1e-12);
    EXPECT_NEAR(summary.rows[k].f, 10.0 * std::pow(0.36, static_cast<double>(k + 1)), 1e-10);
    EXPECT_NEAR(summary.rows[k].step_norm, 1.6 * std::sqrt(2.0) * std::pow(0.6, k), 1e-10);
  }
  EXPECT_EQ(summary.termination, Termination::kGradient);
}

TEST(ConjugateGradient, EndsAQuadraticInAsManyStepsAsItHasCurvatures) {
  const Quadratic p({1.0, 2.0, 5.0, 10.0, 5.0, 1.0});
  Minimizer minimizer(p.tree, p.problem, exact_search(Method::kConjugateGradient));
  std::vector<double> q = {1.0, -2.0, 0.5, 0.3, -0.7, 1.5};
  const Summary& summary = minimizer.minimize(p.targets, q);
  EXPECT_EQ(summary.termination, Termination::kGradient);
  EXPECT_EQ(summary.iterations, 4);  // curvatures 1, 2, 5, 10
  EXPECT_LE(summary.final_cost, 1e-24);
}

// With exact searches from H₁ = E, BFGS walks as conjugate gradients do (Nazareth 1979).
TEST(Bfgs, WalksAQuadraticAsConjugateGradientsDo) {
  const Quadratic p({1.0, 2.0, 5.0, 10.0});
  const std::vector<double> start = {1.0, -2.0, 0.5, 0.3};
  Minimizer cg(p.tree, p.problem, exact_search(Method::kConjugateGradient));
  Minimizer bfgs(p.tree, p.problem, exact_search(Method::kBfgs));
  std::vector<double> q = start;
  const Summary& expected = cg.minimize(p.targets, q);
  q = start;
  const Summary& found = bfgs.minimize(p.targets, q);
  ASSERT_EQ(expected.iterations, 4);
  ASSERT_EQ(found.iterations, 4);
  for (std::size_t k = 0; k < 4; ++k) {
    EXPECT_NEAR(found.rows[k].f, expected.rows[k].f, 1e-12);
    EXPECT_NEAR(found.rows[k].step_norm, expected.rows[k].step_norm, 1e-10);
  }
}

// One iterate of a problem, as the minimizer hands it to a direction.
struct OneIterate {
  const RandomProblem& p;
  KinematicWorkspace ws = p.workspace();
  Iterate at;

  OneIterate(const RandomProblem& problem, double held_part)
      : p(problem), at(iterate_of(problem, ws)) {
    at.f = decomposed_gradient(p.tree, p.problem, p.targets, ws, at.g);
    RandomValues values(17);
    for (std::size_t i = 0; i < at.held.size(); ++i) {
      at.held[i] = values.uniform(0.0, 1.0) < held_part;
      if (at.held[i]) at.g[static_cast<Eigen::Index>(i)] = 0.0;
    }
  }
};

// (31)(32) over the unknowns that are not held, by a dense solve.
VectorXd expected_levenberg_marquardt(const OneIterate& one, double lambda) {
  const RandomProblem& p = one.p;
  const int n = p.tree.unknown_count();
  CostCurvature curvature(p.tree, p.problem);
  MatrixXd B(n, n);
  curvature.update(p.tree, p.problem, p.targets, one.ws);
  curvature.matrix(p.problem, p.targets, one.ws, B);
  std::vector<int> free;
  for (int x = 0; x < n; ++x) {
    if (!one.at.held[static_cast<std::size_t>(x)]) free.push_back(x);
  }
  MatrixXd M = B(free, free);
  M.diagonal().array() += one.at.f + lambda;
  VectorXd d = VectorXd::Zero(n);
  d(free) = -M.ldlt().solve(VectorXd(one.at.g(free)));
  return d;
}

TEST(LevenbergMarquardt, SolvesTheDampedNormalEquationsInEitherForm) {
  using Form = LevenbergMarquardt::Form;
  for (const ResidualKind kind : kResidualKinds) {
    for (unsigned seed = 0; seed < 4; ++seed) {
      const RandomProblem p = only(random_problem(seed, seed % 2 == 1), kind);
      for (const double held_part : {0.0, 0.3}) {
        OneIterate one(p, held_part);
        const VectorXd expected = expected_levenberg_marquardt(one, 0.001);
        for (const Form form : {Form::kPrimal, Form::kDual, Form::kSmaller}) {
          LevenbergMarquardt method(p.tree, p.problem, {.form = form});
          VectorXd d(p.tree.unknown_count());
          method.start();
          EXPECT_TRUE(method.compute(one.at, d));
          EXPECT_LE((d - expected).norm(), 1e-10 * expected.norm());
          for (Eigen::Index x = 0; x < d.size(); ++x) {
            if (one.at.held[static_cast<std::size_t>(x)]) {
              EXPECT_EQ(d[x], 0.0);
            }
          }
        }
      }
    }
  }
}

TEST(LevenbergMarquardt, WalksTheSameWayInEitherForm) {
  using Form = LevenbergMarquardt::Form;
  const RandomProblem p = only(random_problem(3, true), ResidualKind::kPosition);
  MinimizerOptions options;
  options.method = Method::kLevenbergMarquardt;
  options.max_iterations = 10;
  options.record_iterations = true;
  std::vector<Summary> found;
  for (const Form form : {Form::kPrimal, Form::kDual}) {
    options.levenberg_marquardt.form = form;
    std::vector<double> q = p.q;
    found.push_back(Minimizer(p.tree, p.problem, options).minimize(p.targets, q));
  }
  for (std::size_t k = 0; k < 10; ++k) {
    EXPECT_NEAR(found[1].rows[k].f, found[0].rows[k].f, 1e-9 * found[0].rows[k].f);
  }
}

// The Schur complement against an inverse.
TEST(Bfgs, EliminatesWhatComesToItsBound) {
  const Quadratic p({1.0, 2.0, 5.0});
  const Eigen::Matrix3d B = (Eigen::Matrix3d() << 4, 1, 0.5, 1, 3, -1, 0.5, -1, 5).finished();
  KinematicWorkspace ws(p.tree);
  Iterate at = iterate_of(p, ws);
  Bfgs bfgs(p.tree);
  bfgs.start();
  VectorXd d(3);
  // Conjugate steps of a quadratic fill H with its inverse.
  Eigen::Matrix3d S = Eigen::Matrix3d::Identity();
  S(0, 1) = -B(0, 1) / B(0, 0);
  S.col(2) -= S.col(0) * (S.col(0).dot(B * S.col(2)) / S.col(0).dot(B * S.col(0)));
  S.col(2) -= S.col(1) * (S.col(1).dot(B * S.col(2)) / S.col(1).dot(B * S.col(1)));
  for (int i = 0; i < 3; ++i) {
    at.iteration = i + 1;
    at.s = S.col(i);
    at.y = B * at.s;
    at.g = Eigen::Vector3d(1, -2, 3);
    bfgs.compute(at, d);
  }
  EXPECT_LE((d + B.inverse() * at.g).norm(), 1e-12);
  at.s = at.y = VectorXd::Zero(3);  // no curvature: the pair is passed over
  at.held = {0, 1, 0};
  at.g[1] = 0.0;
  bfgs.compute(at, d);
  const Eigen::Matrix2d B_free = (Eigen::Matrix2d() << 4, 0.5, 0.5, 5).finished();
  const Eigen::Vector2d expected = -B_free.inverse() * Eigen::Vector2d(1, 3);
  EXPECT_NEAR(d[0], expected[0], 1e-12);
  EXPECT_EQ(d[1], 0.0);
  EXPECT_NEAR(d[2], expected[1], 1e-12);
}

TEST(ConjugateGradient, StartsAgainWhereItsMemoryIsOfNoUse) {
  const Quadratic p({1.0, 2.0, 5.0});
  KinematicWorkspace ws(p.tree);
  Iterate at = iterate_of(p, ws);
  at.iteration = 1;
  at.g = Eigen::Vector3d(1, -2, 3);
  at.s = at.previous_d = Eigen::Vector3d(1, 1, 0);
  at.y = Eigen::Vector3d(2, 1, 0.5);
  ConjugateGradient method(p.tree, {});
  VectorXd d(3);
  EXPECT_TRUE(method.compute(at, d));
  // β = gᵀy/dᵀy − gᵀs/dᵀy = (2 − 2 + 1.5)/3 + 1/3
  EXPECT_LE((d - (-at.g + (1.5 / 3.0 + 1.0 / 3.0) * at.previous_d)).norm(), 1e-15);
  at.held = {0, 1, 0};  // a bound was met
  at.g[1] = 0.0;
  EXPECT_TRUE(method.compute(at, d));
  EXPECT_EQ(d, -at.g);
  at.y = -at.y;  // the cost curves downward
  EXPECT_TRUE(method.compute(at, d));
  EXPECT_EQ(d, -at.g);
  at.y = Eigen::Vector3d(1e-3, 0, 0);  // β (g·d) outweighs −g·g
  at.s.setZero();
  at.g = Eigen::Vector3d(1, 0, 0);
  at.previous_d = Eigen::Vector3d(1, 0, 1);
  EXPECT_TRUE(method.compute(at, d));
  EXPECT_EQ(d, -at.g);
}

class EveryMethodOnARandomTree : public testing::TestWithParam<Method> {};
INSTANTIATE_TEST_SUITE_P(Minimizer, EveryMethodOnARandomTree, testing::ValuesIn(all_methods()));

// The decomposed gradient against explicit Jacobians, eqs. (12) and (28): the same problem to
// rounding, which the iterations double every now and then.
TEST_P(EveryMethodOnARandomTree, WalksTheSameWayByEitherGradient) {
  for (unsigned seed = 0; seed < 4; ++seed) {
    const RandomProblem p = random_problem(seed, seed % 2 == 1);
    MinimizerOptions options;
    options.method = GetParam();
    options.max_iterations = 5;
    options.record_iterations = true;
    std::vector<Summary> found;
    for (const GradientKind gradient : {GradientKind::kDecomposed, GradientKind::kJacobian}) {
      options.gradient = gradient;
      std::vector<double> q = p.q;
      found.push_back(Minimizer(p.tree, p.problem, options).minimize(p.targets, q));
    }
    ASSERT_EQ(found[0].rows.size(), 5u);
    ASSERT_EQ(found[1].rows.size(), 5u);
    for (std::size_t k = 0; k < 5; ++k) {
      EXPECT_NEAR(found[1].rows[k].f, found[0].rows[k].f, 1e-9 * found[0].rows[k].f);
      EXPECT_NEAR(found[1].rows[k].step_norm, found[0].rows[k].step_norm,
                  1e-7 * found[0].rows[k].step_norm);
    }
  }
}

TEST(PaperOptions, AreThePapers) {
  for (const Method method : all_methods()) {
    const MinimizerOptions options = paper_options(method);
    options.validate();
    EXPECT_EQ(options.method, method);
    EXPECT_EQ(options.max_iterations, 100000);
    EXPECT_EQ(options.cost_tolerance, 1e-12);
    EXPECT_EQ(options.gradient_tolerance, 1e-12);
    EXPECT_EQ(options.test, GradientTest::kEuclidean);
    EXPECT_EQ(options.levenberg_marquardt.lambda, 0.001);
    EXPECT_EQ(options.conjugate_gradient.t, 1.0);
  }
}

}  // namespace
}  // namespace sinew
