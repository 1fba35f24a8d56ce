#include "model/model_check.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <stdexcept>

#include "model/kinematic_tree.h"
#include "model/model_summary.h"
#include "model/path_length.h"

namespace sinew {
namespace {

using Eigen::Vector3d;
using Severity = ModelFinding::Severity;

// A place that is known to be on a bone, and the path it belongs to (−1: none; markers: −2).
struct Landmark {
  Vector3d p_B;
  const void* owner;
};

/// The model in its default pose, and the findings so far.
class ModelCheck {
 public:
  ModelCheck(const MusculoskeletalModel& model, const ModelCheckOptions& options)
      : model_(model),
        options_(options),
        tree_(compile_tree(model)),
        workspace_(tree_),
        landmarks_(model.bodies.size()) {
    update_poses(tree_, workspace_);
    collect_landmarks();
  }

  std::vector<ModelFinding> run() {
    for (const Warning& warning : model_.warnings) {
      findings_.push_back({Severity::kWarning, "reading", model_.name, warning.text, warning.at});
    }
    for (std::size_t b = 1; b < model_.bodies.size(); ++b) {
      if (model_.bodies[b].virtual_link) {
        check_virtual_link(static_cast<int>(b));
      } else {
        check_mass(static_cast<int>(b));
      }
    }
    for (const Coordinate& c : model_.coordinates) check_coordinate(c);
    for (const PathElement& path : model_.paths) check_path(path);
    for (const Marker& marker : model_.markers) check_marker(marker);
    check_that_markers_move();
    const std::vector<ModelFinding> asymmetries = check_symmetry(model_, options_);
    findings_.insert(findings_.end(), asymmetries.begin(), asymmetries.end());
    std::stable_sort(
        findings_.begin(), findings_.end(),
        [](const ModelFinding& a, const ModelFinding& b) { return a.severity < b.severity; });
    return findings_;
  }

 private:
  void add(Severity severity, const char* kind, const std::string& element,
           const SourceLocation& source, std::string text) {
    findings_.push_back({severity, kind, element, std::move(text), source});
  }

  const std::string& body_name(int b) const {
    return model_.bodies[static_cast<std::size_t>(b)].name;
  }

  Vector3d in_world(const PathPoint& point) const {
    return workspace_.X_WB[static_cast<std::size_t>(point.body)] * point.p_BP;
  }

  // Joints, mass centres, markers and path points of every bone.
  void collect_landmarks() {
    const auto put = [&](int body, const Vector3d& p_B, const void* owner) {
      landmarks_[static_cast<std::size_t>(body)].push_back({p_B, owner});
    };
    for (const Joint& joint : model_.joints) {
      put(joint.child, joint.X_BM.p, &joint);
      // Where it is in this pose: a joint may shift.
      put(joint.parent,
          workspace_.X_WB[static_cast<std::size_t>(joint.parent)].inverse() *
              (workspace_.X_WB[static_cast<std::size_t>(joint.child)] * joint.X_BM.p),
          &joint);
    }
    for (std::size_t b = 1; b < model_.bodies.size(); ++b) {
      put(static_cast<int>(b), model_.bodies[b].p_BCm, &model_.bodies[b]);
    }
    for (const Marker& marker : model_.markers) put(marker.body, marker.p_BM, &marker);
    for (const PathElement& path : model_.paths) {
      for (const PathPoint& point : path.points) {
        if (point.kind != PathPoint::Kind::kMoving) put(point.body, point.p_BP, &path);
      }
    }
  }

  // To the nearest landmark that does not belong to `owner` itself.
  double distance_from_bone(int body, const Vector3d& p_B, const void* owner) const {
    double nearest = std::numeric_limits<double>::infinity();
    for (const Landmark& landmark : landmarks_[static_cast<std::size_t>(body)]) {
      if (landmark.owner != owner) nearest = std::min(nearest, (landmark.p_B - p_B).norm());
    }
    return nearest;
  }

  bool is_far(int body, double distance) const {
    return body != 0 && std::isfinite(distance) && distance > options_.plausible_distance;
  }

  void check_mass(int b) {
    const Body& body = model_.bodies[static_cast<std::size_t>(b)];
    if (body.mass == 0.0) {
      const bool carries = std::any_of(model_.joints.begin(), model_.joints.end(),
                                       [b](const Joint& joint) { return joint.parent == b; });
      add(carries ? Severity::kNote : Severity::kWarning, "mass", body.name, body.source,
          carries ? "has no mass; it carries other bodies"
                  : "has no mass, carries no body and is no virtual link");
      return;
    }
    const Eigen::Vector3d moments =
        Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(body.I_BCm, Eigen::EigenvaluesOnly)
            .eigenvalues();
    constexpr double kRounding = 1e-9;
    if (moments[2] <= 0.0) {
      add(Severity::kWarning, "mass", body.name, body.source,
          fmt::format("has {:.6g} kg but no inertia", body.mass));
    } else if (moments[0] < -kRounding * moments[2] ||
               moments[0] + moments[1] < (1.0 - kRounding) * moments[2]) {
      add(Severity::kError, "mass", body.name, body.source,
          fmt::format("no body has its principal moments of inertia {:.6g} {:.6g} {:.6g} kg m²: "
                      "the largest exceeds the sum of the others",
                      moments[0], moments[1], moments[2]));
    }
  }

  void check_coordinate(const Coordinate& c) {
    if (c.default_value >= c.range_min && c.default_value <= c.range_max) return;
    const bool bound = c.clamped && !c.locked;
    add(bound ? Severity::kError : Severity::kWarning, "coordinate", c.name, c.source,
        fmt::format("its default {:.6g} is outside its range {:.6g} to {:.6g}{}", c.default_value,
                    c.range_min, c.range_max, bound ? ", which it is clamped to" : ""));
  }

  void check_path(const PathElement& path) {
    const double length = path_length(path, tree_, workspace_);
    if (length == 0.0) {
      add(Severity::kError, "path", path.name, path.source, "all its points are one");
    } else {
      check_points(path);
    }
    const std::vector<bool> crossed = joints_crossed(model_, path);
    bool moves = false;
    for (std::size_t j = 0; j < crossed.size(); ++j) {
      moves = moves || (crossed[j] && !model_.joints[j].coordinates.empty());
    }
    if (!moves) {
      add(Severity::kWarning, "muscle", path.name, path.source,
          "crosses no joint that moves: its length never changes");
    }
    constexpr double kRounding = 1e-9;
    if (path.natural_length < (1.0 - kRounding) * length) {
      add(Severity::kWarning, "natural length", path.name, path.source,
          fmt::format("its natural length {:.1f} mm is shorter than the path in the default pose, "
                      "{:.1f} mm",
                      1e3 * path.natural_length, 1e3 * length));
    }
  }

  void check_points(const PathElement& path) {
    constexpr double kSame = 1e-6;  // [m]
    for (std::size_t i = 0; i < path.points.size(); ++i) {
      const PathPoint& point = path.points[i];
      if (point.kind == PathPoint::Kind::kMoving) continue;
      if (i > 0 && path.points[i - 1].kind == PathPoint::Kind::kFixed &&
          point.kind == PathPoint::Kind::kFixed &&
          (in_world(point) - in_world(path.points[i - 1])).norm() < kSame) {
        add(Severity::kWarning, "path", path.name, path.source,
            fmt::format("its points {} and {} are at one place", i, i + 1));
      }
      if (model_.bodies[static_cast<std::size_t>(point.body)].virtual_link) continue;
      const double distance = distance_from_bone(point.body, point.p_BP, &path);
      if (is_far(point.body, distance)) {
        add(Severity::kWarning, "path", path.name, path.source,
            fmt::format("its point {} is {:.0f} mm from anything else on '{}'", i + 1,
                        1e3 * distance, body_name(point.body)));
      }
    }
  }

  void check_marker(const Marker& marker) {
    const double distance = distance_from_bone(marker.body, marker.p_BM, &marker);
    if (!is_far(marker.body, distance)) return;
    add(Severity::kWarning, "marker", marker.name, marker.source,
        fmt::format("is {:.0f} mm from anything else on '{}'", 1e3 * distance,
                    body_name(marker.body)));
  }

  bool moves(int body) const {
    for (int b = body; b > 0; b = tree_.links[static_cast<std::size_t>(b)].parent) {
      if (tree_.links[static_cast<std::size_t>(b)].v_count > 0) return true;
    }
    return false;
  }

  void check_that_markers_move() {
    if (model_.markers.empty()) return;
    const bool any = std::any_of(model_.markers.begin(), model_.markers.end(),
                                 [&](const Marker& marker) { return moves(marker.body); });
    if (any) return;
    add(Severity::kError, "marker", model_.markers.front().name, model_.markers.front().source,
        fmt::format(
            "no marker is on a body that moves: all {} are on {}, so that no recording says "
            "anything about a coordinate",
            model_.markers.size(), body_name(model_.markers.front().body)));
  }

  // Unit vectors from the link along the paths on it, and the bodies that these lead to or over.
  void collect_pulls(int link, std::vector<Vector3d>& directions, std::set<int>& bodies) const {
    for (const PathElement& path : model_.paths) {
      const std::size_t n = path.points.size();
      for (std::size_t i = 0; i < n; ++i) {
        if (path.points[i].body != link) continue;
        for (const std::size_t k : {i - 1, i + 1}) {  // i − 1 wraps at the first point
          if (k >= n || path.points[k].body == link) continue;
          const Vector3d d = in_world(path.points[k]) - in_world(path.points[i]);
          if (d.norm() > 0.0) directions.push_back(d.normalized());
          for (const PathPoint& point : path.points) {
            if (point.body != link) bodies.insert(point.body);
          }
        }
      }
    }
  }

  void check_virtual_link(int b) {
    const Body& body = model_.bodies[static_cast<std::size_t>(b)];
    std::vector<Vector3d> directions;
    std::set<int> bodies;
    collect_pulls(b, directions, bodies);
    const auto report = [&](Severity severity, std::string text) {
      add(severity, "virtual link", body.name, body.source, std::move(text));
    };
    if (bodies.empty()) {
      report(Severity::kError, "no path ends on it: nothing holds it");
      return;
    }
    double widest = 0.0;
    for (const Vector3d& d : directions) {
      for (const Vector3d& e : directions) {
        widest = std::max(widest, std::atan2(d.cross(e).norm(), d.dot(e)));
      }
    }
    if (widest < options_.least_spread) {
      report(Severity::kError,
             fmt::format("{} pull on it in one direction only (within {:.1f} degrees): nothing "
                         "holds it against them",
                         directions.size() == 1 ? "one path" : "all paths",
                         widest * 180.0 / 3.141592653589793));
    } else if (bodies.size() == 1) {
      report(Severity::kWarning, fmt::format("all its paths lead to '{}': it joins nothing",
                                             body_name(*bodies.begin())));
    } else if (directions.size() < 3) {
      report(Severity::kNote, "only two ends of paths are on it: it neither forks nor joins");
    }
  }

  const MusculoskeletalModel& model_;
  const ModelCheckOptions& options_;
  KinematicTree tree_;
  KinematicWorkspace workspace_;
  std::vector<std::vector<Landmark>> landmarks_;  // by body
  std::vector<ModelFinding> findings_;
};

}  // namespace

const char* to_string(ModelFinding::Severity severity) {
  static constexpr const char* kNames[] = {"error", "warning", "note"};
  return kNames[static_cast<int>(severity)];
}

void ModelCheckOptions::validate() const {
  const auto require = [](const char* name, double value) {
    if (std::isfinite(value) && value > 0.0) return;
    throw std::invalid_argument(fmt::format("{} is {}; expected a number above 0", name, value));
  };
  require("mirror_tolerance", mirror_tolerance);
  require("marker_mirror_tolerance", marker_mirror_tolerance);
  require("relative_tolerance", relative_tolerance);
  require("plausible_distance", plausible_distance);
  require("least_spread", least_spread);
}

std::vector<ModelFinding> check_model(const MusculoskeletalModel& model,
                                      const ModelCheckOptions& options) {
  options.validate();
  return ModelCheck(model, options).run();
}

}  // namespace sinew
