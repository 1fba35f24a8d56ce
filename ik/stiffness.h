#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>

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

/// The same with W = wE, written out: wE, w[r×] and w(r·r E − rrᵀ).
inline void add_point_stiffness(Matrix6d& K, const Eigen::Vector3d& r, double w) {
  const Eigen::Vector3d wr = w * r;
  const double square = wr.dot(r);
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    K(i, i) += square - wr[i] * r[i];
    K(i, j) -= wr[i] * r[j];
    K(i, k) -= wr[i] * r[k];
    K(i, 3 + j) -= wr[k];
    K(i, 3 + k) += wr[j];
    K(3 + j, i) -= wr[k];
    K(3 + k, i) += wr[j];
    K(3 + i, 3 + i) += w;
  }
}

/// [f×][r×]: what turning does to the moment of a force f that is carried along at r.
inline Eigen::Matrix3d turned_load(const Eigen::Vector3d& r, const Eigen::Vector3d& f) {
  Eigen::Matrix3d m = r * f.transpose();  // f × (r × w) = r (f·w) − w (f·r)
  m.diagonal().array() -= f.dot(r);
  return m;
}

/// Second derivative of σ‖γ‖²/2 by rotations: σ( nnᵀ + (φ/2)cot(φ/2)(E − nnᵀ) ), γ = φn.
inline Eigen::Matrix3d orientation_curvature(double weight, const Eigen::Vector3d& gamma) {
  const double phi = gamma.norm();
  if (phi < 1e-6) return weight * Eigen::Matrix3d::Identity();  // φ²/12 below rounding
  const Eigen::Vector3d n = gamma / phi;
  const double c = 0.5 * phi / std::tan(0.5 * phi);
  return weight * (c * Eigen::Matrix3d::Identity() + (1.0 - c) * n * n.transpose());
}

inline bool is_isotropic(const Eigen::Matrix3d& W) {
  const double w = W(0, 0);
  return W(1, 1) == w && W(2, 2) == w && W(0, 1) == 0.0 && W(0, 2) == 0.0 && W(1, 2) == 0.0 &&
         W(1, 0) == 0.0 && W(2, 0) == 0.0 && W(2, 1) == 0.0;
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
