#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "data/c3d_file.h"
#include "data/marker_trajectories.h"

namespace sinew {

/// One of the laboratory's axes with its sign, and how it was found.
struct AxisDecision {
  Eigen::Vector3d axis = Eigen::Vector3d::Zero();  // zero: nothing tells
  double confidence = 0.0;                         // 0 to 1, where 1 is what the user said
  std::string reason;                              // "the reaction forces on the plates", ...

  bool known() const { return !axis.isZero(); }
};

/// Which axis of a laboratory W points up and which the way that the subject goes.
struct LaboratoryAxes {
  AxisDecision up, forward;
  std::vector<std::string> contradictions;  // between what tells; each a sentence

  /// R_MW: from the laboratory to a model's axes M, x forward, y up and z to the right, as
  /// OpenSim's models stand. Throws std::logic_error unless both axes are known.
  Eigen::Matrix3d rotation() const;
};

/// What may tell the axes, each where there is one.
struct AxisEvidence {
  const MarkerTrajectories* markers = nullptr;
  std::optional<C3dScreen> screen = {};
  Eigen::Vector3d reaction = Eigen::Vector3d::Zero();    // sum of forces on the subject, any unit
  std::optional<Eigen::Vector3d> up = {}, forward = {};  // what the user said
};

/// Up, from the first of these that tells: the user; the forces, which carry the subject; names of
/// markers, heads and trunks above feet; POINT:Y_SCREEN; the longest extent of the markers, for a
/// person is taller than wide. Forward: the user; the way that the markers go, if they go at least
/// half a metre; the way that a subject faces whose left and right markers have names; else the
/// axis that keeps a model's z or x where it is. Always the nearest axis of the laboratory.
/// What disagrees with the decision is in `contradictions`. O(frames · markers).
/// Throws std::invalid_argument if the user's axes are not at right angles.
LaboratoryAxes find_axes(const AxisEvidence& evidence);

/// `x`, `-z`, `+Y`, ...; nothing for other texts.
std::optional<Eigen::Vector3d> parse_axis(const std::string& text);
/// `x`, `-z`, ...
std::string axis_name(const Eigen::Vector3d& axis);

/// Rotates every three columns of `values`, in place; NaN stays NaN in all three.
void rotate_vectors(const Eigen::Matrix3d& R, RowMatrix& values);

}  // namespace sinew
