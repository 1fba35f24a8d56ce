#include "data/coordinate_spline.h"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

#include "data/natural_spline.h"

namespace sinew {

CoordinateSpline::CoordinateSpline(const Eigen::VectorXd& time, const RowMatrix& q)
    : columns_(static_cast<int>(q.cols())), time_(time) {
  if (time.size() < kTerms) {
    throw std::invalid_argument(
        fmt::format("differentiation needs at least {} frames, there are {}", kTerms, time.size()));
  }
  coefficients_ = natural_spline_coefficients(time, q, kTerms / 2);
}

void CoordinateSpline::evaluate(double t, std::span<double> q, std::span<double> q_dot,
                                std::span<double> q_ddot) const {
  if (!(t >= first_time() && t <= last_time())) {
    throw std::invalid_argument(
        fmt::format("{} s is outside the record of {} to {} s", t, first_time(), last_time()));
  }
  const auto above = std::upper_bound(time_.begin(), time_.end(), t) - time_.begin();
  const Eigen::Index i = std::clamp<Eigen::Index>(above - 1, 0, time_.size() - 2);
  const double s = t - time_[i];
  const auto c = [&](int power, int column) { return coefficients_(kTerms * i + power, column); };
  for (int j = 0; j < columns_; ++j) {
    const auto column = static_cast<std::size_t>(j);
    if (!q.empty()) {
      q[column] =
          c(0, j) + s * (c(1, j) + s * (c(2, j) + s * (c(3, j) + s * (c(4, j) + s * c(5, j)))));
    }
    if (!q_dot.empty()) {
      q_dot[column] =
          c(1, j) + s * (2 * c(2, j) + s * (3 * c(3, j) + s * (4 * c(4, j) + s * 5 * c(5, j))));
    }
    if (!q_ddot.empty()) {
      q_ddot[column] = 2 * c(2, j) + s * (6 * c(3, j) + s * (12 * c(4, j) + s * 20 * c(5, j)));
    }
  }
}

}  // namespace sinew
