#pragma once

#include "ik/residuals.h"
#include "model/kinematic_tree.h"
#include "model/musculoskeletal_model.h"

namespace sinew {

/// Evaluation 1 of Ayusawa & Nakamura 2012 on the chain of make_manipulator(), its ball joints as
/// quaternions, with unit weights:
///  A  the end-effector's tip at (0.5 m, 0, 0) with orientation [[0,0,1],[0,1,0],[−1,0,0]];
///  B  as A, and for 1 ≤ i < links/2 the origin of link 2i, counted from 0, on the X axis where the
///     straight chain has it, 3i/(3·links − 2) m from the base: body 2i + 1 of the model. (The
///     print multiplies by x^d; only this reading can be met, as its final costs are.)
/// Both are met by the chain stretched along X, which is singular; it starts stretched along Z.
struct ManipulatorCase {
  MusculoskeletalModel model;
  KinematicTree tree;
  IkProblem problem;
  IkTargets targets;
};

/// Throws std::invalid_argument for another letter than A or B or fewer than 1 link.
ManipulatorCase make_manipulator_case(char letter, int links);

}  // namespace sinew
