#pragma once

#include <Eigen/Core>
#include <span>
#include <string>
#include <vector>

#include "ik/auto_scale.h"

namespace sinew {

/// The unknowns θ of auto_scale(): first the logarithm of every factor, then the offset of every
/// free marker, x, y, z.
struct AutoScaleParameters {
  struct Factor {
    std::string name;
    int group = -1;  // factors of one segment have one group
    std::vector<int> bodies;
    int axis = -1;  // −1: all three
  };

  std::vector<Factor> factors;
  std::vector<int> free_markers;  // indices into MusculoskeletalModel::markers
  Eigen::MatrixXd prior_covariance_of_factors;
  Eigen::VectorXd prior_precision_of_offsets;

  int factor_count() const { return static_cast<int>(factors.size()); }
  int count() const { return factor_count() + 3 * static_cast<int>(free_markers.size()); }
  int offset_of(std::size_t free_marker) const {
    return factor_count() + 3 * static_cast<int>(free_marker);
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
