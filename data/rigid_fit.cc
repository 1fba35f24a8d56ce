#include "data/rigid_fit.h"

#include <Eigen/LU>
#include <Eigen/SVD>
#include <cmath>

namespace sinew {

using Eigen::Matrix3d;
using Eigen::Matrix3Xd;
using Eigen::Vector3d;

RigidFit fit_rigidly(const Matrix3Xd& points, const Matrix3Xd& measured,
                     const Eigen::VectorXd& weights) {
  const double sum = weights.sum();
  const Vector3d mean = points * weights / sum, mean_measured = measured * weights / sum;
  const Matrix3Xd from = points.colwise() - mean, to = measured.colwise() - mean_measured;
  const Matrix3d spread = from * weights.asDiagonal() * from.transpose();
  const Vector3d squares = Eigen::JacobiSVD<Matrix3d>(spread).singularValues();
  const Matrix3d C = to * weights.asDiagonal() * from.transpose();
  const Eigen::JacobiSVD<Matrix3d> svd(C, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const double mirrored = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0.0 ? -1 : 1;
  RigidFit fit;
  fit.R = svd.matrixU() * Vector3d(1.0, 1.0, mirrored).asDiagonal() * svd.matrixV().transpose();
  fit.t = mean_measured - fit.R * mean;
  fit.misfit =
      std::sqrt((fit.R * from - to).colwise().squaredNorm().dot(weights.transpose()) / sum);
  fit.length = std::sqrt(squares[0]);
  fit.width = std::sqrt(squares[1]);
  return fit;
}

}  // namespace sinew
