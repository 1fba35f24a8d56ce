#include "ik/wire_tensions.h"

#include <gtest/gtest.h>

#include <random>

namespace sinew {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// A random model whose matrix is dense, so that any pattern would do.
struct Model {
  MatrixXd H, J;  // J: a row each wire
  VectorXd g, excess, weight;

  Model(int unknowns, int wires, unsigned seed) {
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal;
    const auto fill = [&](auto& matrix) {
      for (double& each : matrix.reshaped()) each = normal(random);
    };
    MatrixXd root(unknowns, unknowns);
    fill(root);
    H = root * root.transpose() + 1e-3 * MatrixXd::Identity(unknowns, unknowns);
    J.resize(wires, unknowns);
    fill(J);
    g.resize(unknowns);
    fill(g);
    excess.resize(wires);
    fill(excess);
    weight = VectorXd::Constant(wires, 10.0);
  }

  // Gradient of gᵀd + ½dᵀHd + ½Σ w max(0, ε + jᵀd)².
  VectorXd gradient(const VectorXd& d) const {
    const VectorXd after = excess + J * d;
    return g + H * d + J.transpose() * weight.cwiseProduct(after.cwiseMax(0.0));
  }

  // What rounding of its terms may leave of the gradient.
  double rounding(const VectorXd& d) const {
    return 1e-11 * (g.norm() + H.norm() * d.norm() + weight.maxCoeff() * J.norm() * J.norm());
  }

  SupernodalCholesky factorized() const {
    const int n = static_cast<int>(H.rows());
    std::vector<int> all;
    for (int i = 0; i < n; ++i) all.push_back(i);
    const std::vector<std::vector<int>> cliques = {all};
    SupernodalCholesky factor(n, cliques);
    for (int column = 0; column < n; ++column) {
      for (int row = column; row < n; ++row) {
        factor.values()[static_cast<std::size_t>(factor.offset(row, column))] = H(row, column);
      }
    }
    EXPECT_TRUE(factor.factorize(0.0, std::vector<char>(static_cast<std::size_t>(n), 0)));
    return factor;
  }

  void add(int wire, WireTensions& tensions, SupernodalCholesky& factor) const {
    std::vector<int> all;
    for (int i = 0; i < static_cast<int>(H.rows()); ++i) all.push_back(i);
    const VectorXd row = J.row(wire);
    tensions.add(wire, excess[wire], weight[wire], all,
                 {row.data(), static_cast<std::size_t>(row.size())}, factor);
  }
};

class RandomTensions : public testing::TestWithParam<int> {};

// The convex model has one minimum, and there its gradient is zero, whatever way led there.
TEST_P(RandomTensions, LeaveNoGradient) {
  for (unsigned seed = 1; seed <= 40; ++seed) {
    const Model model(12, GetParam(), seed);
    SupernodalCholesky factor = model.factorized();
    WireTensions tensions(12, GetParam());
    VectorXd y = -model.g;
    factor.forward(y);
    tensions.begin(y);
    for (int i = 0; i < GetParam(); ++i) model.add(i, tensions, factor);
    tensions.solve();
    VectorXd d(12);
    tensions.step(factor, d);
    EXPECT_LT(model.gradient(d).norm(), model.rounding(d)) << "seed " << seed;
    double energy = 0.0;
    for (int i = 0; i < GetParam(); ++i) {
      const double after = std::max(0.0, model.excess[i] + model.J.row(i).dot(d));
      EXPECT_NEAR(tensions.tension(i), model.weight[i] * after, 1e-8) << "seed " << seed;
      energy += 0.5 * model.weight[i] * after * after;
    }
    EXPECT_NEAR(tensions.energy(), energy, 1e-8 * (1.0 + energy));
  }
}

// Wires that come later, and lengths that change, lead to the same minimum as all at once.
TEST_P(RandomTensions, MayBeAddedAndLengthenedInAnyOrder) {
  Model model(12, GetParam(), 7);
  SupernodalCholesky factor = model.factorized();
  WireTensions tensions(12, GetParam());
  VectorXd y = -model.g;
  factor.forward(y);
  tensions.begin(y);
  for (int i = GetParam() - 1; i >= 0; --i) {
    EXPECT_FALSE(tensions.has(i));
    model.add(i, tensions, factor);
    EXPECT_TRUE(tensions.has(i));
    tensions.solve();
  }
  for (int i = 0; i < GetParam(); ++i) {
    tensions.lengthen(i, 0.1 * i);
    model.excess[i] += 0.1 * i;
  }
  tensions.solve();
  VectorXd d(12);
  tensions.step(factor, d);
  EXPECT_LT(model.gradient(d).norm(), model.rounding(d));
  tensions.begin(y);
  EXPECT_EQ(tensions.count(), 0);
  tensions.solve();
  tensions.step(factor, d);
  EXPECT_LT((model.H * d + model.g).norm(), 1e-9 * model.g.norm());
}

INSTANTIATE_TEST_SUITE_P(Counts, RandomTensions, testing::Values(1, 5, 30, 200));

// Two wires along one line share what they carry.
TEST(WireTensions, AreSharedByWiresThatAreTheSame) {
  Model model(12, 2, 3);
  model.J.row(1) = model.J.row(0);
  model.excess.setConstant(1.0);
  model.g.setZero();
  SupernodalCholesky factor = model.factorized();
  WireTensions tensions(12, 2);
  tensions.begin(VectorXd::Zero(12));
  model.add(0, tensions, factor);
  model.add(1, tensions, factor);
  tensions.solve();
  VectorXd d(12);
  tensions.step(factor, d);
  EXPECT_GT(tensions.tension(0), 0.0);
  EXPECT_NEAR(tensions.tension(0), tensions.tension(1), 1e-9);
  EXPECT_LT(model.gradient(d).norm(), model.rounding(d));
}

}  // namespace
}  // namespace sinew
