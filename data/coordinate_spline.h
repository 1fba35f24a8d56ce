#pragma once

#include <Eigen/Core>
#include <span>

#include "data/time_table.h"

namespace sinew {

/// Positions, velocities and accelerations between samples: the quintic natural spline through each
/// column (see natural_spline_coefficients), which is what OpenSim differentiates coordinates with.
/// Immutable; evaluation allocates nothing and costs a binary search and O(columns).
class CoordinateSpline {
 public:
  /// time: n [s], strictly increasing; q: n × columns, any units.
  /// Throws std::invalid_argument for fewer than 6 samples or what
  /// natural_spline_coefficients rejects.
  CoordinateSpline(const Eigen::VectorXd& time, const RowMatrix& q);

  int size() const { return columns_; }
  double first_time() const { return time_[0]; }
  double last_time() const { return time_[time_.size() - 1]; }

  /// q, q̇, q̈ at t; an empty span is not computed, the others have size() elements.
  /// Throws std::invalid_argument if t is outside first_time() … last_time(), because a quintic
  /// leaves the data at once.
  void evaluate(double t, std::span<double> q, std::span<double> q_dot,
                std::span<double> q_ddot) const;

 private:
  static constexpr int kTerms = 6;

  int columns_;
  Eigen::VectorXd time_;
  RowMatrix coefficients_;  // 6·(n − 1) × columns, so that one interval lies together
};

}  // namespace sinew
