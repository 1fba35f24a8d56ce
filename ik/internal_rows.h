#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
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

  /// The same without wires.
  template <typename Use>
  void for_each_but_wires(const IkProblem& problem, const IkTargets& targets,
                          const KinematicWorkspace& workspace, const Use& use);

  /// Of one wire, slack or not: its support and its row.
  struct WireRow {
    int support;
    std::span<const double> row;
  };
  WireRow wire_row(const IkProblem& problem, std::size_t wire, const KinematicWorkspace& workspace);

  /// What the second derivatives of distances add to wjjᵀ, j their row and w its weight: with the
  /// force wε in them, ε the length in excess,
  ///  - wε ∇∇l at fixed directions: rows as above for two directions across it, of weight wε/l,
  ///    given to `use`;
  ///  - turning a joint turns the forces that it carries: with f the force on a point at r,
  ///    ∂g_u/∂q_v = w_uᵀ Σ (f × (r × w_v) − f × v_v) over the points that v moves, u before v on
  ///    the way from the root; given to `use_pair`(i, entry, h), the entry of (u, v) among those of
  ///    the lower triangle of support(i), row by row.
  /// Within a joint the sum is exact where order() tells its columns apart or they are a ball's.
  template <typename Use, typename UsePair>
  void for_each_second(const IkProblem& problem, const IkTargets& targets,
                       const KinematicWorkspace& workspace, const Use& use,
                       const UsePair& use_pair);

  /// Gives to `use` as above, of one wire with `force` in it, force · ∇∇l of every stretch at fixed
  /// directions.
  template <typename Use>
  void for_each_across(const IkProblem& problem, std::size_t wire,
                       const KinematicWorkspace& workspace, double force, const Use& use);

  /// The number of a wire's support, and whether a support is a wire's.
  int support_of_wire(std::size_t wire) const { return first_wire_ + static_cast<int>(wire); }
  bool is_wire(int support) const {
    return support >= first_wire_ && support < first_wire_ + wire_count_;
  }

  /// Which of a joint's columns carries which: those of higher order are carried by the others.
  /// Columns of the same order share one turn, or share steps; their second derivatives are taken
  /// as symmetric.
  int order(int v) const { return order_[static_cast<std::size_t>(v)]; }

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
  // Geometry of a force on a point, see for_each_second().
  void begin_loads(const Support& support);
  void put_load(const Support& support, int point, const Eigen::Vector3d& p_W,
                const Eigen::Vector3d& f);
  template <typename Use>
  void across(std::size_t support, int from, const Eigen::Vector3d& p_from, int to,
              const Eigen::Vector3d& p_to, double weight, const Use& use);
  template <typename UsePair>
  void turn_loads(std::size_t support, const UsePair& use_pair);
  void put_moment(const Support& support, int point, const Eigen::Vector3d& m);
  std::span<const double> row(const Support& support);
  template <typename Use>
  void use_row(std::size_t support, double weight, const Use& use) {
    use(static_cast<int>(support), row(supports_[support]), weight);
  }

  // Calls use(i, p_A, p_B, length) for every distance that is measured and has a direction.
  template <typename Use>
  void for_each_measured_distance(const IkProblem& problem, const IkTargets& targets,
                                  const KinematicWorkspace& workspace, const Use& use);
  template <typename Use>
  void for_each_distance(const IkProblem& problem, const IkTargets& targets,
                         const KinematicWorkspace& workspace, const Use& use);
  template <typename Use>
  void for_each_loop(const IkProblem& problem, const KinematicWorkspace& workspace, const Use& use);

  int first_wire_ = 0, wire_count_ = 0;  // in supports_
  std::vector<Support> supports_;        // distances, wires, coincidences, alignments in turn
  std::vector<PathLink> path_links_;
  std::vector<Entry> entries_;
  std::vector<int> point_slots_;  // where a point's link stands in its support, −1: it is not moved
  std::vector<int> unknowns_;
  std::vector<int> driver_;
  std::vector<double> slope_;
  std::vector<Vector6d> twists_;
  std::vector<Vector6d> wrenches_;  // of the links of one support
  std::vector<double> row_;
  std::vector<int> order_;               // v
  std::vector<Eigen::Matrix3d> turned_;  // of the links of one support: Σ [f×][r×]
  std::vector<Eigen::Vector3d> force_;   // likewise: Σ f
  Eigen::Vector3d origin_ = Eigen::Vector3d::Zero();
};

template <typename Use>
void InternalRows::for_each(const IkProblem& problem, const IkTargets& targets,
                            const KinematicWorkspace& ws, const Use& use) {
  for_each_distance(problem, targets, ws, use);
  for (std::size_t i = 0; i < problem.wires.size(); ++i) {
    const WireResidual& r = problem.wires[i];
    if (!(wire_length(problem, r, ws) > r.natural_length)) continue;
    const WireRow wire = wire_row(problem, i, ws);
    use(wire.support, wire.row, r.weight);
  }
  for_each_loop(problem, ws, use);
}

template <typename Use>
void InternalRows::for_each_but_wires(const IkProblem& problem, const IkTargets& targets,
                                      const KinematicWorkspace& ws, const Use& use) {
  for_each_distance(problem, targets, ws, use);
  for_each_loop(problem, ws, use);
}

template <typename Use>
void InternalRows::for_each_measured_distance(const IkProblem& problem, const IkTargets& targets,
                                              const KinematicWorkspace& ws, const Use& use) {
  for (std::size_t i = 0; i < problem.distances.size(); ++i) {
    const DistanceResidual& r = problem.distances[i];
    const Eigen::Vector3d pa = ws.X_WB[static_cast<std::size_t>(r.link_a)] * r.p_AP;
    const Eigen::Vector3d pb = ws.X_WB[static_cast<std::size_t>(r.link_b)] * r.p_BQ;
    const double length = (pa - pb).norm();
    if (!std::isnan(targets.distances[i]) && length > 0.0) use(i, pa, pb, length);
  }
}

template <typename Use>
void InternalRows::for_each_distance(const IkProblem& problem, const IkTargets& targets,
                                     const KinematicWorkspace& ws, const Use& use) {
  for_each_measured_distance(
      problem, targets, ws,
      [&](std::size_t i, const Eigen::Vector3d& pa, const Eigen::Vector3d& pb, double length) {
        const Eigen::Vector3d u = (pa - pb) / length;
        begin(supports_[i]);
        put_force(supports_[i], 0, pa, u);
        put_force(supports_[i], 1, pb, -u);
        use_row(i, problem.distances[i].weight, use);
      });
}

template <typename Use>
void InternalRows::for_each_loop(const IkProblem& problem, const KinematicWorkspace& ws,
                                 const Use& use) {
  std::size_t s = static_cast<std::size_t>(first_wire_) + problem.wires.size();
  for (const CoincidenceResidual& r : problem.coincidences) {
    const Eigen::Vector3d pa = ws.X_WB[static_cast<std::size_t>(r.link_a)] * r.p_AP;
    const Eigen::Vector3d pb = ws.X_WB[static_cast<std::size_t>(r.link_b)] * r.p_BQ;
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

template <typename Use>
void InternalRows::for_each_across(const IkProblem& problem, std::size_t wire,
                                   const KinematicWorkspace& ws, double force, const Use& use) {
  const std::size_t s = static_cast<std::size_t>(first_wire_) + wire;
  int before = -1;
  Eigen::Vector3d p_before = Eigen::Vector3d::Zero();
  for_each_wire_point(problem, problem.wires[wire], ws,
                      [&](int point, const Eigen::Vector3d& p, const Eigen::Vector3d&) {
                        if (before >= 0) across(s, before, p_before, point, p, force, use);
                        before = point;
                        p_before = p;
                      });
}

template <typename Use>
void InternalRows::across(std::size_t s, int from, const Eigen::Vector3d& p_from, int to,
                          const Eigen::Vector3d& p_to, double weight, const Use& use) {
  const Eigen::Vector3d along = p_to - p_from;
  const double length = along.norm();
  if (length == 0.0) return;
  const Eigen::Vector3d n = along.unitOrthogonal();
  for (const Eigen::Vector3d& u : {n, Eigen::Vector3d(along.cross(n) / length)}) {
    begin(supports_[s]);
    put_force(supports_[s], from, p_from, -u);
    put_force(supports_[s], to, p_to, u);
    use_row(s, weight / length, use);
  }
}

template <typename UsePair>
void InternalRows::turn_loads(std::size_t s, const UsePair& use_pair) {
  const Support& support = supports_[s];
  const PathLink* const links = path_links_.data() + support.first_link;
  for (int i = 0; i < support.link_count; ++i) {
    const auto own = static_cast<std::size_t>(i);
    for (int k = 0; k < links[i].entry_count; ++k) {
      const Entry& at = entries_[static_cast<std::size_t>(links[i].first_entry + k)];
      const auto v = static_cast<std::size_t>(at.v);
      const Eigen::Vector3d moment = slope_[v] * (turned_[own] * twists_[v].template head<3>() -
                                                  force_[own].cross(twists_[v].template tail<3>()));
      const auto pair = [&](const Entry& earlier, double factor) {
        const auto u = static_cast<std::size_t>(earlier.v);
        const double h = slope_[u] * twists_[u].template head<3>().dot(moment);
        const int high = std::max(at.slot, earlier.slot), low = std::min(at.slot, earlier.slot);
        // One unknown may drive both: then both (u, v) and (v, u) fall on its
        // diagonal.
        const bool twice = earlier.v != at.v && high == low;
        use_pair(static_cast<int>(s), high * (high + 1) / 2 + low,
                 (twice ? 2.0 : 1.0) * factor * h);
      };
      for (int other = 0; other < links[i].entry_count; ++other) {
        const Entry& peer = entries_[static_cast<std::size_t>(links[i].first_entry + other)];
        if (other == k || order(peer.v) < order(at.v)) {
          pair(peer, 1.0);
        } else if (order(peer.v) == order(at.v)) {
          pair(peer, 0.5);
        }
      }
      for (int a = links[i].parent_slot; a >= 0; a = links[a].parent_slot) {
        for (int other = 0; other < links[a].entry_count; ++other) {
          pair(entries_[static_cast<std::size_t>(links[a].first_entry + other)], 1.0);
        }
      }
    }
    if (links[i].parent_slot >= 0) {
      turned_[static_cast<std::size_t>(links[i].parent_slot)] += turned_[own];
      force_[static_cast<std::size_t>(links[i].parent_slot)] += force_[own];
    }
  }
}

template <typename Use, typename UsePair>
void InternalRows::for_each_second(const IkProblem& problem, const IkTargets& targets,
                                   const KinematicWorkspace& ws, const Use& use,
                                   const UsePair& use_pair) {
  for_each_measured_distance(
      problem, targets, ws,
      [&](std::size_t i, const Eigen::Vector3d& pa, const Eigen::Vector3d& pb, double length) {
        const DistanceResidual& r = problem.distances[i];
        const double force = r.weight * (length - targets.distances[i]);
        across(i, 1, pb, 0, pa, force, use);
        begin_loads(supports_[i]);
        put_load(supports_[i], 0, pa, force / length * (pa - pb));
        put_load(supports_[i], 1, pb, force / length * (pb - pa));
        turn_loads(i, use_pair);
      });
}

}  // namespace sinew
