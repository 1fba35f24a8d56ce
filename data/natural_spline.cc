#include "data/natural_spline.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <vector>

// The m-th derivative of a natural spline is a spline of degree m − 1 that vanishes outside the
// data, so with B-splines M_i of order m on the knots x_i … x_{i+m}, each of integral one,
//   f^(m) = Σ c_i M_i,      i = 0 … n − m − 1,                                               (1)
// and by Peano's theorem the divided differences of the data are its moments:
//   Σ_j (∫ M_i M_j) c_j = m! [x_i, …, x_{i+m}] y.                                            (2)
// (Schoenberg 1964; de Boor, A Practical Guide to Splines, ch. IX, X.) The matrix is symmetric
// positive definite, has m − 1 diagonals below its main one and, scaled to a unit diagonal, a
// condition number bounded for all knots. f itself is found interval by interval from (1) and the m
// points about it, so that no error travels along the record.

namespace sinew {
namespace {

constexpr int kMaxHalfOrder = 4;
using Polynomial = std::array<double, kMaxHalfOrder>;  // of s = x − x_k; s^0 first

constexpr std::array<double, 2 * kMaxHalfOrder> kFactorial = {1, 1, 2, 6, 24, 120, 720, 5040};

void check(const Eigen::VectorXd& x, const Eigen::MatrixXd& y, int m) {
  const auto fail = [](const std::string& text) {
    throw std::invalid_argument("natural_spline_coefficients: " + text);
  };
  if (m < 1 || m > kMaxHalfOrder) fail(fmt::format("half_order must be 1 to 4, is {}", m));
  if (y.rows() != x.size()) {
    fail(fmt::format("x has {} values and y has {} rows; they must agree", x.size(), y.rows()));
  }
  if (x.size() < 2 * m) {
    fail(fmt::format("a spline of degree {} needs at least {} points, there are {}", 2 * m - 1,
                     2 * m, x.size()));
  }
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    if (!std::isfinite(x[i])) fail(fmt::format("x[{}] is {}, not finite", i, x[i]));
    if (i > 0 && !(x[i] > x[i - 1])) {
      fail(fmt::format("x must increase strictly; x[{}] = {} follows x[{}] = {}", i, x[i], i - 1,
                       x[i - 1]));
    }
  }
  for (Eigen::Index j = 0; j < y.cols(); ++j) {
    for (Eigen::Index i = 0; i < y.rows(); ++i) {
      if (!std::isfinite(y(i, j))) fail(fmt::format("y({}, {}) is {}, not finite", i, j, y(i, j)));
    }
  }
}

double evaluate(const Polynomial& p, double s, int count) {
  double value = 0.0;
  for (int a = count - 1; a >= 0; --a) value = value * s + p[a];
  return value;
}

// Everything that depends on the abscissae alone.
class Basis {
 public:
  Basis(const Eigen::VectorXd& x, int m)
      : x_(x),
        m_(m),
        n_(static_cast<int>(x.size())),
        pieces_(static_cast<std::size_t>(n_ - 1) * m) {
    for (int k = 0; k < n_ - 1; ++k) build_pieces(k);
    build_gram();
    factor_gram();
  }

  int first_basis(int k) const { return std::max(0, k - m_ + 1); }
  int last_basis(int k) const { return std::min(k, n_ - m_ - 1); }

  // M_i on interval k.
  const Polynomial& piece(int k, int i) const { return pieces_[k * m_ + i - (k - m_ + 1)]; }

  // Solves (2) in place by L·Lᵀ.
  void solve(Eigen::Ref<Eigen::VectorXd> c) const {
    const int size = n_ - m_;
    for (int i = 0; i < size; ++i) {
      for (int d = 1; d < m_ && d <= i; ++d) c[i] -= gram_(d, i) * c[i - d];
      c[i] /= gram_(0, i);
    }
    for (int i = size - 1; i >= 0; --i) {
      for (int d = 1; d < m_ && i + d < size; ++d) c[i] -= gram_(d, i + d) * c[i + d];
      c[i] /= gram_(0, i);
    }
  }

 private:
  // M_{i,r} = r/(r−1) ((x − x_i) M_{i,r−1} + (x_{i+r} − x) M_{i+1,r−1}) / (x_{i+r} − x_i), which
  // needs no knot outside i … i + r; those with knots outside the data do not occur in (1).
  void build_pieces(int k) {
    Polynomial* const p = &pieces_[static_cast<std::size_t>(k) * m_];  // p[i − (k − m + 1)]
    const auto at = [&](int i) -> Polynomial& { return p[i - (k - m_ + 1)]; };
    at(k) = {1.0 / (x_[k + 1] - x_[k])};
    for (int r = 2; r <= m_; ++r) {
      for (int i = k - r + 1; i <= k; ++i) {
        if (i < 0 || i + r >= n_) continue;
        const Polynomial lower = i > k - r + 1 ? at(i) : Polynomial{};
        const Polynomial upper = i < k ? at(i + 1) : Polynomial{};
        const double scale = r / (r - 1.0) / (x_[i + r] - x_[i]);
        Polynomial q{};
        for (int a = 0; a < r; ++a) {
          q[a] = (x_[k] - x_[i]) * lower[a] + (x_[i + r] - x_[k]) * upper[a];
          if (a > 0) q[a] += lower[a - 1] - upper[a - 1];
          q[a] *= scale;
        }
        at(i) = q;
      }
    }
  }

  // ∫ M_i M_j, stored as gram_(i − j, i) for i ≥ j. Gauss-Legendre on m points is exact for the
  // degree 2m − 2, and all its terms are positive.
  void build_gram() {
    static constexpr std::array<std::array<double, 4>, 4> kNodes = {
        {{0.0},
         {-0.57735026918962576, 0.57735026918962576},
         {-0.77459666924148338, 0.0, 0.77459666924148338},
         {-0.86113631159405258, -0.33998104358485626, 0.33998104358485626, 0.86113631159405258}}};
    static constexpr std::array<std::array<double, 4>, 4> kWeights = {
        {{2.0},
         {1.0, 1.0},
         {5.0 / 9.0, 8.0 / 9.0, 5.0 / 9.0},
         {0.34785484513745386, 0.65214515486254614, 0.65214515486254614, 0.34785484513745386}}};
    gram_ = Eigen::MatrixXd::Zero(m_, n_ - m_);
    for (int k = 0; k < n_ - 1; ++k) {
      const double half = 0.5 * (x_[k + 1] - x_[k]);
      for (int g = 0; g < m_; ++g) {
        const double s = half * (1.0 + kNodes[m_ - 1][g]);
        for (int i = first_basis(k); i <= last_basis(k); ++i) {
          const double weighted = half * kWeights[m_ - 1][g] * evaluate(piece(k, i), s, m_);
          for (int j = first_basis(k); j <= i; ++j) {
            gram_(i - j, i) += weighted * evaluate(piece(k, j), s, m_);
          }
        }
      }
    }
  }

  void factor_gram() {
    for (int i = 0; i < n_ - m_; ++i) {
      for (int d = std::min(m_ - 1, i); d >= 0; --d) {
        const int j = i - d;
        double value = gram_(d, i);
        for (int e = d + 1; e < m_ && e <= i; ++e) {
          value -= gram_(e, i) * gram_(e - d, j);
        }
        gram_(d, i) = d > 0 ? value / gram_(0, j) : std::sqrt(value);
      }
    }
  }

  const Eigen::VectorXd& x_;
  int m_, n_;
  std::vector<Polynomial> pieces_;
  Eigen::MatrixXd gram_;  // m × (n − m), later its Cholesky factor
};

// m! [x_i, …, x_{i+m}] y for every i.
Eigen::VectorXd scaled_divided_differences(const Eigen::VectorXd& x,
                                           const Eigen::Ref<const Eigen::VectorXd>& y, int m) {
  Eigen::VectorXd d = y;
  for (int r = 1; r <= m; ++r) {
    for (Eigen::Index i = 0; i + r < x.size(); ++i) {
      d[i] = r * (d[i + 1] - d[i]) / (x[i + r] - x[i]);
    }
  }
  return d.head(x.size() - m);
}

// State of the m-fold integral g of f^(m): derivatives 0 … m − 1 at the start of an interval.
void advance(Polynomial& derivatives, const Polynomial& source, double h, int m) {
  Polynomial next{};
  for (int order = 0; order < m; ++order) {
    double power = 1.0;
    for (int r = order; r < m; ++r, power *= h) {
      next[order] += derivatives[r] * power / kFactorial[r - order];
    }
    for (int a = 0; a < m; ++a, power *= h) {
      next[order] += source[a] * kFactorial[a] / kFactorial[a + m - order] * power;
    }
  }
  derivatives = next;
}

// Taylor coefficients about `centre` of the polynomial through m points.
Polynomial taylor_of_interpolant(const double* x, Polynomial values, double centre, int m) {
  for (int r = 1; r < m; ++r) {
    for (int i = m - 1; i >= r; --i) {
      values[i] = (values[i] - values[i - 1]) / (x[i] - x[i - r]);
    }
  }
  Polynomial taylor{};
  for (int i = m - 1; i >= 0; --i) {
    for (int a = m - 1; a > 0; --a) taylor[a] = taylor[a - 1] + (centre - x[i]) * taylor[a];
    taylor[0] = values[i] + (centre - x[i]) * taylor[0];
  }
  return taylor;
}

class ColumnSpline {
 public:
  ColumnSpline(const Eigen::VectorXd& x, const Basis& basis, int m)
      : x_(x), basis_(basis), m_(m), source_(x.size() - 1) {}

  void compute(const Eigen::Ref<const Eigen::VectorXd>& y, Eigen::Ref<Eigen::VectorXd> result) {
    Eigen::VectorXd c = scaled_divided_differences(x_, y, m_);
    basis_.solve(c);
    const int intervals = static_cast<int>(source_.size());
    for (int k = 0; k < intervals; ++k) {
      source_[k] = {};
      for (int i = basis_.first_basis(k); i <= basis_.last_basis(k); ++i) {
        for (int a = 0; a < m_; ++a) source_[k][a] += c[i] * basis_.piece(k, i)[a];
      }
    }
    for (int k = 0; k < intervals; ++k) reconstruct(k, y, result.segment(2 * m_ * k, 2 * m_));
  }

 private:
  // f = g + p on interval k: g is the m-fold integral of (1) from the start of a window of m points
  // about the interval, p the polynomial of degree m − 1 that makes f meet the window's points.
  void reconstruct(int k, const Eigen::Ref<const Eigen::VectorXd>& y,
                   Eigen::Ref<Eigen::VectorXd> f) const {
    const int points = static_cast<int>(x_.size());
    const int first = std::clamp(k - (m_ - 1) / 2, 0, points - m_);
    Polynomial g{}, g_k{}, rest{};
    for (int j = 0; j < m_; ++j) {
      if (first + j == k) g_k = g;
      rest[j] = y[first + j] - g[0];
      if (j + 1 < m_) advance(g, source_[first + j], x_[first + j + 1] - x_[first + j], m_);
    }
    const Polynomial p = taylor_of_interpolant(&x_[first], rest, x_[k], m_);
    for (int r = 0; r < m_; ++r) f[r] = p[r] + g_k[r] / kFactorial[r];
    for (int a = 0; a < m_; ++a) f[m_ + a] = source_[k][a] * kFactorial[a] / kFactorial[a + m_];
  }

  const Eigen::VectorXd& x_;
  const Basis& basis_;
  int m_;
  std::vector<Polynomial> source_;  // f^(m) on every interval
};

}  // namespace

Eigen::MatrixXd natural_spline_coefficients(const Eigen::VectorXd& x, const Eigen::MatrixXd& y,
                                            int half_order) {
  check(x, y, half_order);
  const Basis basis(x, half_order);
  ColumnSpline column(x, basis, half_order);
  Eigen::MatrixXd coefficients(2 * half_order * (x.size() - 1), y.cols());
  for (Eigen::Index j = 0; j < y.cols(); ++j) column.compute(y.col(j), coefficients.col(j));
  return coefficients;
}

}  // namespace sinew
