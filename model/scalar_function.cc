#include "model/scalar_function.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "data/natural_spline.h"

namespace sinew {
namespace {

void require_points(const char* kind, const std::vector<double>& x, const std::vector<double>& y,
                    std::size_t at_least) {
  if (x.size() != y.size()) {
    throw std::invalid_argument(fmt::format("{} has {} x and {} y values; expected as many of each",
                                            kind, x.size(), y.size()));
  }
  if (x.size() < at_least) {
    throw std::invalid_argument(
        fmt::format("{} has {} points; expected at least {}", kind, x.size(), at_least));
  }
  for (std::size_t i = 0; i < x.size(); ++i) {
    if (!std::isfinite(x[i]) || !std::isfinite(y[i])) {
      throw std::invalid_argument(
          fmt::format("{} has a value that is not finite at point {}", kind, i + 1));
    }
    if (i > 0 && x[i] <= x[i - 1]) {
      throw std::invalid_argument(
          fmt::format("{} has x = {} after {} at point {}; expected x to increase", kind, x[i],
                      x[i - 1], i + 1));
    }
  }
}

void require_finite(const char* kind, std::initializer_list<double> values) {
  for (const double value : values) {
    if (!std::isfinite(value)) {
      throw std::invalid_argument(fmt::format("{} has a value that is not finite", kind));
    }
  }
}

// Second-derivative unknowns of the cubic spline with the end conditions of Forsythe, Malcolm &
// Moler: the third derivative at an end is that of the cubic through the four points next to it.
// Returns s with spline'' = 6 s at the points. Symmetric tridiagonal, solved by elimination.
std::vector<double> forsythe_spline_curvatures(const std::vector<double>& x,
                                               const std::vector<double>& y) {
  const std::size_t n = x.size();
  std::vector<double> h(n - 1), slope(n - 1), diagonal(n), right(n);
  for (std::size_t i = 0; i + 1 < n; ++i) {
    h[i] = x[i + 1] - x[i];
    slope[i] = (y[i + 1] - y[i]) / h[i];
  }
  for (std::size_t i = 1; i + 1 < n; ++i) {
    diagonal[i] = 2.0 * (h[i - 1] + h[i]);
    right[i] = slope[i] - slope[i - 1];
  }
  const auto third_difference = [&](std::size_t i) {  // of points i … i + 3
    const double second0 = (slope[i + 1] - slope[i]) / (x[i + 2] - x[i]);
    const double second1 = (slope[i + 2] - slope[i + 1]) / (x[i + 3] - x[i + 1]);
    return (second1 - second0) / (x[i + 3] - x[i]);
  };
  diagonal[0] = -h[0];
  diagonal[n - 1] = -h[n - 2];
  right[0] = n > 3 ? h[0] * h[0] * third_difference(0) : 0.0;
  right[n - 1] = n > 3 ? -h[n - 2] * h[n - 2] * third_difference(n - 4) : 0.0;
  for (std::size_t i = 1; i < n; ++i) {
    const double factor = h[i - 1] / diagonal[i - 1];
    diagonal[i] -= factor * h[i - 1];
    right[i] -= factor * right[i - 1];
  }
  std::vector<double> s(n);
  s[n - 1] = right[n - 1] / diagonal[n - 1];
  for (std::size_t i = n - 1; i-- > 0;) s[i] = (right[i] - h[i] * s[i + 1]) / diagonal[i];
  return s;
}

}  // namespace

CompiledFunction::CompiledFunction(const ScalarFunction& function) {
  require_finite("the multiplier", {function.scale});
  std::visit([&](const auto& kind) { compile(kind, function.scale); }, function.kind);
}

void CompiledFunction::add_piece(double origin, const std::vector<double>& coefficients,
                                 double scale) {
  pieces_.push_back(
      {origin, static_cast<int>(coefficients_.size()), static_cast<int>(coefficients.size())});
  for (const double c : coefficients) coefficients_.push_back(scale * c);
}

void CompiledFunction::compile(const ConstantFunction& f, double scale) {
  require_finite("Constant", {f.value});
  add_piece(0.0, {f.value}, scale);
}

void CompiledFunction::compile(const LinearFunction& f, double scale) {
  require_finite("LinearFunction", {f.slope, f.intercept});
  add_piece(0.0, {f.intercept, f.slope}, scale);
}

void CompiledFunction::compile(const PolynomialFunction& f, double scale) {
  if (f.coefficients.empty()) {
    throw std::invalid_argument("PolynomialFunction has no coefficients; expected at least 1");
  }
  for (const double c : f.coefficients) require_finite("PolynomialFunction", {c});
  add_piece(0.0, {f.coefficients.rbegin(), f.coefficients.rend()}, scale);
}

void CompiledFunction::compile(const SineFunction& f, double scale) {
  require_finite("Sine", {f.amplitude, f.omega, f.phase, f.offset});
  is_sine_ = true;
  sine_ = f;
  sine_.amplitude *= scale;
  sine_.offset *= scale;
}

void CompiledFunction::compile(const SimmSpline& f, double scale) {
  require_points("SimmSpline", f.x, f.y, 2);
  const std::size_t n = f.x.size();
  if (n == 2) {
    add_piece(f.x[0], {f.y[0], (f.y[1] - f.y[0]) / (f.x[1] - f.x[0])}, scale);
    return;
  }
  const std::vector<double> s = forsythe_spline_curvatures(f.x, f.y);
  const auto slope_at = [&](std::size_t i, bool at_right_end) {  // of the cubic right of point i
    const double h = f.x[i + 1] - f.x[i];
    const double chord = (f.y[i + 1] - f.y[i]) / h;
    return at_right_end ? chord + h * (s[i] + 2.0 * s[i + 1]) : chord - h * (s[i + 1] + 2.0 * s[i]);
  };
  breaks_ = f.x;
  // The last point has the curvature of the cubic that ends there, as in OpenSim.
  breaks_.back() = std::nextafter(f.x.back(), std::numeric_limits<double>::infinity());
  add_piece(f.x[0], {f.y[0], slope_at(0, false)}, scale);
  for (std::size_t i = 0; i + 1 < n; ++i) {
    const double h = f.x[i + 1] - f.x[i];
    add_piece(f.x[i], {f.y[i], slope_at(i, false), 3.0 * s[i], (s[i + 1] - s[i]) / h}, scale);
  }
  add_piece(f.x[n - 1], {f.y[n - 1], slope_at(n - 2, true)}, scale);
}

void CompiledFunction::compile(const GcvSpline& f, double scale) {
  if (f.half_order < 1 || f.half_order > 4) {
    throw std::invalid_argument(
        fmt::format("GCVSpline has half_order {}; expected 1 to 4", f.half_order));
  }
  const auto order = static_cast<std::size_t>(2 * f.half_order);
  require_points("GCVSpline", f.x, f.y, order);
  const auto n = static_cast<Eigen::Index>(f.x.size());
  const Eigen::VectorXd x = Eigen::Map<const Eigen::VectorXd>(f.x.data(), n);
  const Eigen::MatrixXd y = Eigen::Map<const Eigen::VectorXd>(f.y.data(), n);
  const Eigen::MatrixXd c = natural_spline_coefficients(x, y, f.half_order);
  const auto piece = [&](Eigen::Index interval) {
    const auto block = c.col(0).segment(interval * static_cast<Eigen::Index>(order),
                                        static_cast<Eigen::Index>(order));
    return std::vector<double>(block.begin(), block.end());
  };
  breaks_ = f.x;
  std::vector<double> before = piece(0);
  before.resize(static_cast<std::size_t>(f.half_order));
  add_piece(f.x.front(), before, scale);
  for (Eigen::Index i = 0; i + 1 < n; ++i)
    add_piece(f.x[static_cast<std::size_t>(i)], piece(i), scale);
  // Beyond the last point: Taylor coefficients of the last interval's polynomial at its right end.
  const std::vector<double> last = piece(n - 2);
  const double h = f.x.back() - f.x[f.x.size() - 2];
  std::vector<double> after(static_cast<std::size_t>(f.half_order), 0.0);
  for (std::size_t k = 0; k < after.size(); ++k) {
    double binomial = 1.0, power = 1.0;
    for (std::size_t j = k; j < last.size(); ++j) {
      after[k] += binomial * last[j] * power;
      binomial *= static_cast<double>(j + 1) / static_cast<double>(j + 1 - k);
      power *= h;
    }
  }
  add_piece(f.x.back(), after, scale);
}

void CompiledFunction::compile(const PiecewiseLinearFunction& f, double scale) {
  require_points("PiecewiseLinearFunction", f.x, f.y, 1);
  const std::size_t n = f.x.size();
  if (n == 1) {
    add_piece(f.x[0], {f.y[0]}, scale);
    return;
  }
  breaks_.assign(f.x.begin() + 1, f.x.end() - 1);
  for (std::size_t i = 0; i + 1 < n; ++i) {
    add_piece(f.x[i], {f.y[i], (f.y[i + 1] - f.y[i]) / (f.x[i + 1] - f.x[i])}, scale);
  }
}

void CompiledFunction::compile(const PiecewiseConstantFunction& f, double scale) {
  require_points("PiecewiseConstantFunction", f.x, f.y, 1);
  breaks_.assign(f.x.begin() + 1, f.x.end());
  for (std::size_t i = 0; i < f.x.size(); ++i) add_piece(f.x[i], {f.y[i]}, scale);
}

void CompiledFunction::compile(const StepFunction& f, double scale) {
  require_finite("StepFunction", {f.start, f.end, f.start_value, f.end_value});
  if (f.end <= f.start) {
    throw std::invalid_argument(fmt::format(
        "StepFunction starts at {} and ends at {}; expected the end to be later", f.start, f.end));
  }
  const double width = f.end - f.start;
  const double rise = f.end_value - f.start_value;
  breaks_ = {f.start, f.end};
  add_piece(f.start, {f.start_value}, scale);
  add_piece(f.start,
            {f.start_value, 0.0, 0.0, 10.0 * rise / std::pow(width, 3),
             -15.0 * rise / std::pow(width, 4), 6.0 * rise / std::pow(width, 5)},
            scale);
  add_piece(f.end, {f.end_value}, scale);
}

const CompiledFunction::Piece& CompiledFunction::piece_at(double x) const {
  const auto next = std::upper_bound(breaks_.begin(), breaks_.end(), x);
  return pieces_[static_cast<std::size_t>(next - breaks_.begin())];
}

CompiledFunction::Derivatives CompiledFunction::evaluate(double x) const {
  if (is_sine_) {
    const double angle = sine_.omega * x + sine_.phase;
    const double a_sin = sine_.amplitude * std::sin(angle);
    const double a_cos = sine_.amplitude * std::cos(angle);
    return {a_sin + sine_.offset, sine_.omega * a_cos, -sine_.omega * sine_.omega * a_sin};
  }
  const Piece& piece = piece_at(x);
  const double t = x - piece.origin;
  double f = 0.0, df = 0.0, half_ddf = 0.0;
  for (int k = piece.count - 1; k >= 0; --k) {  // Horner for f, f' and f''/2 together
    half_ddf = half_ddf * t + df;
    df = df * t + f;
    f = f * t + coefficients_[static_cast<std::size_t>(piece.first + k)];
  }
  return {f, df, 2.0 * half_ddf};
}

double CompiledFunction::derivative(double x, int order) const {
  if (is_sine_) {
    const double angle = sine_.omega * x + sine_.phase + order * std::numbers::pi / 2.0;
    const double wave = sine_.amplitude * std::pow(sine_.omega, order) * std::sin(angle);
    return order == 0 ? wave + sine_.offset : wave;
  }
  const Piece& piece = piece_at(x);
  const double t = x - piece.origin;
  double result = 0.0;
  for (int k = piece.count - 1; k >= order; --k) {
    double falling = 1.0;  // k (k − 1) … (k − order + 1)
    for (int j = 0; j < order; ++j) falling *= k - j;
    result = result * t + falling * coefficients_[static_cast<std::size_t>(piece.first + k)];
  }
  return result;
}

bool CompiledFunction::is_constant() const {
  if (is_sine_) return sine_.amplitude == 0.0 || sine_.omega == 0.0;
  for (const Piece& piece : pieces_) {
    for (int k = 1; k < piece.count; ++k) {
      if (coefficients_[static_cast<std::size_t>(piece.first + k)] != 0.0) return false;
    }
    if (coefficients_[static_cast<std::size_t>(piece.first)] !=
        coefficients_[static_cast<std::size_t>(pieces_[0].first)]) {
      return false;
    }
  }
  return true;
}

bool CompiledFunction::is_identity() const {
  return !is_sine_ && pieces_.size() == 1 && pieces_[0].count == 2 && pieces_[0].origin == 0.0 &&
         coefficients_[0] == 0.0 && coefficients_[1] == 1.0;
}

}  // namespace sinew
