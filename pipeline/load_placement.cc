#include "pipeline/load_placement.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "data/statistics.h"
#include "model/kinematic_tree.h"
#include "model/limb_paths.h"
#include "model/segment_words.h"
#include "model/tree_pose.h"
#include "pipeline/verdict_evidence.h"
#include "pipeline/verdict_limits.h"
#include "pipeline/verdict_reasons.h"

namespace sinew {
namespace {

using Eigen::Vector3d;

constexpr double kLoaded = 0.1;   // of the weight; below it points are noise
constexpr double kNearer = 0.05;  // [m] feet side by side are farther apart
// A step on the wrong foot is a part of all.
constexpr double kMostNearer = 0.1;
// A foot is 0.1 m wide and its body's points lie along its middle; published trials stay below it.
// The whole weight 0.4 m beside the foot is a moment larger than any ankle's.
constexpr double kBeside = 0.15, kFarBeside = 0.4;  // [m]

struct BodyPoint {
  int body;
  Vector3d p_B;
};

// Points of a body and of those that it carries.
std::vector<BodyPoint> points_of(const MusculoskeletalModel& model, int body) {
  std::vector<bool> of(model.bodies.size(), false);
  of[static_cast<std::size_t>(body)] = true;
  std::vector<BodyPoint> points;
  for (std::size_t b = static_cast<std::size_t>(body); b < of.size(); ++b) {
    const Joint& joint = model.joints[b - 1];
    if (static_cast<int>(b) != body) of[b] = of[static_cast<std::size_t>(joint.parent)];
    if (!of[b]) continue;
    points.push_back({static_cast<int>(b), Vector3d::Zero()});
    points.push_back({static_cast<int>(b), model.bodies[b].p_BCm});
  }
  for (const Marker& marker : model.markers) {
    if (marker.body > 0 && of[static_cast<std::size_t>(marker.body)]) {
      points.push_back({marker.body, marker.p_BM});
    }
  }
  return points;
}

double distance_to(const KinematicWorkspace& ws, const std::vector<BodyPoint>& points,
                   const Vector3d& p) {
  double nearest = kNaN;
  for (const BodyPoint& point : points) {
    const Vector3d d = ws.X_WB[static_cast<std::size_t>(point.body)] * point.p_B - p;
    nearest = std::fmin(nearest, d.norm());
  }
  return nearest;
}

// Coordinates of the joints that the body carries, up to the foot below it; none if it is a foot,
// a hand, or of a name that tells nothing.
std::vector<std::string> skipped_by(const MusculoskeletalModel& model, int body) {
  const Segment segment = segment_of_body(model.bodies[static_cast<std::size_t>(body)].name);
  std::vector<bool> carried(model.bodies.size(), false);
  carried[static_cast<std::size_t>(body)] = true;
  std::vector<std::string> names;
  bool foot = false;
  for (std::size_t b = static_cast<std::size_t>(body) + 1; b < carried.size(); ++b) {
    const Joint& joint = model.joints[b - 1];
    carried[b] = carried[static_cast<std::size_t>(joint.parent)];
    if (!carried[b]) continue;
    foot = foot || segment_of_body(model.bodies[b].name).part == "foot";
    for (const int c : joint.coordinates) {
      names.push_back(model.coordinates[static_cast<std::size_t>(c)].name);
    }
  }
  const bool above = segment.known && segment.part != "foot" && foot;
  return above ? names : std::vector<std::string>();
}

}  // namespace

std::vector<LoadPlacement> load_placements(const MusculoskeletalModel& model,
                                           const Eigen::VectorXd& time, const RowMatrix& q,
                                           const ExternalLoads& loads) {
  const KinematicTree tree = compile_tree(model);
  KinematicWorkspace ws(tree);
  const double least = kLoaded * model.total_mass() * model.gravity.norm();
  struct Load {
    int index;
    LoadPlacement placement;
    std::vector<BodyPoint> own, others;
    std::vector<double> distances, to_other;
    std::array<std::vector<double>, 3> mirrored;  // along x, y and z; none along what is up
    int nearer = 0;
  };
  std::vector<Load> all;
  if (!stands_for_a_person(model)) return {};
  int vertical = 0;
  up_of(model).cwiseAbs().maxCoeff(&vertical);
  for (int i = 0; i < loads.size() && time.size() > 0; ++i) {
    const int body = loads.sample(i, time[0]).body;
    const int other = body > 0 ? partner_body(model, body) : -1;
    if (body <= 0 || !loads.has_point(i)) continue;
    Load load{i, {}, points_of(model, body), {}, {}, {}, {}, 0};
    load.placement.body = body;
    load.placement.other = other;
    if (other >= 0) load.others = points_of(model, other);
    all.push_back(std::move(load));
  }
  if (all.empty()) return {};
  for (Eigen::Index f = 0; f < time.size(); ++f) {
    pose_tree(tree, q.row(f), ws);
    for (Load& load : all) {
      const ExternalLoads::Sample sample = loads.sample(load.index, time[f]);
      const double force = sample.force.norm();
      if (!(force > 0.0)) continue;
      const Vector3d p = ws.X_WB[static_cast<std::size_t>(sample.point_frame)] * sample.point;
      const double distance = distance_to(ws, load.own, p);
      const double far = force * (distance - kBeside);
      if (far > load.placement.far_moment) {
        load.placement.far_moment = far;
        load.placement.far_time = time[f];
      }
      if (!(force > least)) continue;
      load.distances.push_back(distance);
      load.to_other.push_back(distance_to(ws, load.others, p));
      load.nearer += load.to_other.back() + kNearer < distance;
      for (int axis = 0; axis < 3; ++axis) {
        if (axis == vertical) continue;
        Vector3d mirror = p;
        mirror[axis] = -p[axis];
        load.mirrored[static_cast<std::size_t>(axis)].push_back(distance_to(ws, load.own, mirror));
      }
    }
  }
  std::vector<LoadPlacement> placements;
  for (Load& load : all) {
    load.placement.frames = static_cast<int>(load.distances.size());
    if (load.placement.frames > 0) {
      load.placement.nearer_other = static_cast<double>(load.nearer) / load.placement.frames;
      load.placement.distance = median(std::move(load.distances));
      load.placement.to_other = median(std::move(load.to_other));
      for (int axis = 0; axis < 3; ++axis) {
        if (axis == vertical) continue;
        const double d = median(std::move(load.mirrored[static_cast<std::size_t>(axis)]));
        if (d >= load.placement.mirrored) continue;
        load.placement.mirrored = d;
        load.placement.mirror_axis = axis;
      }
    }
    placements.push_back(load.placement);
  }
  return placements;
}

std::vector<VerdictReason> load_placement_reasons(const MusculoskeletalModel& model,
                                                  const std::vector<LoadPlacement>& placements,
                                                  const std::vector<std::string>& supporting) {
  std::vector<VerdictReason> reasons;
  const auto name = [&](int body) { return model.bodies[static_cast<std::size_t>(body)].name; };
  const ModelEvidence body = model_evidence(model);
  const double hicks = limits::kResidualMoment * body.mass * model.gravity.norm() * body.height;
  for (const LoadPlacement& p : placements) {
    if (p.frames == 0) continue;
    if (std::vector<std::string> skipped = skipped_by(model, p.body); !skipped.empty()) {
      reasons.push_back(own_reason(
          "loads-not-on-foot",
          fmt::format("a force of the ground acts on {}, which is no foot", name(p.body)),
          "apply it to the foot (calcn), or the joints below carry nothing"));
      reasons.back().torques = std::move(skipped);
    }
    const bool mirrored =
        p.mirrored < kBeside && p.mirrored + kNearer < p.distance && !(p.to_other < p.mirrored);
    if (mirrored) {
      auto* r = judge_figure(reasons, {p.distance, p.mirrored, p.mirrored}, 1e3, "mm",
                             "loads-mirrored", limits::kOwn);
      const char axis = static_cast<char>('x' + p.mirror_axis);
      r->text = fmt::format("the force on {} acts away from it, but at it if {} is turned",
                            name(p.body), axis);
      r->remedy = fmt::format("turn the sign of the {} of its centres of pressure", axis);
      r->torques = supporting;
      continue;
    }
    if (auto* r = judge_figure(reasons, {p.nearer_other, kMostNearer, kMostNearer}, 100.0,
                               "% of its frames", "loads-of-other-foot", limits::kOwn)) {
      r->text = fmt::format(
          "the force on {} acts at {} in a part of its frames; in the middle of all it is {:.2f} m "
          "from the one and {:.2f} m from the other",
          name(p.body), name(p.other), p.distance, p.to_other);
      r->remedy =
          "--assign says which foot stands where; of loads of your own exchange the bodies; or are "
          "left and right markers exchanged?";
      r->torques = supporting;
      continue;
    }
    if (auto* r = judge_figure(reasons, {p.distance, kBeside, kFarBeside}, 1e3, "mm",
                               "loads-beside-foot", limits::kOwn)) {
      r->text = fmt::format("the force on {} acts away from it", name(p.body));
      r->remedy =
          "look at axes, origin and unit of the centres of pressure: `sinew check LOADS.mot "
          "RECORDING`";
      if (r->weight == VerdictReason::Weight::kUnusable) r->torques = supporting;
      continue;
    }
    if (auto* r = judge_figure(reasons, {p.far_moment, hicks, 5.0 * hicks}, 1.0, "N m",
                               "loads-far-point", limits::kHicks)) {
      r->text = fmt::format("the force on {} acts far from it for a while, most at {:.2f} s",
                            name(p.body), p.far_time);
      r->remedy =
          "centres of pressure of small forces are noise: set forces below 20 N, and their points "
          "and torques, to 0";
      if (r->weight == VerdictReason::Weight::kUnusable) r->torques = supporting;
    }
  }
  return reasons;
}

}  // namespace sinew
