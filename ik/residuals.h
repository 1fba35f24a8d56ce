#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "model/kinematic_tree.h"

/// What inverse kinematics makes small. Residual kinds (a), (b), (c) and the cost are those of
/// Ayusawa & Nakamura 2012; coordinate targets and the residuals of cut loops are ours.
namespace sinew {

/// (a) Δp = p^d − p(q), eq. (1): a point of a link, such as a marker.
struct PositionResidual {
  int link = 0;
  Eigen::Vector3d p_BP = Eigen::Vector3d::Zero();        // [m]
  Eigen::Matrix3d weight = Eigen::Matrix3d::Identity();  // Σ_P, symmetric ≥ 0 [1/m²]
};

/// (b) Δγ = log(R^d Rᵀ), eqs. (2)(4): the orientation of frame F on a link.
struct OrientationResidual {
  int link = 0;
  Eigen::Matrix3d R_BF = Eigen::Matrix3d::Identity();
  Eigen::Matrix3d weight = Eigen::Matrix3d::Identity();  // Σ_L, symmetric ≥ 0 [1/rad²]
};

/// (c) Δl = l^d − l(q), eq. (3): the distance of two points.
struct DistanceResidual {
  int link_a = 0, link_b = 0;
  Eigen::Vector3d p_AP = Eigen::Vector3d::Zero(), p_BQ = Eigen::Vector3d::Zero();  // [m]
  double weight = 1.0;                                                             // σ_D [1/m²]
};

/// Where a wire passes. A point with a condition is on the path only while q[condition_q] is within
/// [condition_min, condition_max].
struct WirePoint {
  int link = 0;
  Eigen::Vector3d p_BP = Eigen::Vector3d::Zero();  // [m]
  int condition_q = -1;
  double condition_min = 0.0, condition_max = 0.0;
};

/// min{0, Δl} with Δl = l^d − l(q), eq. (38): a muscle, tendon or ligament along a polyline, which
/// pulls when it would be longer than its natural length and is slack otherwise.
struct WireResidual {
  int first_point = 0, point_count = 0;  // in IkProblem::wire_points; the first and the last always
                                         // on the path
  double natural_length = 0.0;           // l^d [m]
  double weight = 1.0;                   // ρσ_D [1/m²]
};

/// A coordinate near a value, as OpenSim's IKCoordinateTask.
struct CoordinateResidual {
  int q = 0, v = 0;
  double weight = 1.0;  // [1/rad² or 1/m²]
};

/// Two points that a cut loop keeps together.
struct CoincidenceResidual {
  int link_a = 0, link_b = 0;
  Eigen::Vector3d p_AP = Eigen::Vector3d::Zero(), p_BQ = Eigen::Vector3d::Zero();  // [m]
  double weight = 1.0;                                                             // [1/m²]
};

/// Two frames that a cut loop keeps parallel.
struct AlignmentResidual {
  int link_a = 0, link_b = 0;
  Eigen::Matrix3d R_AF = Eigen::Matrix3d::Identity(), R_BG = Eigen::Matrix3d::Identity();
  double weight = 1.0;  // [1/rad²]
};

/// All residuals of a model and recording; constant over the frames.
struct IkProblem {
  std::vector<PositionResidual> positions;
  std::vector<OrientationResidual> orientations;
  std::vector<DistanceResidual> distances;
  std::vector<WireResidual> wires;
  std::vector<WirePoint> wire_points;
  std::vector<CoordinateResidual> coordinates;
  std::vector<CoincidenceResidual> coincidences;
  std::vector<AlignmentResidual> alignments;
};

/// What one frame asks for; sizes as IkProblem's. NaN: not measured, the residual drops out.
struct IkTargets {
  std::vector<Eigen::Vector3d> positions;     // p_WP^d [m]
  std::vector<Eigen::Matrix3d> orientations;  // R_WF^d
  std::vector<double> distances;              // l^d [m]
  std::vector<double> coordinates;            // [rad or m]
  // What Σ_P of each position is multiplied by in this frame, 0 or more; empty: 1.
  std::vector<double> position_scales = {};
  // Likewise of each coordinate's weight.
  std::vector<double> coordinate_scales = {};

  /// Sized for `problem`, everything missing.
  explicit IkTargets(const IkProblem& problem);
};

inline double position_scale(const IkTargets& targets, std::size_t i) {
  return targets.position_scales.empty() ? 1.0 : targets.position_scales[i];
}

/// Σ_P of a position residual in this frame.
inline Eigen::Matrix3d position_weight(const IkProblem& problem, const IkTargets& targets,
                                       std::size_t i) {
  return position_scale(targets, i) * problem.positions[i].weight;
}

/// Weight of a coordinate residual in this frame.
inline double coordinate_weight(const IkProblem& problem, const IkTargets& targets, std::size_t i) {
  const double weight = problem.coordinates[i].weight;
  return targets.coordinate_scales.empty() ? weight : targets.coordinate_scales[i] * weight;
}

/// Whether a point of a wire is on its path at the workspace's q.
inline bool is_on_path(const WirePoint& point, const KinematicWorkspace& workspace) {
  if (point.condition_q < 0) return true;
  const double q = workspace.q[static_cast<std::size_t>(point.condition_q)];
  return q >= point.condition_min && q <= point.condition_max;
}

inline const WirePoint& wire_point(const IkProblem& problem, const WireResidual& wire, int i) {
  return problem.wire_points[static_cast<std::size_t>(wire.first_point + i)];
}

/// Length of a wire's polyline [m]. Needs poses.
double wire_length(const IkProblem& problem, const WireResidual& wire,
                   const KinematicWorkspace& workspace);

/// Calls use(i, p_W, u) for every point of a wire that is on the path, i its number among the
/// wire's points: p_W is the point's place and u the sum of the unit vectors from its neighbours to
/// it, so that l̇ = Σ uᵀ ṗ. Needs poses.
template <typename Use>
void for_each_wire_point(const IkProblem& problem, const WireResidual& wire,
                         const KinematicWorkspace& workspace, const Use& use) {
  const WirePoint* const points = problem.wire_points.data() + wire.first_point;
  const auto place = [&](const WirePoint& point) -> Eigen::Vector3d {
    return workspace.X_WB[static_cast<std::size_t>(point.link)] * point.p_BP;
  };
  Eigen::Vector3d p = place(points[0]), before = Eigen::Vector3d::Zero();
  int current = 0;
  for (int i = 1; i < wire.point_count; ++i) {
    if (!is_on_path(points[i], workspace)) continue;
    const Eigen::Vector3d next = place(points[i]);
    const Eigen::Vector3d segment = next - p;
    const double length = segment.norm();
    // Between coincident points there is no direction.
    const Eigen::Vector3d after =
        length > 0.0 ? Eigen::Vector3d(segment / length) : Eigen::Vector3d::Zero();
    use(current, p, Eigen::Vector3d(before - after));
    p = next;
    current = i;
    before = after;
  }
  use(current, p, before);
}

/// Rotation vector φn of a rotation matrix, φ in [0, π], by way of the quaternion, which keeps it
/// exact near φ = 0 and continuous near φ = π where eqs. (5)(6) lose n.
Eigen::Vector3d rotation_vector(const Eigen::Matrix3d& R);

/// K_γ of eqs. (14)(16): Δγ̇ = −K_γ ω for a link turning at ω [world]. By finite differences the
/// linear term is +(φ/2)[n×] in our convention ΔR = R^d Rᵀ.
Eigen::Matrix3d rotation_vector_rate(const Eigen::Vector3d& gamma);

/// f(q) = ½ Σ Δpᵀ Σ_P Δp + ½ Σ Δγᵀ Σ_L Δγ + ½ Σ σ_D Δl² + …, eqs. (11)(38). Needs poses.
double cost(const KinematicTree& tree, const IkProblem& problem, const IkTargets& targets,
            const KinematicWorkspace& workspace);

/// DGC: the cost and its gradient g with respect to the unknowns by eqs. (19)-(28), in
/// O(links + residuals): every residual is an elastic force on its link, and the joint torques that
/// hold them are the gradient. Needs update_kinematics(). g: unknowns.
double decomposed_gradient(const KinematicTree& tree, const IkProblem& problem,
                           const IkTargets& targets, KinematicWorkspace& workspace,
                           Eigen::Ref<Eigen::VectorXd> g);

/// The baseline: the same by explicit Jacobians, eqs. (12)-(16), each over the ancestors of its
/// link only; O(residuals × depth). `J`: scratch of 3 × unknowns.
double jacobian_gradient(const KinematicTree& tree, const IkProblem& problem,
                         const IkTargets& targets, const KinematicWorkspace& workspace,
                         Eigen::Matrix3Xd& J, Eigen::Ref<Eigen::VectorXd> g);

/// Throws std::invalid_argument, naming the residual, for links out of range, weights that are not
/// finite, not symmetric or negative, and sizes of targets that differ from the problem's.
void validate(const KinematicTree& tree, const IkProblem& problem, const IkTargets& targets);

}  // namespace sinew
