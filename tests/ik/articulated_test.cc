#include "ik/articulated.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>

#include "ik/curvature.h"
#include "ik/manipulator_case.h"
#include "ik/minimizer.h"
#include "tests/ik/random_problem.h"
#include "tests/ik/small_model.h"

namespace sinew {
namespace {

// A problem that one sweep solves exactly: no couplers, no residual between two links, orientation
// weights that are multiples of E, no ellipsoid joints. Targets stand near the pose, so that the
// cost curves upward.
RandomProblem sweep_problem(unsigned seed, bool quaternions, double distance) {
  RandomProblem p;
  p.model = random_model(seed, {.coupler_count = 0, .for_quaternions = quaternions});
  for (Joint& joint : p.model.joints) {
    if (joint.kind == Joint::Kind::kEllipsoid) joint.kind = Joint::Kind::kGimbal;
  }
  p.tree = compile_tree(p.model, {.quaternions = quaternions});
  RandomValues values(seed + 2000);
  p.q = random_q(p.tree, values, 0.8);
  const KinematicWorkspace ws = p.workspace();
  for (int link = 1; link < p.tree.link_count(); ++link) {
    const RigidTransform& X = ws.X_WB[static_cast<std::size_t>(link)];
    for (int i = 0; i < 3; ++i) {
      const Eigen::Vector3d place = values.vector(0.4);
      p.problem.positions.push_back({link, place, values.weight()});
      p.targets.positions.push_back(X * place + values.vector(distance));
    }
    p.problem.orientations.push_back(
        {link, values.rotation(3.0), values.uniform(0.5, 2.0) * Eigen::Matrix3d::Identity()});
    p.targets.orientations.push_back(values.rotation(distance) * X.R *
                                     p.problem.orientations.back().R_BF);
  }
  add_random_coordinate_targets(p, values);
  validate(p.tree, p.problem, p.targets);
  return p;
}

Iterate iterate_at(const RandomProblem& p, KinematicWorkspace& ws) {
  const int n = p.tree.unknown_count();
  Iterate at{p.tree,
             p.problem,
             &p.targets,
             ws,
             0,
             0.0,
             Eigen::VectorXd(n),
             Eigen::VectorXd::Zero(n),
             Eigen::VectorXd::Zero(n),
             Eigen::VectorXd::Zero(n),
             std::vector<char>(static_cast<std::size_t>(n), 0)};
  at.f = decomposed_gradient(p.tree, p.problem, p.targets, ws, at.g);
  return at;
}

Eigen::VectorXd gradient_at(const RandomProblem& p, const Eigen::VectorXd& step) {
  KinematicWorkspace ws(p.tree);
  advance(p.tree, p.q, {step.data(), static_cast<std::size_t>(step.size())}, ws.q);
  update_kinematics(p.tree, ws);
  Eigen::VectorXd g(p.tree.unknown_count());
  decomposed_gradient(p.tree, p.problem, p.targets, ws, g);
  return g;
}

// Second derivatives along exponential steps: the symmetric part of the gradient's differences,
// whose other part is the turning of the tangent space itself.
Eigen::MatrixXd hessian_by_differences(const RandomProblem& p) {
  const int n = p.tree.unknown_count();
  constexpr double kStep = 1e-5;
  Eigen::MatrixXd H(n, n);
  for (int x = 0; x < n; ++x) {
    const Eigen::VectorXd step = kStep * Eigen::VectorXd::Unit(n, x);
    H.col(x) = (gradient_at(p, step) - gradient_at(p, -step)) / (2.0 * kStep);
  }
  return 0.5 * (H + H.transpose());
}

class ArticulatedSweeps : public testing::TestWithParam<std::tuple<unsigned, bool>> {};

// Taut wires and distances, each across one joint.
void add_joint_wires(RandomProblem& p, RandomValues& values) {
  const KinematicWorkspace ws = p.workspace();
  for (int link = 2; link < p.tree.link_count(); link += 2) {
    const int parent = p.tree.links[static_cast<std::size_t>(link)].parent;
    WireResidual wire{static_cast<int>(p.problem.wire_points.size()), 3, 0.0, 2.0};
    p.problem.wire_points.push_back({parent, values.vector(0.4)});
    p.problem.wire_points.push_back({link, values.vector(0.4)});
    p.problem.wire_points.push_back({parent, values.vector(0.4)});
    wire.natural_length = 0.8 * wire_length(p.problem, wire, ws);
    p.problem.wires.push_back(wire);
    p.problem.distances.push_back({parent, link, values.vector(0.4), values.vector(0.4), 3.0});
    p.targets.distances.push_back(0.3);
  }
}

TEST(ArticulatedSweep, FitsWiresAcrossOneJointOnly) {
  RandomProblem p = sweep_problem(1, false, 0.3);
  RandomValues values(7);
  EXPECT_TRUE(articulated_sweep_fits(p.tree, p.problem));
  add_joint_wires(p, values);
  EXPECT_TRUE(articulated_sweep_fits(p.tree, p.problem));
  p.problem.distances.push_back(
      {0, p.tree.link_count() - 1, values.vector(0.4), values.vector(0.4), 3.0});
  EXPECT_FALSE(articulated_sweep_fits(p.tree, p.problem));
}

TEST_P(ArticulatedSweeps, GaussNewtonSolvesTheDenseEquations) {
  const auto [seed, quaternions] = GetParam();
  RandomProblem p = sweep_problem(seed, quaternions, 0.3);
  RandomValues values(seed + 3000);
  add_joint_wires(p, values);
  validate(p.tree, p.problem, p.targets);
  KinematicWorkspace ws = p.workspace();
  Iterate at = iterate_at(p, ws);
  at.held[2] = 1;
  at.g[2] = 0.0;
  Articulated articulated(p.tree, p.problem, Articulated::Model::kGaussNewton, {.damping = 1e-6});
  articulated.start();
  Eigen::VectorXd d(p.tree.unknown_count());
  ASSERT_TRUE(articulated.compute(at, d));

  CostCurvature curvature(p.tree, p.problem);
  Eigen::MatrixXd H(d.size(), d.size());
  curvature.update(p.tree, p.problem, p.targets, ws);
  curvature.matrix(p.problem, p.targets, ws, H);
  H.diagonal().array() += articulated.damping();
  H.row(2).setZero();
  H.col(2).setZero();
  H(2, 2) = 1.0;
  const Eigen::VectorXd expected = -H.llt().solve(at.g);
  EXPECT_LT((d - expected).norm(), 1e-8 * expected.norm());
  EXPECT_EQ(d[2], 0.0);
  const double decrease =
      -at.g.dot(d) - 0.5 * d.dot((H * d).eval()) + 0.5 * articulated.damping() * d.squaredNorm();
  EXPECT_NEAR(articulated.expected_decrease(), decrease, 1e-9 * std::abs(decrease));
}

TEST_P(ArticulatedSweeps, NewtonSolvesWithTheHessianOfTheCost) {
  const auto [seed, quaternions] = GetParam();
  const RandomProblem p = sweep_problem(seed, quaternions, 0.1);
  KinematicWorkspace ws = p.workspace();
  const Iterate at = iterate_at(p, ws);
  Articulated articulated(p.tree, p.problem, Articulated::Model::kNewton, {.damping = 1e-9});
  articulated.start();
  Eigen::VectorXd d(p.tree.unknown_count());
  ASSERT_TRUE(articulated.compute(at, d));
  const Eigen::MatrixXd H = hessian_by_differences(p);
  // Differences of the gradient are good to about 1e-9 of the largest curvature.
  const Eigen::VectorXd residual = H * d + articulated.damping() * d + at.g;
  EXPECT_LT(residual.norm(), 1e-6 * at.g.norm());
  // The second-order terms matter here: Gauss-Newton's matrix does not solve it.
  CostCurvature curvature(p.tree, p.problem);
  Eigen::MatrixXd J(d.size(), d.size());
  curvature.update(p.tree, p.problem, p.targets, ws);
  curvature.matrix(p.problem, p.targets, ws, J);
  EXPECT_GT((J * d + at.g).norm(), 1e-3 * at.g.norm());
}

// A chain of pins, each bounded, with two markers on every body.
struct BoundedChain {
  MusculoskeletalModel model = empty_model();
  KinematicTree tree;
  IkProblem problem;

  explicit BoundedChain(int links) {
    int parent = 0;
    for (int i = 0; i < links; ++i) {
      parent = add_body(model, parent, Joint::Kind::kPin, "r", {0.1, 0.0, 0.0});
      model.joints.back().X_PF.R = rotation_from_body_xyz({0.3 * i, 0.2, 0.0});
      clamp(model.coordinates.back(), -0.05, 0.05);
      problem.positions.push_back({parent, {0.0, 0.1, 0.0}});
      problem.positions.push_back({parent, {0.0, 0.0, 0.1}});
    }
    tree = compile_tree(model);
  }
  // Where the markers are with every joint at `angle`, some beyond its bounds, and off by 0.02 m.
  IkTargets targets(double angle) const {
    IkTargets targets(problem);
    KinematicWorkspace ws(tree);
    RandomValues values(7);
    for (double& q : ws.q) q = angle + values.uniform(-0.03, 0.03);
    update_poses(tree, ws);
    for (std::size_t i = 0; i < problem.positions.size(); ++i) {
      const PositionResidual& r = problem.positions[i];
      targets.positions[i] =
          ws.X_WB[static_cast<std::size_t>(r.link)] * r.p_BP + values.vector(0.02);
    }
    return targets;
  }
};

TEST(ArticulatedSweepIsFaster, OnLongChainsOnly) {
  for (const int links : {1, 4, 10}) {
    const ManipulatorCase c = make_manipulator_case('A', links);
    EXPECT_FALSE(articulated_sweep_is_faster(c.tree, c.problem)) << links;
  }
  for (const int links : {40, 400}) {
    const ManipulatorCase c = make_manipulator_case('A', links);
    EXPECT_TRUE(articulated_sweep_is_faster(c.tree, c.problem)) << links;
  }
  ManipulatorCase coupled = make_manipulator_case('A', 400);
  coupled.problem.distances.push_back({1, 9});  // across several joints: no sweep
  EXPECT_FALSE(articulated_sweep_is_faster(coupled.tree, coupled.problem));
}

TEST(ArticulatedSweepIsFaster, IsWhatTheDefaultMethodGoesBy) {
  const BoundedChain chain(150);
  MinimizerOptions options;
  EXPECT_EQ(resolved_method(chain.tree, chain.problem, options), Method::kArticulated);
  options.gradient = GradientKind::kJacobian;  // leaves no sweep to continue
  EXPECT_EQ(resolved_method(chain.tree, chain.problem, options), Method::kGaussNewton);
  const BoundedChain small(12);
  EXPECT_EQ(resolved_method(small.tree, small.problem, {}), Method::kGaussNewton);
}

// Both ways of the default method, on a chain many of whose joints end at bounds.
TEST(ArticulatedSweepIsFaster, EndsAtTheMinimumOfTheFactorization) {
  const BoundedChain chain(150);
  for (const double angle : {0.0, 0.03, 0.05}) {
    const IkTargets targets = chain.targets(angle);
    std::vector<double> swept = chain.tree.default_q, factorized = swept;
    // The last joint's curvature is 0.02, the weights' sum 300: 1e-9 leaves its angle 1e-5 and
    // more.
    MinimizerOptions options;
    options.gradient_tolerance = 1e-11;
    Minimizer sweep(chain.tree, chain.problem, options);
    const Summary by_sweep = sweep.minimize(targets, swept);
    options.gradient = GradientKind::kJacobian;
    Minimizer factorization(chain.tree, chain.problem, options);
    const Summary by_factorization = factorization.minimize(targets, factorized);
    EXPECT_TRUE(by_sweep.converged()) << by_sweep.message();
    EXPECT_TRUE(by_factorization.converged()) << by_factorization.message();
    EXPECT_GT(by_sweep.held, 10);
    EXPECT_EQ(by_sweep.held, by_factorization.held);
    EXPECT_NEAR(by_sweep.final_cost, by_factorization.final_cost,
                1e-9 * by_factorization.final_cost);
    for (std::size_t i = 0; i < swept.size(); ++i) EXPECT_NEAR(swept[i], factorized[i], 1e-5);
  }
}

INSTANTIATE_TEST_SUITE_P(RandomTrees, ArticulatedSweeps,
                         testing::Combine(testing::Values(1u, 2u, 3u, 4u), testing::Bool()));

}  // namespace
}  // namespace sinew
