#include "data/natural_spline.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

namespace sinew {
namespace {

// Value or derivative of one column, from the documented layout and nothing else.
double evaluate(const Eigen::MatrixXd& coefficients, const Eigen::VectorXd& x, int m, double t,
                int order = 0, int column = 0) {
  const auto above = std::upper_bound(x.begin(), x.end(), t) - x.begin();
  const auto i = std::clamp<Eigen::Index>(above - 1, 0, x.size() - 2);
  double value = 0.0;
  for (int k = 2 * m - 1; k >= order; --k) {
    double factor = 1.0;
    for (int j = 0; j < order; ++j) factor *= k - j;
    value = value * (t - x[i]) + factor * coefficients(2 * m * i + k, column);
  }
  return value;
}

// Steps between a fifth of and five times the mean, so that neighbours differ up to 25-fold.
Eigen::VectorXd irregular_abscissae(int n, unsigned seed) {
  std::mt19937 generator(seed);
  std::uniform_real_distribution<double> log_step(std::log(0.2), std::log(5.0));
  Eigen::VectorXd x(n);
  x[0] = -1.0;
  for (int i = 1; i < n; ++i) x[i] = x[i - 1] + std::exp(log_step(generator)) / n;
  return x;
}

Eigen::MatrixXd random_values(int n, int columns, unsigned seed) {
  std::mt19937 generator(seed);
  std::normal_distribution<double> normal;
  return Eigen::MatrixXd::NullaryExpr(n, columns, [&] { return normal(generator); });
}

std::string error_of(const Eigen::VectorXd& x, const Eigen::MatrixXd& y, int m) {
  try {
    natural_spline_coefficients(x, y, m);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "no error";
}

class NaturalSpline : public testing::TestWithParam<int> {};

TEST_P(NaturalSpline, ReproducesPolynomialsBelowHalfOrder) {
  const int m = GetParam();
  const Eigen::VectorXd x = irregular_abscissae(40, 1);
  const auto polynomial = [m](double t) {
    double value = 0.0;
    for (int k = m - 1; k >= 0; --k) value = value * t + (k + 1.5);
    return value;
  };
  const Eigen::MatrixXd c = natural_spline_coefficients(x, x.unaryExpr(polynomial), m);
  for (double t = x[0]; t < x[39]; t += 0.013) {
    EXPECT_NEAR(evaluate(c, x, m, t), polynomial(t), 1e-12 * std::abs(polynomial(t))) << t;
  }
}

TEST_P(NaturalSpline, InterpolatesFromBothSides) {
  const int m = GetParam();
  const Eigen::VectorXd x = irregular_abscissae(60, 2);
  const Eigen::MatrixXd y = random_values(60, 3, 3);
  const Eigen::MatrixXd c = natural_spline_coefficients(x, y, m);
  ASSERT_EQ(c.rows(), 2 * m * 59);
  ASSERT_EQ(c.cols(), 3);
  for (int j = 0; j < 3; ++j) {
    for (int i = 0; i < 60; ++i) {
      EXPECT_NEAR(evaluate(c, x, m, x[i], 0, j), y(i, j), 1e-12);
      if (i == 0) continue;
      const double before = std::nextafter(x[i], x[0]);
      EXPECT_NEAR(evaluate(c, x, m, before, 0, j), y(i, j), 1e-10);
    }
  }
}

TEST_P(NaturalSpline, DerivativesAreContinuousToTwiceHalfOrderMinusTwo) {
  const int m = GetParam();
  const int n = 50;
  const Eigen::VectorXd x = irregular_abscissae(n, 4);
  const Eigen::MatrixXd c = natural_spline_coefficients(x, random_values(n, 1, 5), m);
  for (int order = 0; order <= 2 * m - 2; ++order) {
    double largest = 0.0;
    for (int i = 0; i < n; ++i)
      largest = std::max(largest, std::abs(evaluate(c, x, m, x[i], order)));
    for (int i = 1; i < n - 1; ++i) {
      const double h = x[i] - x[i - 1];
      double left = 0.0;
      for (int k = 2 * m - 1; k >= order; --k) {
        double factor = 1.0;
        for (int j = 0; j < order; ++j) factor *= k - j;
        left = left * h + factor * c(2 * m * (i - 1) + k, 0);
      }
      EXPECT_NEAR(left, evaluate(c, x, m, x[i], order), 1e-9 * largest)
          << "order " << order << ", knot " << i;
    }
  }
}

TEST_P(NaturalSpline, EndDerivativesFromHalfOrderOnVanish) {
  const int m = GetParam();
  const int n = 30;
  const Eigen::VectorXd x = irregular_abscissae(n, 6);
  const Eigen::MatrixXd c = natural_spline_coefficients(x, random_values(n, 1, 7), m);
  for (int order = m; order <= 2 * m - 2; ++order) {
    double largest = 0.0;
    for (int i = 0; i < n; ++i)
      largest = std::max(largest, std::abs(evaluate(c, x, m, x[i], order)));
    EXPECT_NEAR(evaluate(c, x, m, x[0], order), 0.0, 1e-11 * largest) << order;
    EXPECT_NEAR(evaluate(c, x, m, x[n - 1], order), 0.0, 1e-11 * largest) << order;
  }
}

// f(t) = Σ a_i |t − x_i|^(2m−1) + Σ b_r t^r with Σ a_i x_i^r = 0 for r < m is the same spline, from
// a dense system that shares nothing with the banded one.
TEST_P(NaturalSpline, AgreesWithDenseRadialBasis) {
  const int m = GetParam();
  const int n = 14;
  const Eigen::VectorXd x = irregular_abscissae(n, 8);
  const Eigen::MatrixXd y = random_values(n, 1, 9);
  Eigen::MatrixXd system = Eigen::MatrixXd::Zero(n + m, n + m);
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) system(i, j) = std::pow(std::abs(x[i] - x[j]), 2 * m - 1);
    for (int r = 0; r < m; ++r) system(i, n + r) = system(n + r, i) = std::pow(x[i], r);
  }
  Eigen::VectorXd right = Eigen::VectorXd::Zero(n + m);
  right.head(n) = y.col(0);
  const Eigen::VectorXd weights = system.fullPivLu().solve(right);

  const Eigen::MatrixXd c = natural_spline_coefficients(x, y, m);
  for (double t = x[0]; t <= x[n - 1]; t += 0.01) {
    double expected = 0.0, scale = 0.0;
    for (int i = 0; i < n; ++i) {
      const double term = weights[i] * std::pow(std::abs(t - x[i]), 2 * m - 1);
      expected += term;
      scale += std::abs(term);
    }
    for (int r = 0; r < m; ++r) expected += weights[n + r] * std::pow(t, r);
    // The dense sum cancels; its own rounding is eps times the sum of its terms' sizes.
    EXPECT_NEAR(evaluate(c, x, m, t), expected, 1e-11 * (1.0 + scale)) << t;
  }
}

// Neither rounding nor the end conditions travel along a record of 10,000 points.
TEST_P(NaturalSpline, StaysAccurateOnLongRecords) {
  const int m = GetParam();
  const int n = 10000;
  const Eigen::VectorXd x = Eigen::VectorXd::LinSpaced(n, 0.0, 100.0);
  const auto wave = [](double t) { return std::sin(2.0 * std::numbers::pi * t); };
  const Eigen::MatrixXd c = natural_spline_coefficients(x, x.unaryExpr(wave), m);
  // (2π h)^(2m) is the size of the first neglected term of a spline of degree 2m − 1.
  const double bound = std::pow(2.0 * std::numbers::pi * 0.01, 2 * m) + 1e-12;
  for (double t = 1.0; t < 99.0; t += 0.7123) EXPECT_NEAR(evaluate(c, x, m, t), wave(t), bound);
}

TEST_P(NaturalSpline, TakesTheFewestPoints) {
  const int m = GetParam();
  const Eigen::VectorXd x = Eigen::VectorXd::LinSpaced(2 * m, 0.0, 1.0);
  const Eigen::MatrixXd y = random_values(2 * m, 1, 10);
  const Eigen::MatrixXd c = natural_spline_coefficients(x, y, m);
  for (int i = 0; i < 2 * m; ++i) EXPECT_NEAR(evaluate(c, x, m, x[i]), y(i, 0), 1e-12);
}

INSTANTIATE_TEST_SUITE_P(HalfOrders, NaturalSpline, testing::Values(1, 2, 3, 4));

// scipy 1.17.1, interpolate.make_interp_spline(x, y, k=2m−1, bc_type=([(d, 0) for d in
// m…2m−2],)*2): value, first and second derivative.
TEST(NaturalSplineGolden, AgreesWithScipy) {
  const Eigen::VectorXd x{{0.0, 0.1, 0.35, 0.4, 0.9, 1.0, 1.7, 2.0, 2.05, 3.0}};
  const Eigen::VectorXd y{{1.0, -0.5, 0.25, 2.0, 1.5, -1.0, 0.0, 3.0, 2.5, -2.0}};
  const std::array<double, 4> times = {0.05, 0.38, 1.35, 2.9};
  const double golden[3][4][3] = {{{0.224748116377619, -15.16834589081587, 20.20150689790476},
                                   {1.285513790278335, 36.25612756231758, 14.46434128478025},
                                   {-3.979004964685455, 3.558108872234484, 56.80008105608909},
                                   {-1.844623916269515, -1.625090389528009, 2.139886566694662}},
                                  {{0.2597033799390777, -15.12120022151008, -9.966344342354486},
                                   {1.266902341733959, 35.89638102624647, 99.26575317821786},
                                   {-4.863311814169835, 2.1197288647064, 81.04580528457541},
                                   {-4.558566403095519, 20.96350496950111, 92.3105186871663}},
                                  {{0.3773745082139183, -16.02896382339882, -101.8000347407234},
                                   {1.265822413357676, 35.81436926894521, 106.2536757242099},
                                   {-3.89821943470609, 1.672598370073172, 52.67873570696099},
                                   {-11.41404893317578, 70.4089055835001, 445.1791708453003}}};
  for (int m = 2; m <= 4; ++m) {
    const Eigen::MatrixXd c = natural_spline_coefficients(x, y, m);
    for (std::size_t i = 0; i < times.size(); ++i) {
      for (int order = 0; order < 3; ++order) {
        const double expected = golden[m - 2][i][order];
        EXPECT_NEAR(evaluate(c, x, m, times[i], order), expected, 1e-10 * (1 + std::abs(expected)))
            << "m = " << m << ", t = " << times[i] << ", order " << order;
      }
    }
  }
}

TEST(NaturalSplineErrors, SayWhatIsWrong) {
  const Eigen::VectorXd x{{0.0, 1.0, 2.0, 3.0, 4.0, 5.0}};
  const Eigen::MatrixXd y = Eigen::MatrixXd::Ones(6, 1);
  EXPECT_EQ(error_of(x, y, 5), "natural_spline_coefficients: half_order must be 1 to 4, is 5");
  EXPECT_EQ(error_of(x, y, 0), "natural_spline_coefficients: half_order must be 1 to 4, is 0");
  EXPECT_EQ(
      error_of(x, y, 4),
      "natural_spline_coefficients: a spline of degree 7 needs at least 8 points, there are 6");
  EXPECT_EQ(error_of(x.head(5), y, 2),
            "natural_spline_coefficients: x has 5 values and y has 6 rows; they must agree");
  Eigen::VectorXd repeated = x;
  repeated[3] = 2.0;
  EXPECT_EQ(error_of(repeated, y, 2),
            "natural_spline_coefficients: x must increase strictly; x[3] = 2 follows x[2] = 2");
  Eigen::MatrixXd missing = y;
  missing(4, 0) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(error_of(x, missing, 2), "natural_spline_coefficients: y(4, 0) is nan, not finite");
  Eigen::VectorXd endless = x;
  endless[5] = std::numeric_limits<double>::infinity();
  EXPECT_EQ(error_of(endless, y, 2), "natural_spline_coefficients: x[5] is inf, not finite");
}

}  // namespace
}  // namespace sinew
