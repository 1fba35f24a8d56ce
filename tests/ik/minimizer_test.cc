#include "ik/minimizer.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <random>

#include "ik/curvature.h"
#include "tests/ik/methods.h"
#include "tests/ik/walker.h"

namespace sinew {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr unsigned kSeeds = 10;

MinimizerOptions exact(Method method) {
  MinimizerOptions options;
  options.method = method;
  options.gradient_tolerance = 1e-12;  // of targets that are met, the root of the cost's 1e-24
  options.max_iterations = 100000;
  return options;
}

// The tolerance that recordings are solved with.
MinimizerOptions usual(Method method) {
  MinimizerOptions options;
  options.method = method;
  options.max_iterations = 100000;
  return options;
}

// Noise on every target, so that the cost at the minimum is far from zero.
void shake(IkTargets& targets, unsigned seed, double size) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> value(-size, size);
  for (Vector3d& p : targets.positions) p += Vector3d(value(random), value(random), value(random));
}

double largest_miss(const Walker& walker, const IkTargets& targets, const std::vector<double>& q) {
  const IkTargets found = walker.targets_at(q);
  double worst = 0.0;
  for (std::size_t i = 0; i < found.positions.size(); ++i) {
    if (std::isnan(targets.positions[i].x())) continue;
    worst = std::max(worst, (found.positions[i] - targets.positions[i]).norm());
  }
  return worst;
}

VectorXd gradient_at(const Walker& walker, const IkTargets& targets, const std::vector<double>& q) {
  KinematicWorkspace ws(walker.tree);
  ws.q = q;
  update_kinematics(walker.tree, ws);
  VectorXd g(walker.tree.unknown_count());
  decomposed_gradient(walker.tree, walker.problem, targets, ws, g);
  return g;
}

// How far a minimum can be where the gradient is this small: |g|₂/λ of the smallest curvature,
// which the residuals that are left may halve. Of coordinates that some marker sees.
double distance_bound(const Walker& walker, const IkTargets& targets, const std::vector<double>& q,
                      double gradient_norm) {
  KinematicWorkspace ws(walker.tree);
  ws.q = q;
  update_kinematics(walker.tree, ws);
  CostCurvature curvature(walker.tree, walker.problem);
  const int n = walker.tree.unknown_count();
  Eigen::MatrixXd H(n, n);
  curvature.update(walker.tree, walker.problem, targets, ws);
  curvature.matrix(walker.problem, targets, ws, H);
  const VectorXd lambda = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(H).eigenvalues();
  EXPECT_LE(lambda[0], 1e-12);  // the coordinate that none sees
  EXPECT_GE(lambda[1], 1e-3);
  return 2.0 * std::sqrt(n) * gradient_norm / lambda[1];
}

// Both have gradients below a tolerance; the second is the exact one.
void expect_same_minimum(const Walker& walker, const IkTargets& targets, const Summary& found,
                         const std::vector<double>& q, const Summary& expected,
                         const std::vector<double>& reference) {
  const double bound =
      distance_bound(walker, targets, reference, found.gradient_norm + expected.gradient_norm);
  EXPECT_LE(bound, 1e-4);
  const double rounding = 1e-12 * expected.final_cost;
  EXPECT_NEAR(found.final_cost, expected.final_cost, bound * found.gradient_norm + rounding);
  for (std::size_t i = 0; i < q.size(); ++i) EXPECT_NEAR(q[i], reference[i], bound + 1e-12) << i;
}

class EveryMethod : public testing::TestWithParam<Method> {};
INSTANTIATE_TEST_SUITE_P(Minimizer, EveryMethod, testing::ValuesIn(kEveryMethod), test_name_of);

TEST_P(EveryMethod, MeetsTargetsWithinReach) {
  for (const bool quaternions : {false, true}) {
    const Walker walker(quaternions);
    Minimizer minimizer(walker.tree, walker.problem, exact(GetParam()));
    for (unsigned seed = 0; seed < kSeeds; ++seed) {
      const IkTargets targets = walker.targets_at(walker.pose(seed, 0.4));
      std::vector<double> q = walker.tree.default_q;
      const Summary& summary = minimizer.minimize(targets, q);
      EXPECT_TRUE(summary.converged()) << summary.message();
      EXPECT_LE(largest_miss(walker, targets, q), 1e-8) << seed;
    }
  }
}

TEST_P(EveryMethod, MeetsOrientationsDistancesAndCoordinates) {
  Walker walker;
  walker.problem.positions.clear();
  const int links = walker.tree.link_count();
  for (int b = 1; b < links; ++b) walker.problem.orientations.push_back({b});
  const auto pelvis = walker.problem.orientations[0].link;
  const Vector3d anchors[] = {{1, 0, 0}, {-1, 0, 0.5}, {0, 0, 1}, {0, 3, -1}};
  for (const Vector3d& anchor : anchors) {
    walker.problem.distances.push_back({0, pelvis, anchor, Vector3d::Zero()});
  }
  const auto c = static_cast<std::size_t>(walker.dependent);
  walker.problem.coordinates = {{walker.tree.q_of_coordinate[c], walker.tree.v_of_coordinate[c]}};
  for (unsigned seed = 0; seed < kSeeds; ++seed) {
    std::vector<double> truth = walker.pose(seed, 0.3);
    KinematicWorkspace ws(walker.tree);
    ws.q = truth;
    update_poses(walker.tree, ws);
    IkTargets targets(walker.problem);
    for (std::size_t i = 0; i < targets.orientations.size(); ++i) {
      targets.orientations[i] = ws.X_WB[i + 1].R;
    }
    for (std::size_t i = 0; i < targets.distances.size(); ++i) {
      targets.distances[i] = (anchors[i] - ws.X_WB[static_cast<std::size_t>(pelvis)].p).norm();
    }
    targets.coordinates[0] = ws.q[static_cast<std::size_t>(walker.problem.coordinates[0].q)];
    std::vector<double> q = walker.tree.default_q;
    Minimizer minimizer(walker.tree, walker.problem, exact(GetParam()));
    const Summary& summary = minimizer.minimize(targets, q);
    EXPECT_TRUE(summary.converged()) << summary.message();
    EXPECT_LE(summary.final_cost, 1e-16) << seed;
    for (std::size_t i = 0; i < q.size(); ++i) EXPECT_NEAR(q[i], ws.q[i], 1e-7) << seed << " " << i;
  }
}

TEST_P(EveryMethod, FindsTheMinimumOfNoisyTargetsThatTheOthersFind) {
  const Walker walker;
  for (unsigned seed = 0; seed < kSeeds; ++seed) {
    IkTargets targets = walker.targets_at(walker.pose(seed, 0.3));
    shake(targets, seed, 0.02);
    std::vector<double> q = walker.tree.default_q, reference = q;
    const Summary found =
        Minimizer(walker.tree, walker.problem, usual(GetParam())).minimize(targets, q);
    const Summary expected = Minimizer(walker.tree, walker.problem, exact(Method::kGaussNewton))
                                 .minimize(targets, reference);
    EXPECT_GE(expected.final_cost, 1e-3);
    EXPECT_EQ(found.termination, Termination::kGradient) << found.message();
    expect_same_minimum(walker, targets, found, q, expected, reference);
  }
}

// Bounds through the middle of where the coordinates would go.
Walker bounded_walker(const std::vector<double>& truth) {
  Walker walker;
  for (const Coordinate& c : walker.model.coordinates) {
    const auto i = static_cast<std::size_t>(&c - walker.model.coordinates.data());
    if (static_cast<int>(i) == walker.dependent || static_cast<int>(i) == walker.locked) continue;
    if (i % 3 == 2) continue;
    const double there = truth[static_cast<std::size_t>(walker.tree.q_of_coordinate[i])];
    const double start = c.default_value;
    // Every other bound binds, half way there; the others are just beyond.
    const double reach = i % 2 == 0 ? 0.5 * there : 1.2 * there;
    clamp(walker.model.coordinates[i], std::min(start, reach) - (there > start ? 0.1 : 0.0),
          std::max(start, reach) + (there > start ? 0.0 : 0.1));
  }
  walker.compile();
  return walker;
}

// Karush-Kuhn-Tucker: inside, at every unknown, and the gradient pushes against what holds.
void expect_minimum_within_bounds(const Walker& walker, const IkTargets& targets,
                                  const std::vector<double>& q, const Summary& summary,
                                  double tolerance) {
  const KinematicTree& tree = walker.tree;
  const VectorXd g = gradient_at(walker, targets, q);
  int held = 0;
  for (int x = 0; x < tree.unknown_count(); ++x) {
    const auto i = static_cast<std::size_t>(x);
    const double value =
        q[static_cast<std::size_t>(tree.q_of_v[static_cast<std::size_t>(tree.unknown_v[i])])];
    EXPECT_GE(value, tree.lower[i]);
    EXPECT_LE(value, tree.upper[i]);
    const bool at_lower = value == tree.lower[i], at_upper = value == tree.upper[i];
    EXPECT_TRUE(at_lower || g[x] <= tolerance) << x << ": " << g[x];
    EXPECT_TRUE(at_upper || g[x] >= -tolerance) << x << ": " << g[x];
    held += (at_lower && g[x] > 0.0) || (at_upper && g[x] < 0.0);
  }
  EXPECT_EQ(summary.held, held);
}

TEST_P(EveryMethod, EndsInsideBoundsWhereTheGradientPushesOutward) {
  int held = 0;
  for (unsigned seed = 0; seed < kSeeds; ++seed) {
    const std::vector<double> truth = Walker().pose(seed, 0.2);
    const Walker walker = bounded_walker(truth);
    const IkTargets targets = walker.targets_at(truth);
    Minimizer minimizer(walker.tree, walker.problem, usual(GetParam()));
    std::vector<double> q = walker.tree.default_q;
    const Summary& summary = minimizer.minimize(targets, q);
    EXPECT_EQ(summary.termination, Termination::kGradient) << summary.message();
    const double scale = static_cast<double>(walker.problem.positions.size());
    expect_minimum_within_bounds(walker, targets, q, summary, 1e-9 * scale);
    held += summary.held;
  }
  EXPECT_GE(held, 2 * static_cast<int>(kSeeds));
}

TEST_P(EveryMethod, AgreesWithTheOthersWithinBounds) {
  for (unsigned seed = 0; seed < kSeeds; ++seed) {
    const std::vector<double> truth = Walker().pose(seed, 0.2);
    const Walker walker = bounded_walker(truth);
    const IkTargets targets = walker.targets_at(truth);
    std::vector<double> q = walker.tree.default_q, reference = q;
    const Summary found =
        Minimizer(walker.tree, walker.problem, usual(GetParam())).minimize(targets, q);
    const Summary expected = Minimizer(walker.tree, walker.problem, exact(Method::kGaussNewton))
                                 .minimize(targets, reference);
    EXPECT_EQ(found.held, expected.held);
    expect_same_minimum(walker, targets, found, q, expected, reference);
  }
}

TEST_P(EveryMethod, StartsInsideBoundsWhereverItIsStarted) {
  const std::vector<double> truth = Walker().pose(3, 0.2);
  const Walker walker = bounded_walker(truth);
  const IkTargets targets = walker.targets_at(truth);
  std::vector<double> q = walker.tree.default_q, far = q;
  for (const int v : walker.tree.unknown_v) {
    far[static_cast<std::size_t>(walker.tree.q_of_v[static_cast<std::size_t>(v)])] += 0.3;
  }
  const Summary near_summary =
      Minimizer(walker.tree, walker.problem, usual(GetParam())).minimize(targets, q);
  const Summary far_summary =
      Minimizer(walker.tree, walker.problem, usual(GetParam())).minimize(targets, far);
  EXPECT_EQ(far_summary.held, near_summary.held);
  walker.value(far, walker.unseen) = walker.value(q, walker.unseen);  // which stays where it was
  expect_same_minimum(walker, targets, far_summary, far, near_summary, q);
}

TEST_P(EveryMethod, LeavesOutWhatIsNotMeasured) {
  Walker walker;
  const IkTargets all = walker.targets_at(walker.pose(1, 0.3));
  IkTargets some = all;
  Walker fewer = walker;
  IkTargets wanted{IkProblem{}};
  fewer.problem.positions.clear();
  for (std::size_t i = 0; i < all.positions.size(); ++i) {
    some.positions[i] += Vector3d(0.01, 0.0, -0.01) * std::sin(static_cast<double>(i));
    if (i % 5 == 0) {
      some.positions[i].setConstant(kNaN);
    } else {
      fewer.problem.positions.push_back(walker.problem.positions[i]);
      wanted.positions.push_back(some.positions[i]);
    }
  }
  std::vector<double> q = walker.tree.default_q, reference = q;
  const Summary found = Minimizer(walker.tree, walker.problem, usual(GetParam())).minimize(some, q);
  const Summary expected =
      Minimizer(fewer.tree, fewer.problem, exact(Method::kGaussNewton)).minimize(wanted, reference);
  EXPECT_TRUE(found.converged()) << found.message();
  expect_same_minimum(walker, some, found, q, expected, reference);
}

TEST_P(EveryMethod, StaysWhereNothingIsMeasured) {
  const Walker walker;
  std::vector<double> q = walker.pose(1, 0.3);
  KinematicWorkspace ws(walker.tree);  // with dependent coordinates set
  ws.q = q;
  update_poses(walker.tree, ws);
  const Summary summary = Minimizer(walker.tree, walker.problem, exact(GetParam()))
                              .minimize(IkTargets(walker.problem), q);
  EXPECT_EQ(summary.termination, Termination::kGradient);
  EXPECT_EQ(summary.iterations, 0);
  EXPECT_EQ(summary.final_cost, 0.0);
  EXPECT_EQ(q, ws.q);
}

TEST_P(EveryMethod, LeavesUndeterminedAndLockedCoordinatesWhereTheyAre) {
  const Walker walker;
  const IkTargets targets = walker.targets_at(walker.pose(2, 0.3));
  std::vector<double> q = walker.tree.default_q;
  walker.value(q, walker.unseen) = 0.37;
  walker.value(q, walker.locked) = 0.2;
  Minimizer(walker.tree, walker.problem, exact(GetParam())).minimize(targets, q);
  EXPECT_EQ(walker.value(q, walker.unseen), 0.37);
  EXPECT_EQ(walker.value(q, walker.locked), 0.2);
  EXPECT_LE(largest_miss(walker, targets, q), 1e-8);
}

TEST_P(EveryMethod, GivesTheSameBitsWheneverItIsAsked) {
  const Walker walker;
  Minimizer minimizer(walker.tree, walker.problem, exact(GetParam()));
  const IkTargets targets = walker.targets_at(walker.pose(4, 0.3));
  std::vector<double> first = walker.tree.default_q, again = first, fresh = first;
  minimizer.minimize(targets, first);
  std::vector<double> other = walker.tree.default_q;
  minimizer.minimize(walker.targets_at(walker.pose(5, 0.5)), other);
  minimizer.minimize(targets, again);
  Minimizer(walker.tree, walker.problem, exact(GetParam())).minimize(targets, fresh);
  EXPECT_EQ(first, again);
  EXPECT_EQ(first, fresh);
}

TEST_P(EveryMethod, TakesTheSameWayByEitherGradient) {
  const Walker walker;
  IkTargets targets = walker.targets_at(walker.pose(6, 0.3));
  shake(targets, 6, 0.02);
  MinimizerOptions options = usual(GetParam());
  std::vector<double> q = walker.tree.default_q, by_jacobian = q;
  const Summary found = Minimizer(walker.tree, walker.problem, options).minimize(targets, q);
  options.gradient = GradientKind::kJacobian;
  const Summary expected =
      Minimizer(walker.tree, walker.problem, options).minimize(targets, by_jacobian);
  EXPECT_TRUE(expected.converged()) << expected.message();
  expect_same_minimum(walker, targets, found, q, expected, by_jacobian);
}

TEST_P(EveryMethod, SaysInItsSummaryWhatHappened) {
  const Walker walker;
  IkTargets targets = walker.targets_at(walker.pose(7, 0.3));
  shake(targets, 7, 0.02);
  MinimizerOptions options = usual(GetParam());
  options.record_iterations = true;
  Minimizer minimizer(walker.tree, walker.problem, options);
  std::vector<double> q = walker.tree.default_q;
  KinematicWorkspace ws(walker.tree);
  update_poses(walker.tree, ws);
  const double initial_cost = cost(walker.tree, walker.problem, targets, ws);
  const Summary& summary = minimizer.minimize(targets, q);
  ws.q = q;
  update_poses(walker.tree, ws);
  EXPECT_EQ(summary.termination, Termination::kGradient);
  EXPECT_EQ(summary.initial_cost, initial_cost);
  EXPECT_EQ(summary.final_cost, cost(walker.tree, walker.problem, targets, ws));
  const double norm = gradient_at(walker, targets, q).cwiseAbs().maxCoeff();
  EXPECT_DOUBLE_EQ(summary.gradient_norm, norm);
  EXPECT_LT(norm, 1e-9 * static_cast<double>(walker.problem.positions.size()));
  EXPECT_EQ(summary.held, 0);
  EXPECT_GT(summary.seconds, 0.0);
  ASSERT_EQ(static_cast<int>(summary.rows.size()), summary.iterations);
  EXPECT_GE(summary.evaluations, summary.iterations + 1);
  double f = initial_cost;
  for (std::size_t i = 0; i < summary.rows.size(); ++i) {
    const IterationRow& row = summary.rows[i];
    EXPECT_EQ(row.iteration, static_cast<int>(i) + 1);
    EXPECT_LE(row.f, f * (1.0 + 1e-13));
    EXPECT_GT(row.step_length, 0.0);
    EXPECT_GT(row.step_norm, 0.0);
    f = row.f;
  }
  EXPECT_EQ(f, summary.final_cost);
  EXPECT_EQ(summary.rows.back().gradient_norm, summary.gradient_norm);
  EXPECT_EQ(minimizer.workspace().q, q);
  EXPECT_EQ(summary.message().substr(0, 36),
            "converged: the gradient's norm is " + summary.message().substr(34, 2));
}

TEST_P(EveryMethod, StopsAtTheMostIterations) {
  const Walker walker;
  const IkTargets targets = walker.targets_at(walker.pose(8, 0.4));
  MinimizerOptions options = exact(GetParam());
  options.max_iterations = 1;
  std::vector<double> q = walker.tree.default_q;
  Minimizer minimizer(walker.tree, walker.problem, options);
  const Summary& summary = minimizer.minimize(targets, q);
  EXPECT_EQ(summary.termination, Termination::kMaxIterations);
  EXPECT_EQ(summary.iterations, 1);
  EXPECT_FALSE(summary.converged());
  EXPECT_LT(summary.final_cost, summary.initial_cost);
  EXPECT_EQ(summary.message().find("not converged after 1 iterations; the gradient's norm is "), 0u)
      << summary.message();
}

TEST_P(EveryMethod, StopsWhereTheCostNoLongerChanges) {
  const Walker walker;
  IkTargets targets = walker.targets_at(walker.pose(9, 0.3));
  shake(targets, 9, 0.02);
  MinimizerOptions options = exact(GetParam());
  options.gradient_tolerance = 0.0;
  options.cost_tolerance = 1e-7;
  options.record_iterations = true;
  std::vector<double> q = walker.tree.default_q;
  Minimizer minimizer(walker.tree, walker.problem, options);
  const Summary& summary = minimizer.minimize(targets, q);
  EXPECT_EQ(summary.termination, Termination::kCostChange);
  EXPECT_TRUE(summary.converged());
  ASSERT_GE(summary.rows.size(), 3u);
  for (std::size_t i = 1; i < summary.rows.size(); ++i) {
    const bool last = i + 1 == summary.rows.size();
    EXPECT_EQ(std::abs(summary.rows[i].f - summary.rows[i - 1].f) < 1e-7, last);
  }
  EXPECT_EQ(summary.message().find("converged: the cost no longer changes at "), 0u);
}

TEST_P(EveryMethod, StallsAtTheLimitOfRounding) {
  const Walker walker;
  IkTargets targets = walker.targets_at(walker.pose(10, 0.3));
  shake(targets, 10, 0.02);
  MinimizerOptions options = exact(GetParam());
  options.gradient_tolerance = 0.0;
  std::vector<double> q = walker.tree.default_q;
  Minimizer minimizer(walker.tree, walker.problem, options);
  const Summary& summary = minimizer.minimize(targets, q);
  EXPECT_EQ(summary.termination, Termination::kStalled) << summary.message();
  EXPECT_LE(summary.gradient_norm, 1e-8);
  EXPECT_EQ(summary.message().find("no step lowers the cost "), 0u) << summary.message();
}

TEST_P(EveryMethod, ReturnsAtOnceFromAStartThatIsNotANumber) {
  const Walker walker;
  const IkTargets targets = walker.targets_at(walker.pose(1, 0.3));
  Minimizer minimizer(walker.tree, walker.problem, exact(GetParam()));
  std::vector<double> good = walker.tree.default_q;
  minimizer.minimize(targets, good);
  std::vector<double> q = walker.tree.default_q;
  q[3] = kNaN;
  const Summary& summary = minimizer.minimize(targets, q);
  EXPECT_EQ(summary.termination, Termination::kNotFinite);
  EXPECT_FALSE(summary.converged());
  EXPECT_EQ(summary.iterations, 0);
  EXPECT_EQ(summary.evaluations, 1);
  EXPECT_TRUE(std::isnan(summary.final_cost));
  EXPECT_TRUE(std::isnan(summary.gradient_norm));
  EXPECT_EQ(summary.message(), "the cost or its gradient is not a number at the start");
  std::vector<double> again = walker.tree.default_q;
  EXPECT_TRUE(minimizer.minimize(targets, again).converged());
  EXPECT_EQ(again, good);
}

TEST_P(EveryMethod, HasNothingToDoWithoutUnknowns) {
  Walker walker;
  walker.model.couplers.clear();
  for (Coordinate& c : walker.model.coordinates) c.locked = true;
  walker.compile();
  const IkTargets targets = Walker().targets_at(Walker().pose(1, 0.3));
  std::vector<double> q = walker.tree.default_q;
  const Summary summary =
      Minimizer(walker.tree, walker.problem, exact(GetParam())).minimize(targets, q);
  EXPECT_EQ(summary.termination, Termination::kGradient);
  EXPECT_GT(summary.final_cost, 0.0);
  EXPECT_EQ(q, walker.tree.default_q);
}

TEST_P(EveryMethod, HasANameThatIsReadBack) {
  EXPECT_EQ(method_from_string(to_string(GetParam())), GetParam());
}

TEST(MethodNames, AreListedForAnUnknownOne) {
  try {
    method_from_string("newtonian");
    ADD_FAILURE() << "was taken";
  } catch (const std::invalid_argument& error) {
    for (const Method method : kEveryMethod) {
      EXPECT_NE(std::string(error.what()).find(to_string(method)), std::string::npos);
    }
    EXPECT_EQ(std::string(error.what()).find("there is no method 'newtonian'; expected one of "),
              0u);
  }
}

std::string error_of(const MinimizerOptions& options) {
  try {
    options.validate();
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "no error";
}

TEST(MinimizerOptions, AreRejectedByFieldValueAndBound) {
  EXPECT_EQ(error_of({}), "no error");
  MinimizerOptions options;
  options.gradient_tolerance = -1e-9;
  EXPECT_EQ(error_of(options), "MinimizerOptions.gradient_tolerance is -1e-09; expected 0 or more");
  options = {};
  options.cost_tolerance = kNaN;
  EXPECT_EQ(error_of(options), "MinimizerOptions.cost_tolerance is nan; expected 0 or more");
  options = {};
  options.max_iterations = 0;
  EXPECT_EQ(error_of(options), "MinimizerOptions.max_iterations is 0; expected 1 or more");
  options = {};
  options.time_limit = 0.0;
  EXPECT_EQ(error_of(options), "MinimizerOptions.time_limit is 0; expected more than 0");
  options = {};
  options.largest_turn = -1.0;
  EXPECT_EQ(error_of(options), "MinimizerOptions.largest_turn is -1; expected more than 0");
  options = {};
  options.lbfgs.memory = 0;
  EXPECT_EQ(error_of(options), "MinimizerOptions.lbfgs.memory is 0; expected 1 or more");
  options = {};
  options.gauss_newton.damping = 0.0;
  EXPECT_EQ(error_of(options), "MinimizerOptions.gauss_newton.damping is 0; expected more than 0");
  EXPECT_THROW(Minimizer(KinematicTree{}, IkProblem{}, options), std::invalid_argument);
}

TEST(Summary, SaysThatNothingWasStarted) { EXPECT_EQ(Summary().message(), "not started"); }

}  // namespace
}  // namespace sinew
