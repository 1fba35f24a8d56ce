#pragma once

#include <Eigen/Core>

namespace sinew {

/// The minimum of gᵀp + ½ pᵀ H p within lower ≤ p ≤ upper, H symmetric and positive definite.
/// Primal active set (Nocedal & Wright 2006, sec. 16.5): Newton's step in what is free, cut at the
/// first bound that it meets, which then holds; a bound lets go where the gradient points inwards.
/// The minimum is unique. Throws std::invalid_argument where 0 is not within the bounds or sizes
/// differ. O(n³) for each bound that holds or lets go.
Eigen::VectorXd minimize_in_box(const Eigen::MatrixXd& H, const Eigen::VectorXd& g,
                                const Eigen::VectorXd& lower, const Eigen::VectorXd& upper);

}  // namespace sinew
