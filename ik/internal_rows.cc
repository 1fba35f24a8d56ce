#include "ik/internal_rows.h"

#include <algorithm>

#include "ik/stiffness.h"

namespace sinew {
namespace {

// The lowest link that carries all of `links`.
int common_ancestor(const KinematicTree& tree, std::span<const int> links) {
  int common = links[0];
  for (const int each : links) {
    int link = each;
    while (link != common) {  // a parent's index is smaller than its child's
      int& higher = link > common ? link : common;
      higher = tree.links[static_cast<std::size_t>(higher)].parent;
    }
  }
  return common;
}

// Shifts come before turns, and these in their sequence. The same for columns that do not follow
// one another: of a ball, of an ellipsoid, and of coordinates that drive several steps.
std::vector<int> orders_within_joints(const KinematicTree& tree) {
  std::vector<int> order(static_cast<std::size_t>(tree.v_count()), 0);
  for (const KinematicTree::Link& link : tree.links) {
    if (link.kind == KinematicTree::Kind::kFree) {
      for (int i = 0; i < 3; ++i) order[static_cast<std::size_t>(link.first_v + i)] = 1;
    }
    if (link.kind != KinematicTree::Kind::kSteps) continue;
    bool once = true;
    std::vector<int> found(static_cast<std::size_t>(link.v_count), -1);
    for (int i = 0; i < link.rotation_count + link.translation_count; ++i) {
      const int v = tree.steps[static_cast<std::size_t>(link.first_step + i)].v;
      if (v < 0) continue;
      int& at = found[static_cast<std::size_t>(v - link.first_v)];
      once = once && at < 0;
      at = i < link.rotation_count ? i + 1 : 0;
    }
    if (once) {
      std::copy(found.begin(), found.end(), order.begin() + link.first_v);
    }
  }
  return order;
}

}  // namespace

InternalRows::InternalRows(const KinematicTree& tree, const IkProblem& problem)
    : driver_(static_cast<std::size_t>(tree.v_count()), -1),
      slope_(static_cast<std::size_t>(tree.v_count()), 1.0),
      twists_(static_cast<std::size_t>(tree.v_count()), Vector6d::Zero()),
      order_(orders_within_joints(tree)) {
  for (int v = 0; v < tree.v_count(); ++v) {
    int source = v;
    while (tree.coupling_of_v[static_cast<std::size_t>(source)] >= 0) {
      source = tree.couplings[static_cast<std::size_t>(
                                  tree.coupling_of_v[static_cast<std::size_t>(source)])]
                   .independent_v;
    }
    driver_[static_cast<std::size_t>(v)] = tree.unknown_of_v[static_cast<std::size_t>(source)];
  }
  for (const DistanceResidual& r : problem.distances) {
    const int links[] = {r.link_a, r.link_b};
    add_support(tree, links, false);
  }
  first_wire_ = static_cast<int>(supports_.size());
  wire_count_ = static_cast<int>(problem.wires.size());
  std::vector<int> links;
  for (const WireResidual& r : problem.wires) {
    links.clear();
    for (int i = 0; i < r.point_count; ++i) {
      links.push_back(problem.wire_points[static_cast<std::size_t>(r.first_point + i)].link);
    }
    add_support(tree, links, false);
  }
  // Where a cut loop gapes, its forces have a moment that reaches the root.
  for (const CoincidenceResidual& r : problem.coincidences) {
    const int pair[] = {r.link_a, r.link_b};
    add_support(tree, pair, true);
  }
  for (const AlignmentResidual& r : problem.alignments) {
    const int pair[] = {r.link_a, r.link_b};
    add_support(tree, pair, false);
  }
  std::size_t most_links = 0, most_unknowns = 0;
  for (const Support& s : supports_) {
    most_links = std::max(most_links, static_cast<std::size_t>(s.link_count));
    most_unknowns = std::max(most_unknowns, static_cast<std::size_t>(s.unknown_count));
  }
  wrenches_.resize(most_links, Vector6d::Zero());
  turned_.resize(most_links, Eigen::Matrix3d::Zero());
  force_.resize(most_links, Eigen::Vector3d::Zero());
  row_.resize(most_unknowns, 0.0);
}

void InternalRows::add_support(const KinematicTree& tree, std::span<const int> links,
                               bool to_root) {
  const int end = to_root ? 0 : common_ancestor(tree, links);
  std::vector<int> path;
  for (const int each : links) {
    for (int b = each; b > end; b = tree.links[static_cast<std::size_t>(b)].parent) {
      path.push_back(b);
    }
  }
  std::sort(path.begin(), path.end(), std::greater<>());
  path.erase(std::unique(path.begin(), path.end()), path.end());
  const auto slot_of = [&](int link) {
    const auto found = std::lower_bound(path.begin(), path.end(), link, std::greater<>());
    return found != path.end() && *found == link ? static_cast<int>(found - path.begin()) : -1;
  };

  std::vector<int> unknowns;
  const auto for_each_v = [&](int b, const auto& use) {
    const KinematicTree::Link& link = tree.links[static_cast<std::size_t>(b)];
    for (int v = link.first_v; v < link.first_v + link.v_count; ++v) {
      if (driver(v) >= 0) use(v);
    }
  };
  for (const int b : path) {
    for_each_v(b, [&](int v) { unknowns.push_back(driver(v)); });
  }
  std::sort(unknowns.begin(), unknowns.end());
  unknowns.erase(std::unique(unknowns.begin(), unknowns.end()), unknowns.end());

  Support support;
  support.first_link = static_cast<int>(path_links_.size());
  support.link_count = static_cast<int>(path.size());
  support.first_point = static_cast<int>(point_slots_.size());
  support.first_unknown = static_cast<int>(unknowns_.size());
  support.unknown_count = static_cast<int>(unknowns.size());
  for (const int b : path) {
    PathLink link{slot_of(tree.links[static_cast<std::size_t>(b)].parent),
                  static_cast<int>(entries_.size()), 0};
    for_each_v(b, [&](int v) {
      const auto place = std::lower_bound(unknowns.begin(), unknowns.end(), driver(v));
      entries_.push_back({v, static_cast<int>(place - unknowns.begin())});
      ++link.entry_count;
    });
    path_links_.push_back(link);
  }
  for (const int each : links) point_slots_.push_back(slot_of(each));
  unknowns_.insert(unknowns_.end(), unknowns.begin(), unknowns.end());
  supports_.push_back(support);
}

void InternalRows::update(const KinematicTree& tree, const KinematicWorkspace& ws) {
  // Near the body: sums of moments about a far origin would lose digits.
  origin_ = tree.link_count() > 1 ? ws.X_WB[1].p : Eigen::Vector3d::Zero();
  for (std::size_t b = 1; b < tree.links.size(); ++b) {
    const KinematicTree::Link& link = tree.links[b];
    const Eigen::Vector3d r = origin_ - ws.X_WB[b].p;
    for (int i = link.first_v; i < link.first_v + link.v_count; ++i) {
      const auto v = static_cast<std::size_t>(i);
      twists_[v].head<3>() = ws.S[v].head<3>();
      twists_[v].tail<3>() = ws.S[v].tail<3>() + ws.S[v].head<3>().cross(r);
    }
  }
  for (std::size_t i = 0; i < tree.couplings.size(); ++i) {  // sources before their dependents
    const KinematicTree::Coupling& c = tree.couplings[i];
    slope_[static_cast<std::size_t>(c.dependent_v)] =
        ws.coupling_slope[i] * slope_[static_cast<std::size_t>(c.independent_v)];
  }
}

InternalRows::WireRow InternalRows::wire_row(const IkProblem& problem, std::size_t wire,
                                             const KinematicWorkspace& ws) {
  const auto s = static_cast<std::size_t>(support_of_wire(wire));
  begin(supports_[s]);
  for_each_wire_point(problem, problem.wires[wire], ws,
                      [&](int point, const Eigen::Vector3d& p, const Eigen::Vector3d& u) {
                        put_force(supports_[s], point, p, u);
                      });
  return {static_cast<int>(s), row(supports_[s])};
}

void InternalRows::begin(const Support& support) {
  std::fill_n(wrenches_.begin(), support.link_count, Vector6d::Zero());
}

void InternalRows::put_force(const Support& support, int point, const Eigen::Vector3d& p_W,
                             const Eigen::Vector3d& u) {
  const int slot = point_slots_[static_cast<std::size_t>(support.first_point + point)];
  if (slot < 0) return;
  Vector6d& wrench = wrenches_[static_cast<std::size_t>(slot)];
  wrench.head<3>() += (p_W - origin_).cross(u);
  wrench.tail<3>() += u;
}

void InternalRows::begin_loads(const Support& support) {
  std::fill_n(turned_.begin(), support.link_count, Eigen::Matrix3d::Zero());
  std::fill_n(force_.begin(), support.link_count, Eigen::Vector3d::Zero());
}

void InternalRows::put_load(const Support& support, int point, const Eigen::Vector3d& p_W,
                            const Eigen::Vector3d& f) {
  const int slot = point_slots_[static_cast<std::size_t>(support.first_point + point)];
  if (slot < 0) return;
  turned_[static_cast<std::size_t>(slot)] += turned_load(p_W - origin_, f);
  force_[static_cast<std::size_t>(slot)] += f;
}

void InternalRows::put_moment(const Support& support, int point, const Eigen::Vector3d& m) {
  const int slot = point_slots_[static_cast<std::size_t>(support.first_point + point)];
  if (slot >= 0) wrenches_[static_cast<std::size_t>(slot)].head<3>() += m;
}

std::span<const double> InternalRows::row(const Support& support) {
  std::fill_n(row_.begin(), support.unknown_count, 0.0);
  const PathLink* const links = path_links_.data() + support.first_link;
  for (int i = 0; i < support.link_count; ++i) {
    const Vector6d& wrench = wrenches_[static_cast<std::size_t>(i)];
    const Entry* const entries = entries_.data() + links[i].first_entry;
    for (int k = 0; k < links[i].entry_count; ++k) {
      const auto v = static_cast<std::size_t>(entries[k].v);
      row_[static_cast<std::size_t>(entries[k].slot)] += slope_[v] * twists_[v].dot(wrench);
    }
    if (links[i].parent_slot >= 0) {
      wrenches_[static_cast<std::size_t>(links[i].parent_slot)] += wrench;
    }
  }
  return {row_.data(), static_cast<std::size_t>(support.unknown_count)};
}

}  // namespace sinew
