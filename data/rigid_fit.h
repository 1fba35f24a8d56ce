#pragma once

#include <Eigen/Core>

namespace sinew {

/// measured ≈ R·points + t.
struct RigidFit {
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  Eigen::Vector3d t = Eigen::Vector3d::Zero();
  double misfit = 0.0;  // weighted RMS of what is left
  // Roots of the two largest principal values of the points' weighted squares about their mean:
  // where `width` is little the points lie near one line, and the turn about that is not told.
  double length = 0.0, width = 0.0;
};

/// The rotation and shift that carries one cloud of points onto another best, min Σ w·|R·points + t
/// − measured|², by the singular value decomposition of their covariance (Arun, Huang & Blostein
/// 1987, IEEE Trans Pattern Anal 9:698-700), never a reflection. points, measured: 3 × n; weights:
/// n, of positive sum. O(n).
RigidFit fit_rigidly(const Eigen::Matrix3Xd& points, const Eigen::Matrix3Xd& measured,
                     const Eigen::VectorXd& weights);

}  // namespace sinew
