#pragma once

#include <array>
#include <string>
#include <variant>
#include <vector>

namespace sinew {

// Functions of one coordinate, as a model file gives them.
struct ConstantFunction {
  double value = 0.0;
  bool operator==(const ConstantFunction&) const = default;
};
struct LinearFunction {
  double slope = 1.0, intercept = 0.0;
  bool operator==(const LinearFunction&) const = default;
};
struct PolynomialFunction {
  std::vector<double> coefficients;  // highest power first
  bool operator==(const PolynomialFunction&) const = default;
};
/// amplitude·sin(omega·x + phase) + offset
struct SineFunction {
  double amplitude = 1.0, omega = 1.0, phase = 0.0, offset = 0.0;
  bool operator==(const SineFunction&) const = default;
};
/// SIMM's cubic spline (OpenSim's SimmSpline, NaturalCubicSpline in old files): end conditions of
/// Forsythe, Malcolm & Moler 1977, sec. 4.4; straight lines beyond its ends.
struct SimmSpline {
  std::vector<double> x, y;
  bool operator==(const SimmSpline&) const = default;
};
/// Interpolating natural spline of degree 2·half_order − 1 (OpenSim's GCVSpline without
/// smoothing); polynomials of degree half_order − 1 beyond its ends.
struct GcvSpline {
  int half_order = 3;
  std::vector<double> x, y;
  bool operator==(const GcvSpline&) const = default;
};
/// Straight lines between points; the end lines continue beyond them.
struct PiecewiseLinearFunction {
  std::vector<double> x, y;
  bool operator==(const PiecewiseLinearFunction&) const = default;
};
/// Constant between points, taking each point's value from its x on.
struct PiecewiseConstantFunction {
  std::vector<double> x, y;
  bool operator==(const PiecewiseConstantFunction&) const = default;
};
/// Smooth step: the quintic 10s³ − 15s⁴ + 6s⁵ between start and end (Simbody's step).
struct StepFunction {
  double start = 0.0, end = 1.0, start_value = 0.0, end_value = 1.0;
  bool operator==(const StepFunction&) const = default;
};

/// scale × kind; OpenSim's MultiplierFunction, nested or not, becomes the scale.
struct ScalarFunction {
  std::variant<ConstantFunction, LinearFunction, PolynomialFunction, SineFunction, SimmSpline,
               GcvSpline, PiecewiseLinearFunction, PiecewiseConstantFunction, StepFunction>
      kind = ConstantFunction{};
  double scale = 1.0;

  bool operator==(const ScalarFunction&) const = default;
};

/// A ScalarFunction ready for evaluation: a sine, or a polynomial on each of a few intervals.
/// Evaluation costs a binary search and one Horner scheme and allocates nothing.
class CompiledFunction {
 public:
  /// Throws std::invalid_argument, saying what is wrong, if x is not strictly increasing, x and y
  /// differ in size, there are too few points, or a value is not finite.
  explicit CompiledFunction(const ScalarFunction& function);

  struct Derivatives {
    double f, df, ddf;  // value, first and second derivative
  };
  Derivatives evaluate(double x) const;
  double value(double x) const { return evaluate(x).f; }
  /// Derivative of any order ≥ 0.
  double derivative(double x, int order) const;

  /// True if the function is the same everywhere.
  bool is_constant() const;
  /// True if the function is x itself.
  bool is_identity() const;

 private:
  struct Piece {
    double origin;
    int first, count;  // coefficients_[first + k] multiplies (x − origin)^k
  };
  const Piece& piece_at(double x) const;
  void add_piece(double origin, const std::vector<double>& coefficients, double scale);
  void compile(const ConstantFunction&, double scale);
  void compile(const LinearFunction&, double scale);
  void compile(const PolynomialFunction&, double scale);
  void compile(const SineFunction&, double scale);
  void compile(const SimmSpline&, double scale);
  void compile(const GcvSpline&, double scale);
  void compile(const PiecewiseLinearFunction&, double scale);
  void compile(const PiecewiseConstantFunction&, double scale);
  void compile(const StepFunction&, double scale);

  std::vector<double> breaks_;  // pieces_[i] holds on [breaks_[i-1], breaks_[i])
  std::vector<Piece> pieces_;
  std::vector<double> coefficients_;
  bool is_sine_ = false;
  SineFunction sine_;
};

}  // namespace sinew
