#include "ik/cold_start.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "tests/ik/walker.h"

namespace sinew {
namespace {

// A walker whose joints are bounded as a person's are. Markers made from a pose within the bounds
// leave a cost of zero there, which is the lowest there can be.
Walker bounded_walker() {
  Walker walker;
  for (std::size_t c = 6; c < walker.model.coordinates.size(); ++c) {
    clamp(walker.model.coordinates[c], -0.6, 2.4);
  }
  walker.compile();
  return walker;
}

std::vector<double> pose_within(const Walker& walker, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  std::vector<double> q = walker.pose(seed, 1.5);
  for (std::size_t x = 6; x < walker.tree.unknown_v.size(); ++x) {
    const int entry = walker.tree.q_of_v[static_cast<std::size_t>(walker.tree.unknown_v[x])];
    q[static_cast<std::size_t>(entry)] =
        walker.tree.lower[x] + unit(random) * (walker.tree.upper[x] - walker.tree.lower[x]);
  }
  return q;
}

// So small a cost means that every marker is met to a thousandth of a millimetre.
constexpr double kMet = 1e-12;

TEST(ColdStart, FindsPosesThatASingleStartMisses) {
  const Walker walker = bounded_walker();
  Minimizer single(walker.tree, walker.problem, {});
  ColdStart search(walker.tree, walker.problem, {}, {});
  int missed = 0;
  for (unsigned seed = 0; seed < 60; ++seed) {
    const IkTargets targets = walker.targets_at(pose_within(walker, seed));
    std::vector<double> q = walker.tree.default_q;
    missed += single.minimize(targets, q).final_cost > kMet;
    q = walker.tree.default_q;
    const Summary& summary = search.minimize(targets, q);
    EXPECT_LE(summary.final_cost, kMet) << seed;
    EXPECT_TRUE(summary.converged()) << seed;
    const IkTargets met = walker.targets_at(q);
    for (std::size_t i = 0; i < met.positions.size(); ++i) {
      EXPECT_LE((met.positions[i] - targets.positions[i]).norm(), 2e-6) << seed;
    }
  }
  EXPECT_GE(missed, 10);  // or else the test shows nothing
}

TEST(ColdStart, KeepsItsResultWithinTheBoundsAndItsWorkspaceThere) {
  const Walker walker = bounded_walker();
  ColdStart search(walker.tree, walker.problem, {}, {});
  const IkTargets targets = walker.targets_at(walker.pose(5, 2.0));
  std::vector<double> q = walker.tree.default_q;
  const double found = search.minimize(targets, q).final_cost;
  for (std::size_t x = 0; x < walker.tree.unknown_v.size(); ++x) {
    const int entry = walker.tree.q_of_v[static_cast<std::size_t>(walker.tree.unknown_v[x])];
    EXPECT_GE(q[static_cast<std::size_t>(entry)], walker.tree.lower[x]);
    EXPECT_LE(q[static_cast<std::size_t>(entry)], walker.tree.upper[x]);
  }
  KinematicWorkspace& ws = search.workspace();
  EXPECT_EQ(cost(walker.tree, walker.problem, targets, ws), found);
  EXPECT_EQ(q[static_cast<std::size_t>(
                walker.tree.q_of_coordinate[static_cast<std::size_t>(walker.locked)])],
            0.2);
}

TEST(ColdStart, TellsWhatItFound) {
  const Walker walker = bounded_walker();
  ColdStart search(walker.tree, walker.problem, {}, {.starts = 30});
  IkTargets targets = walker.targets_at(pose_within(walker, 3));
  for (Eigen::Vector3d& p : targets.positions) p += 0.01 * Eigen::Vector3d(p.y(), p.z(), p.x());
  std::vector<double> q = walker.tree.default_q;
  const Summary& summary = search.minimize(targets, q);
  const ColdStartResult& result = search.result();
  EXPECT_NEAR(result.lowest, summary.final_cost, 1e-8 * summary.final_cost);
  EXPECT_GE(result.starts, 2);
  EXPECT_LE(result.starts, 30);
  EXPECT_GE(result.agreeing, 1);
  EXPECT_LE(result.agreeing, result.starts);
  EXPECT_TRUE(!result.agreed || result.agreeing >= 2);
  EXPECT_TRUE(std::isnan(result.second_lowest) || result.second_lowest > result.lowest);
}

TEST(ColdStart, WithOneStartIsTheMinimizer) {
  const Walker walker = bounded_walker();
  const IkTargets targets = walker.targets_at(pose_within(walker, 4));
  Minimizer minimizer(walker.tree, walker.problem, {});
  ColdStart search(walker.tree, walker.problem, {}, {.starts = 1});
  std::vector<double> a = walker.tree.default_q, b = a;
  const double cost = minimizer.minimize(targets, a).final_cost;
  EXPECT_EQ(search.minimize(targets, b).final_cost, cost);
  EXPECT_EQ(a, b);
  EXPECT_EQ(search.result().starts, 1);
  EXPECT_FALSE(search.result().agreed);
}

TEST(ColdStart, FindsTheSameAgainWhateverItDidBefore) {
  const Walker walker = bounded_walker();
  ColdStart fresh(walker.tree, walker.problem, {}, {}), used(walker.tree, walker.problem, {}, {});
  std::vector<double> q = walker.tree.default_q;
  used.minimize(walker.targets_at(pose_within(walker, 8)), q);
  const IkTargets targets = walker.targets_at(pose_within(walker, 9));
  std::vector<double> a = walker.tree.default_q, b = a;
  fresh.minimize(targets, a);
  used.minimize(targets, b);
  EXPECT_EQ(std::memcmp(a.data(), b.data(), a.size() * sizeof(double)), 0);
}

TEST(ColdStart, LooksAgainWhereASolutionIsWrongAndLeavesARightOne) {
  const Walker walker = bounded_walker();
  MinimizerOptions exact;
  exact.gradient_tolerance = 1e-13;
  Minimizer single(walker.tree, walker.problem, exact);
  ColdStart search(walker.tree, walker.problem, {}, {});
  int wrong = 0;
  for (unsigned seed = 0; seed < 60; ++seed) {
    const IkTargets targets = walker.targets_at(pose_within(walker, seed));
    std::vector<double> q = walker.tree.default_q;
    const double cost = single.minimize(targets, q).final_cost;
    const std::vector<double> before = q;
    if (cost > kMet) {
      ++wrong;
      EXPECT_TRUE(search.look_again(targets, q, cost)) << seed;
      EXPECT_LE(search.summary().final_cost, kMet) << seed;
    } else {
      EXPECT_FALSE(search.look_again(targets, q, cost)) << seed;
      EXPECT_EQ(q, before) << seed;
    }
  }
  EXPECT_GE(wrong, 10);
}

TEST(ColdStart, RefusesToStartNotOnce) {
  const Walker walker;
  try {
    ColdStart search(walker.tree, walker.problem, {}, {.starts = 0});
    FAIL();
  } catch (const std::invalid_argument& error) {
    EXPECT_STREQ(error.what(), "ColdStartOptions.starts is 0; expected 1 or more");
  }
}

}  // namespace
}  // namespace sinew
