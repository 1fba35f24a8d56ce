#pragma once

#include <Eigen/Core>
#include <cmath>
#include <span>
#include <vector>

#include "ik/residuals.h"

namespace sinew {

/// Rows of J for the residuals between links: distances, wires and cut loops. Their forces are
/// internal to the body, so that a row has entries only for the joints between its links: a walk
/// along these gives it, and with wires to near neighbours JᵀΣJ is sparse.
///
/// A row is Σ uᵢᵀ J_Bp,i over the points of the residual, eq. (15): every point puts the wrench of
/// the unit force uᵢ on its link, and the entry of a joint is Sᵀ times the sum of the wrenches that
/// it carries. Allocates at construction only.
class InternalRows {
 public:
  InternalRows(const KinematicTree& tree, const IkProblem& problem);

  /// Twists and coupling slopes of this pose, for all that follows. Needs update_kinematics().
  void update(const KinematicTree& tree, const KinematicWorkspace& workspace);

  /// Calls use(i, row, weight) for every row of a residual that is measured and not slack; row[k]
  /// is the entry of support(i)[k].
  template <typename Use>
  void for_each(const IkProblem& problem, const IkTargets& targets,
                const KinematicWorkspace& workspace, const Use& use);

  /// The unknowns of every residual that can have a row, ascending.
  int support_count() const { return static_cast<int>(supports_.size()); }
  std::span<const int> support(int i) const {
    const Support& s = supports_[static_cast<std::size_t>(i)];
    return {unknowns_.data() + s.first_unknown, static_cast<std::size_t>(s.unknown_count)};
  }

  /// Columns S of all v, about the point origin() in world axes.
  const std::vector<Vector6d>& twists() const { return twists_; }
  const Eigen::Vector3d& origin() const { return origin_; }
  /// The unknown that drives v, −1 without one, and the slope of the couplings in between.
  int driver(int v) const { return driver_[static_cast<std::size_t>(v)]; }
  double driver_slope(int v) const { return slope_[static_cast<std::size_t>(v)]; }

 private:
  struct PathLink {
    int parent_slot;  // of the parent among the support's links, −1 at the end of the path
    int first_entry, entry_count;
  };
  struct Entry {
    int v, slot;  // the column of S and its unknown's place in the support
  };
  struct Support {
    int first_link = 0, link_count = 0;  // from the leaves to the root
    int first_point = 0;                 // in point_slots_
    int first_unknown = 0, unknown_count = 0;
  };

  void add_support(const KinematicTree& tree, std::span<const int> links, bool to_root);
  void begin(const Support& support);
  void put_force(const Support& support, int point, const Eigen::Vector3d& p_W,
                 const Eigen::Vector3d& u);
  void put_moment(const Support& support, int point, const Eigen::Vector3d& m);
  std::span<const double> row(const Support& support);
  template <typename Use>
  void use_row(std::size_t support, double weight, const Use& use) {
    use(static_cast<int>(support), row(supports_[support]), weight);
  }

  std::vector<Support> supports_;  // distances, wires, coincidences, alignments in turn
  std::vector<PathLink> path_links_;
  std::vector<Entry> entries_;
  std::vector<int> point_slots_;  // where a point's link stands in its support, −1: it is not moved
  std::vector<int> unknowns_;
  std::vector<int> driver_;
  std::vector<double> slope_;
  std::vector<Vector6d> twists_;
  std::vector<Vector6d> wrenches_;  // of the links of one support
  std::vector<double> row_;
  Eigen::Vector3d origin_ = Eigen::Vector3d::Zero();
};

template <typename Use>
void InternalRows::for_each(const IkProblem& problem, const IkTargets& targets,
                            const KinematicWorkspace& ws, const Use& use) {
  const auto place = [&](int link, const Eigen::Vector3d& p) -> Eigen::Vector3d {
    return ws.X_WB[static_cast<std::size_t>(link)] * p;
  };
  std::size_t s = 0;
  for (std::size_t i = 0; i < problem.distances.size(); ++i, ++s) {
    const DistanceResidual& r = problem.distances[i];
    const Eigen::Vector3d pa = place(r.link_a, r.p_AP), pb = place(r.link_b, r.p_BQ);
    const double length = (pa - pb).norm();
    if (std::isnan(targets.distances[i]) || length == 0.0) continue;
    const Eigen::Vector3d u = (pa - pb) / length;
    begin(supports_[s]);
    put_force(supports_[s], 0, pa, u);
    put_force(supports_[s], 1, pb, -u);
    use_row(s, r.weight, use);
  }
  for (std::size_t i = 0; i < problem.wires.size(); ++i, ++s) {
    const WireResidual& r = problem.wires[i];
    if (!(wire_length(problem, r, ws) > r.natural_length)) continue;
    begin(supports_[s]);
    for_each_wire_point(problem, r, ws,
                        [&](int point, const Eigen::Vector3d& p, const Eigen::Vector3d& u) {
                          put_force(supports_[s], point, p, u);
                        });
    use_row(s, r.weight, use);
  }
  for (const CoincidenceResidual& r : problem.coincidences) {
    const Eigen::Vector3d pa = place(r.link_a, r.p_AP), pb = place(r.link_b, r.p_BQ);
    for (int axis = 0; axis < 3; ++axis) {
      begin(supports_[s]);
      put_force(supports_[s], 0, pa, Eigen::Vector3d::Unit(axis));
      put_force(supports_[s], 1, pb, -Eigen::Vector3d::Unit(axis));
      use_row(s, r.weight, use);
    }
    ++s;
  }
  for (const AlignmentResidual& r : problem.alignments) {
    for (int axis = 0; axis < 3; ++axis) {  // γ ≈ 0 on a closed loop, so K_γ ≈ E
      begin(supports_[s]);
      put_moment(supports_[s], 0, Eigen::Vector3d::Unit(axis));
      put_moment(supports_[s], 1, -Eigen::Vector3d::Unit(axis));
      use_row(s, r.weight, use);
    }
    ++s;
  }
}

}  // namespace sinew
