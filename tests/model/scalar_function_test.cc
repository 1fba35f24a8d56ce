#include "model/scalar_function.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <stdexcept>

namespace sinew {
namespace {

ScalarFunction function_of(const nlohmann::json& c) {
  const std::string kind = c["kind"];
  if (kind == "SimmSpline") return {SimmSpline{c["x"], c["y"]}};
  if (kind == "GCVSpline") return {GcvSpline{c["half_order"], c["x"], c["y"]}};
  if (kind == "PiecewiseLinearFunction") return {PiecewiseLinearFunction{c["x"], c["y"]}};
  if (kind == "PiecewiseConstantFunction") return {PiecewiseConstantFunction{c["x"], c["y"]}};
  const std::vector<double> v = c["values"];
  if (kind == "StepFunction") return {StepFunction{v[0], v[1], v[2], v[3]}};
  return {SineFunction{v[0], v[1], v[2], 0.0}};
}

using Rows = std::vector<std::vector<double>>;  // x, f(x), f'(x), …

double largest(const Rows& rows, std::size_t column) {
  double result = 1.0;
  for (const std::vector<double>& row : rows) result = std::max(result, std::abs(row[column]));
  return result;
}

TEST(CompiledFunction, HasTheValuesAndDerivativesOfOpenSim) {
  std::ifstream file("tests/golden/osim_functions.json");
  const nlohmann::json cases = nlohmann::json::parse(file)["functions"];
  ASSERT_EQ(cases.size(), 13u);
  for (const nlohmann::json& c : cases) {
    const CompiledFunction function(function_of(c));
    const Rows rows = c["rows"];
    for (const std::vector<double>& row : rows) {
      SCOPED_TRACE(c["kind"].get<std::string>() + " at " + std::to_string(row[0]));
      for (std::size_t column = 1; column < row.size(); ++column) {
        // Both sides solve for a spline's coefficients: rounding goes by the largest of them.
        EXPECT_NEAR(function.derivative(row[0], static_cast<int>(column) - 1), row[column],
                    1e-12 * largest(rows, column))
            << "order " << column - 1;
      }
    }
  }
}

const std::vector<double> kX = {-1.0, -0.4, 0.3, 0.9, 2.0};
const std::vector<double> kY = {0.5, -0.2, 0.1, 0.8, -0.4};

std::vector<ScalarFunction> one_of_each_kind() {
  return {{ConstantFunction{0.7}, 2.0},
          {LinearFunction{1.5, -0.2}, -1.0},
          {PolynomialFunction{{0.3, -0.2, 1.0, 0.5}}, 0.5},
          {SineFunction{0.7, 2.5, 0.3, 1.0}, 3.0},
          {SimmSpline{kX, kY}, 1.5},
          {GcvSpline{2, kX, kY}, -2.0},
          {PiecewiseLinearFunction{kX, kY}, 2.0},
          {PiecewiseConstantFunction{kX, kY}, 2.0},
          {StepFunction{-0.5, 1.0, 2.0, -1.0}, 2.0}};
}

TEST(CompiledFunction, DerivativesAreThoseOfTheOrderBelow) {
  constexpr double kStep = 1e-6;  // rounding 1e-10 and truncation 1e-12 times derivatives up to 1e3
  for (const ScalarFunction& function : one_of_each_kind()) {
    const CompiledFunction f(function);
    for (const double x : {-1.7, -0.71, 0.11, 0.57, 1.3, 2.6}) {  // between points
      for (int order = 1; order <= 3; ++order) {
        const double quotient =
            (f.derivative(x + kStep, order - 1) - f.derivative(x - kStep, order - 1)) / (2 * kStep);
        EXPECT_NEAR(f.derivative(x, order), quotient, 1e-7 * std::max(1.0, std::abs(quotient)))
            << function.kind.index() << " order " << order << " at " << x;
      }
    }
  }
}

TEST(CompiledFunction, EvaluatesTheSameAsItsDerivatives) {
  for (const ScalarFunction& function : one_of_each_kind()) {
    const CompiledFunction f(function);
    for (const double x : {-1.7, -1.0, -0.5, 0.3, 1.0, 2.0, 2.6}) {
      const CompiledFunction::Derivatives d = f.evaluate(x);
      EXPECT_NEAR(d.f, f.derivative(x, 0), 1e-14) << function.kind.index();
      EXPECT_NEAR(d.df, f.derivative(x, 1), 1e-13) << function.kind.index();
      EXPECT_NEAR(d.ddf, f.derivative(x, 2), 1e-12) << function.kind.index();
      EXPECT_EQ(f.value(x), d.f);
    }
  }
}

TEST(CompiledFunction, HasTheScaleAsAFactor) {
  for (const ScalarFunction& function : one_of_each_kind()) {
    const CompiledFunction scaled(function), plain({function.kind, 1.0});
    EXPECT_NEAR(scaled.value(0.4), function.scale * plain.value(0.4), 1e-15);
    EXPECT_NEAR(scaled.derivative(0.4, 1), function.scale * plain.derivative(0.4, 1), 1e-14);
  }
}

TEST(CompiledFunction, HasClosedForms) {
  const CompiledFunction polynomial({PolynomialFunction{{2.0, -1.0, 3.0}}});
  EXPECT_EQ(polynomial.value(2.0), 9.0);
  EXPECT_EQ(polynomial.derivative(2.0, 1), 7.0);
  EXPECT_EQ(polynomial.derivative(2.0, 2), 4.0);
  EXPECT_EQ(polynomial.derivative(2.0, 3), 0.0);
  const CompiledFunction step({StepFunction{1.0, 3.0, 10.0, 20.0}});
  EXPECT_EQ(step.value(0.0), 10.0);
  EXPECT_NEAR(step.value(2.0), 15.0, 1e-14);
  EXPECT_EQ(step.value(3.0), 20.0);
  const CompiledFunction stairs({PiecewiseConstantFunction{{1.0, 2.0}, {5.0, 6.0}}});
  EXPECT_EQ(stairs.value(0.0), 5.0);
  EXPECT_EQ(stairs.value(2.0), 6.0);
}

TEST(CompiledFunction, SplinesReproduceWhatTheyCanHold) {
  std::vector<double> cubic, line;
  for (const double x : kX) {
    cubic.push_back(1.0 + x * (2.0 + x * (-0.5 + 0.3 * x)));
    line.push_back(2.0 * x - 1.0);
  }
  const CompiledFunction simm({SimmSpline{kX, cubic}});  // its end conditions hold for a cubic
  EXPECT_NEAR(simm.value(0.57), 1.0 + 0.57 * (2.0 + 0.57 * (-0.5 + 0.3 * 0.57)), 1e-14);
  EXPECT_NEAR(simm.derivative(0.57, 2), -1.0 + 1.8 * 0.57, 1e-13);
  for (const int half_order : {1, 2}) {
    const CompiledFunction natural({GcvSpline{half_order, kX, line}});
    EXPECT_NEAR(natural.value(0.57), 0.14, 1e-14);
    EXPECT_NEAR(natural.value(3.0), half_order == 1 ? line.back() : 5.0, 1e-13);
  }
}

TEST(CompiledFunction, KnowsConstantsAndTheIdentity) {
  const auto is_constant = [](const ScalarFunction& f) {
    return CompiledFunction(f).is_constant();
  };
  const auto is_identity = [](const ScalarFunction& f) {
    return CompiledFunction(f).is_identity();
  };
  EXPECT_TRUE(is_constant({ConstantFunction{3.0}}));
  EXPECT_TRUE(is_constant({LinearFunction{0.0, 2.0}}));
  EXPECT_TRUE(is_constant({LinearFunction{}, 0.0}));
  EXPECT_TRUE(is_constant({SimmSpline{{0, 1, 2}, {5, 5, 5}}}));
  EXPECT_TRUE(is_constant({PiecewiseConstantFunction{{0, 1}, {5, 5}}}));
  EXPECT_TRUE(is_constant({SineFunction{0.0, 1.0, 0.0, 1.0}}));
  EXPECT_FALSE(is_constant({PiecewiseConstantFunction{{0, 1}, {5, 6}}}));
  EXPECT_FALSE(is_constant({LinearFunction{1e-300, 0.0}}));
  EXPECT_TRUE(is_identity({LinearFunction{}}));
  EXPECT_TRUE(is_identity({LinearFunction{2.0, 0.0}, 0.5}));
  EXPECT_TRUE(is_identity({PolynomialFunction{{1.0, 0.0}}}));
  EXPECT_FALSE(is_identity({LinearFunction{1.0, 1e-9}}));
  EXPECT_FALSE(is_identity({SimmSpline{{1, 2}, {1, 2}}}));  // equal, but not worth finding out
}

std::string error_of(const ScalarFunction& function) {
  try {
    CompiledFunction{function};
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "no error";
}

TEST(CompiledFunction, SaysWhatIsWrong) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  EXPECT_EQ(error_of({SimmSpline{{0, 1, 1}, {0, 0, 0}}}),
            "SimmSpline has x = 1 after 1 at point 3; expected x to increase");
  EXPECT_EQ(error_of({SimmSpline{{0, 1}, {0}}}),
            "SimmSpline has 2 x and 1 y values; expected as many of each");
  EXPECT_EQ(error_of({SimmSpline{{0}, {0}}}), "SimmSpline has 1 points; expected at least 2");
  EXPECT_EQ(error_of({GcvSpline{3, kX, kY}}), "GCVSpline has 5 points; expected at least 6");
  EXPECT_EQ(error_of({GcvSpline{5, kX, kY}}), "GCVSpline has half_order 5; expected 1 to 4");
  EXPECT_EQ(error_of({PiecewiseLinearFunction{{0, 1}, {0, kInfinity}}}),
            "PiecewiseLinearFunction has a value that is not finite at point 2");
  EXPECT_EQ(error_of({PolynomialFunction{}}),
            "PolynomialFunction has no coefficients; expected at least 1");
  EXPECT_EQ(error_of({LinearFunction{}, kInfinity}),
            "the multiplier has a value that is not finite");
  EXPECT_EQ(error_of({StepFunction{1.0, 1.0, 0.0, 1.0}}),
            "StepFunction starts at 1 and ends at 1; expected the end to be later");
}

}  // namespace
}  // namespace sinew
