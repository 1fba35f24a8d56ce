#pragma once

#include <Eigen/Core>
#include <vector>

#include "data/reference_walk.h"
#include "model/spatial.h"

namespace sinew {

/// Force on a foot, at a point of the floor, and torque, about the vertical; all in the world.
struct FloorLoad {
  Eigen::Vector3d force = Eigen::Vector3d::Zero();   // [N]
  Eigen::Vector3d point = Eigen::Vector3d::Zero();   // [m]
  Eigen::Vector3d torque = Eigen::Vector3d::Zero();  // [N m]
};

/// Shares the floor's wrench on the body, [moment about the world's origin; force], among the feet
/// such that their loads together are exactly that wrench and each foot's load is a twice
/// continuously differentiable function of time:
///   f_y,i = s_i F_y                         s_i: smooth steps over double support, Σ s_i = 1
///   c_i = p_i + (c − Σ s_j p_j)             p_i: where the foot's centre of pressure should be
///   f_h,i = s_i F_y (C − c_i)_h / C_y + s_i e_h
/// with mass centre C and e_h what the forces towards it leave of F_h: in double support the feet
/// push against each other as walking feet do. The free moment is shared as s_i.
/// Throws std::invalid_argument if F_y is not positive.
std::vector<FloorLoad> share_wrench(const ReferenceWalk& walk, double time,
                                    const Eigen::Vector3d& p_WC, const Vector6d& wrench);

}  // namespace sinew
