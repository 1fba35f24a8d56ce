#pragma once

#include <Eigen/Core>
#include <span>
#include <string>
#include <vector>

#include "ik/auto_scale.h"

namespace sinew {

/// The unknowns θ of auto_scale(): first the logarithm of the body's size; then, for every factor,
/// its logarithm less that of the size; then the offset of every free marker, x, y, z. A box holds
/// them.
struct AutoScaleParameters {
  struct Factor {
    std::string name;
    int group = -1;  // factors of one segment have one group
    std::vector<int> bodies;
    int axis = -1;  // −1: all three
  };

  std::vector<Factor> factors;
  std::vector<int> free_markers;                // indices into MusculoskeletalModel::markers
  double size_sd = 0.0;                         // prior, of θ's first
  Eigen::MatrixXd prior_covariance_of_factors;  // of their logarithms, the size's part in it
  Eigen::VectorXd prior_precision_of_offsets;
  Eigen::VectorXd lower, upper;  // of θ

  int factor_count() const { return static_cast<int>(factors.size()); }
  int count() const { return 1 + factor_count() + 3 * static_cast<int>(free_markers.size()); }
  static int deviation_of(int factor) { return 1 + factor; }
  int offset_of(std::size_t free_marker) const {
    return 1 + factor_count() + 3 * static_cast<int>(free_marker);
  }
  double log_factor(const Eigen::VectorXd& theta, int factor) const {
    return theta[0] + theta[deviation_of(factor)];
  }

  /// P⁻¹ of the header's equation.
  Eigen::MatrixXd prior_precision() const;
  ScaleFactors scale_factors(const MusculoskeletalModel& model, const Eigen::VectorXd& theta) const;
  /// The model with its geometry scaled and its markers moved.
  MusculoskeletalModel apply(const MusculoskeletalModel& model, const Eigen::VectorXd& theta) const;
};

/// Which bodies share factors, which markers may move, and what is known of both beforehand.
/// `tracked`: indices of the model's markers that are measured. Throws std::invalid_argument naming
/// a body of options.groups that the model does not have.
AutoScaleParameters choose_parameters(const MusculoskeletalModel& model,
                                      std::span<const int> tracked,
                                      const AutoScaleOptions& options);

}  // namespace sinew
