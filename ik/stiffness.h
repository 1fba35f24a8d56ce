#pragma once

#include <Eigen/Core>

#include "model/spatial.h"

/// Stiffness of links: 6×6 matrices on [angular; linear], world axes, at a link's origin.
namespace sinew {

/// (N3): adds a point at r from the link's origin that a spring of weight W holds.
inline void add_point_stiffness(Matrix6d& K, const Eigen::Vector3d& r, const Eigen::Matrix3d& W) {
  const Eigen::Matrix3d R = skew(r);
  const Eigen::Matrix3d RW = R * W;
  K.topLeftCorner<3, 3>() -= RW * R;
  K.topRightCorner<3, 3>() += RW;
  K.bottomLeftCorner<3, 3>() += RW.transpose();
  K.bottomRightCorner<3, 3>() += W;
}

/// Adds to the parent's stiffness what its child, whose origin is at r from the parent's, passes
/// on: XᵀKX with X = [E 0; −r× E].
inline void add_shifted_stiffness(Matrix6d& K_parent, const Matrix6d& K, const Eigen::Vector3d& r) {
  const Eigen::Matrix3d R = skew(r);
  const Eigen::Matrix3d B = K.topRightCorner<3, 3>(), C = K.bottomRightCorner<3, 3>();
  const Eigen::Matrix3d RC = R * C;
  const Eigen::Matrix3d RBt = R * B.transpose();
  K_parent.topLeftCorner<3, 3>() += K.topLeftCorner<3, 3>() + RBt + RBt.transpose() - RC * R;
  const Eigen::Matrix3d B_parent = B + RC;
  K_parent.topRightCorner<3, 3>() += B_parent;
  K_parent.bottomLeftCorner<3, 3>() += B_parent.transpose();
  K_parent.bottomRightCorner<3, 3>() += C;
}

}  // namespace sinew
