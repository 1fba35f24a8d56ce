#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>

/// Notation, used in the whole project.
///
/// Frames: W world (ground), P parent body, B child body, F the joint's frame on P, M the joint's
/// frame on B. p_AB is the position of B's origin measured from A's origin, in A's axes unless
/// another frame follows (p_AB_W). R_AB turns vectors from B's axes to A's; X_AB = (R_AB, p_AB).
/// Spatial vectors are [angular; linear]: a twist is [w; v], a wrench [moment; force].
namespace sinew {

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

/// A pose X_AB.
struct RigidTransform {
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  Eigen::Vector3d p = Eigen::Vector3d::Zero();

  RigidTransform inverse() const { return {R.transpose(), -(R.transpose() * p)}; }
  RigidTransform operator*(const RigidTransform& X_BC) const {
    return {R * X_BC.R, p + R * X_BC.p};
  }
  Eigen::Vector3d operator*(const Eigen::Vector3d& p_BQ) const { return p + R * p_BQ; }
  bool operator==(const RigidTransform&) const = default;
};

/// [v×], so that skew(v)·x = v × x.
inline Eigen::Matrix3d skew(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

/// Body-fixed X-Y-Z rotation R = Rx(a.x)·Ry(a.y)·Rz(a.z), OpenSim's `orientation` [rad].
inline Eigen::Matrix3d rotation_from_body_xyz(const Eigen::Vector3d& angles) {
  using Eigen::AngleAxisd;
  using Eigen::Vector3d;
  return (AngleAxisd(angles.x(), Vector3d::UnitX()) * AngleAxisd(angles.y(), Vector3d::UnitY()) *
          AngleAxisd(angles.z(), Vector3d::UnitZ()))
      .toRotationMatrix();
}

/// Angles [rad] that rotation_from_body_xyz() turns into R again, to rounding. The first is within
/// ±π and the second within ±π/2; where the second is ±π/2, the first is whatever rounding left.
inline Eigen::Vector3d body_xyz_from_rotation(const Eigen::Matrix3d& R) {
  const double x = std::atan2(-R(1, 2), R(2, 2));
  const double cx = std::cos(x), sx = std::sin(x);
  // Of Rx(−x)·R, so that the other two fit whatever x is near the singularity.
  const double y = std::atan2(R(0, 2), cx * R(2, 2) - sx * R(1, 2));
  const double z = std::atan2(cx * R(1, 0) + sx * R(2, 0), cx * R(1, 1) + sx * R(2, 1));
  return Eigen::Vector3d(x, y, z) + Eigen::Vector3d::Zero();  // no −0
}

}  // namespace sinew
