#pragma once

#include <optional>
#include <span>

#include "ik/residuals.h"
#include "model/kinematic_tree.h"

namespace sinew {

/// The rigid motion X that takes points p to measured places p^d with the least Σ w|p^d − X p|²:
/// the shift takes the weighted mean of one to that of the other, and the turn is the proper one of
/// the singular value decomposition of Σ w p^d pᵀ about the means (W. Kabsch, Acta Cryst. A32,
/// 1976; S. Umeyama, IEEE PAMI 13, 1991). Nothing for fewer than three points and for points on
/// one line, which leave a turn open. points, measured: 3 × n [m]; weights: n, 0 or more.
std::optional<RigidTransform> rigid_fit(const Eigen::Matrix3Xd& points,
                                        const Eigen::Matrix3Xd& measured,
                                        const Eigen::VectorXd& weights);

/// Moves each link that hangs on ground, with all that hangs on it as one rigid body, onto the
/// measured positions of its markers by rigid_fit(), and sets the coordinates of its joint to that
/// pose. Joints of three turns about perpendicular axes and three shifts, each a coordinate of its
/// own, take it exactly; others, such as a planar one, go as near to it as they can. Locked and
/// prescribed coordinates and those out of their range stay where they can be, so that the pose may
/// not be met. Links whose markers do not determine a pose stay. `links`: a link's markers count
/// where its entry is true; empty: all. Allocates.
void align_roots(const KinematicTree& tree, const IkProblem& problem, const IkTargets& targets,
                 std::span<const char> links, std::span<double> q);

}  // namespace sinew
