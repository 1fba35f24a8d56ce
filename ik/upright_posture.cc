#include "ik/upright_posture.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <span>
#include <string_view>

#include "data/text.h"
#include "ik/marker_coverage.h"
#include "ik/minimizer.h"

namespace sinew {
namespace {

using Eigen::Vector3d;

// So that 99 % of a turn is made up for, and a joint's own bound still holds.
constexpr double kUprightOverPosture = 100.0;
// Tighter than a frame's own: what is left would shake the trunk from frame to frame.
constexpr double kTolerance = 1e-12;
// Half a stride: turns of the pelvis within it cancel. Strides of walking take 1.0 to 1.2 s (Perry
// & Burnfield 2010, ch. 1).
constexpr double kHalfStride = 0.55;  // [s]

bool is_girdle(const std::string& body) {
  const std::string lower = text::lower(body);
  return lower.find("scapula") != lower.npos || lower.find("clavicle") != lower.npos;
}

// Bodies of a segment that carry no other of it: the top of a spine. Girdles hang beside it.
std::vector<int> tops(const MusculoskeletalModel& model, const Segment& segment) {
  std::vector<int> members, result;
  for (std::size_t b = 1; b < model.bodies.size(); ++b) {
    const Body& body = model.bodies[b];
    if (body.virtual_link || is_girdle(body.name)) continue;
    if (segment_of_body(body.name) == segment) members.push_back(static_cast<int>(b));
  }
  for (const int b : members) {
    const bool carries = std::any_of(members.begin(), members.end(), [&](int other) {
      return model.joints[static_cast<std::size_t>(other) - 1].parent == b;
    });
    if (!carries) result.push_back(b);
  }
  return result;
}

int parent_of(const MusculoskeletalModel& model, int body) {
  return model.joints[static_cast<std::size_t>(body) - 1].parent;
}

class UprightSolver {
 public:
  UprightSolver(const MusculoskeletalModel& model, const KinematicTree& tree,
                const MarkerFile& recording, const IkTaskSet& tasks)
      : model_(model),
        tree_(tree),
        markers_(recording.markers),
        tracking_(bind(model, tree, recording, tasks)),
        up_(-model.gravity.normalized()) {}

  UprightPosture solve(double posture_weight, const TrackingOptions& options) {
    find_tops();
    if (posture_.empty()) return {};
    solved_ = track(model_, tree_, tracking_, markers_, options);
    if (solved_.stopped) return {};
    find_headings();
    hold(posture_weight);
    solve_frames(options);
    return std::move(posture_);
  }

 private:
  static TrackingProblem bind(const MusculoskeletalModel& model, const KinematicTree& tree,
                              const MarkerFile& recording, const IkTaskSet& tasks) {
    BindingOptions options;
    options.wires.use = WireOptions::Use::kNone;
    options.name_unmatched = false;
    return bind_recording(model, tree, recording, &tasks, nullptr, options);
  }

  // Tops without markers, the open coordinates below them, and the body that carries it all.
  void find_tops() {
    const MarkerCoverage coverage = marker_coverage(model_, tree_, tracking_, markers_, 0, nullptr);
    std::vector<bool> open(model_.coordinates.size(), false);
    for (const int c : coverage.undetermined) open[static_cast<std::size_t>(c)] = true;
    std::vector<bool> taken(model_.coordinates.size(), false);
    for (const Segment& segment : coverage.bare_segments) {
      if (segment.part != "trunk" && segment.part != "head") continue;
      bool any = false;
      for (const int top : tops(model_, segment)) any = take(top, open, taken) || any;
      if (any) posture_.segments.push_back(segment);
    }
    for (std::size_t c = 0; c < taken.size(); ++c) {
      if (taken[c]) posture_.coordinates.push_back(static_cast<int>(c));
    }
  }

  // Whether open turns lead to it, and not to what carries the whole model.
  bool take(int top, const std::vector<bool>& open, std::vector<bool>& taken) {
    std::vector<int> way;
    int carrier = top;
    for (; carrier > 0 && parent_of(model_, carrier) > 0; carrier = parent_of(model_, carrier)) {
      if (has_marker(carrier)) break;
      const Joint& joint = model_.joints[static_cast<std::size_t>(carrier) - 1];
      for (const int c : joint.coordinates) {
        const bool turns = model_.coordinates[static_cast<std::size_t>(c)].motion ==
                           Coordinate::Motion::kRotational;
        if (turns && open[static_cast<std::size_t>(c)]) way.push_back(c);
      }
    }
    if (way.empty() || !has_marker(carrier)) return false;
    tops_.push_back(top);
    carriers_.push_back(carrier);
    for (const int c : way) taken[static_cast<std::size_t>(c)] = true;
    return true;
  }

  bool has_marker(int body) const {
    return std::any_of(tracking_.markers.begin(), tracking_.markers.end(),
                       [&](const TrackedMarker& m) {
                         return model_.markers[static_cast<std::size_t>(m.model)].body == body;
                       });
  }

  void set_pose(int frame, KinematicWorkspace& ws) const {
    for (std::size_t c = 0; c < tree_.q_of_coordinate.size(); ++c) {
      ws.q[static_cast<std::size_t>(tree_.q_of_coordinate[c])] =
          solved_.coordinates(frame, static_cast<Eigen::Index>(c));
    }
    update_poses(tree_, ws);
  }

  // The model in its default pose, but with its root as the file's axes have it.
  KinematicWorkspace default_pose() const {
    KinematicWorkspace ws(tree_);
    ws.q = tree_.default_q;
    for (const Joint& joint : model_.joints) {
      if (joint.parent != 0) continue;
      for (const int c : joint.coordinates) {
        if (model_.coordinates[static_cast<std::size_t>(c)].motion ==
            Coordinate::Motion::kRotational) {
          ws.q[static_cast<std::size_t>(tree_.q_of_coordinate[static_cast<std::size_t>(c)])] = 0.0;
        }
      }
    }
    update_poses(tree_, ws);
    return ws;
  }

  // R^d of every top in every frame.
  void find_headings() {
    const KinematicWorkspace stands = default_pose();
    KinematicWorkspace ws(tree_);
    const int frames = markers_.frame_count();
    R_.resize(tops_.size());
    for (std::size_t i = 0; i < tops_.size(); ++i) {
      const auto carrier = static_cast<std::size_t>(carriers_[i]);
      Eigen::Matrix3Xd facing(3, frames);
      Vector3d forward = Vector3d::UnitX() - up_.x() * up_;
      for (int f = 0; f < frames; ++f) {
        set_pose(f, ws);
        const Vector3d x = ws.X_WB[carrier].R * (stands.X_WB[carrier].R.transpose() * forward);
        facing.col(f) = (x - up_.dot(x) * up_).normalized();
      }
      for (int f = 0; f < frames; ++f) {
        const Vector3d mean = mean_around(facing, f);
        const double yaw = std::atan2(up_.dot(forward.cross(mean)), forward.dot(mean));
        R_[i].push_back(Eigen::AngleAxisd(yaw, up_).toRotationMatrix() *
                        stands.X_WB[static_cast<std::size_t>(tops_[i])].R);
      }
    }
  }

  // Over half a stride to either side, shorter at the record's ends.
  Vector3d mean_around(const Eigen::Matrix3Xd& facing, int frame) const {
    const int last = static_cast<int>(facing.cols()) - 1;
    const int half =
        std::min({static_cast<int>(std::lround(kHalfStride * markers_.rate)), frame, last - frame});
    return facing.middleCols(frame - half, 2 * half + 1).rowwise().sum();
  }

  bool is_open(int coordinate) const {
    return std::find(posture_.coordinates.begin(), posture_.coordinates.end(), coordinate) !=
           posture_.coordinates.end();
  }

  // The second problem: tops upright, open coordinates near their defaults. All others are locked
  // where the markers have them: these resist a turn of the pelvis no more than a spine does.
  void hold(double posture_weight) {
    MusculoskeletalModel held = model_;
    for (std::size_t c = 0; c < model_.coordinates.size(); ++c) {
      const int v = tree_.v_of_coordinate[c];
      if (tree_.unknown_of_v[static_cast<std::size_t>(v)] < 0) continue;
      held.coordinates[c].locked = !is_open(static_cast<int>(c));
    }
    held_ = compile_tree(held);
    for (const int top : tops_) {
      problem_.orientations.push_back(
          {top, Eigen::Matrix3d::Identity(),
           kUprightOverPosture * posture_weight * Eigen::Matrix3d::Identity()});
    }
    for (std::size_t i = 0; i < posture_.coordinates.size(); ++i) {
      const auto c = static_cast<std::size_t>(posture_.coordinates[i]);
      problem_.coordinates.push_back(
          {held_.q_of_coordinate[c], held_.v_of_coordinate[c], posture_weight});
    }
  }

  void solve_frames(const TrackingOptions& options) {
    const int frames = markers_.frame_count();
    posture_.values.resize(frames, static_cast<Eigen::Index>(posture_.coordinates.size()));
    MinimizerOptions exact = options.minimizer;
    exact.gradient_tolerance = kTolerance;
    Minimizer minimizer(held_, problem_, exact);
    IkTargets targets(problem_);
    for (std::size_t i = 0; i < posture_.coordinates.size(); ++i) {
      targets.coordinates[i] = tree_.default_q[q_of(i)];
    }
    KinematicWorkspace ws(tree_);
    std::vector<double> before;  // open coordinates of the frame before
    for (int f = 0; f < frames; ++f) {
      set_pose(f, ws);
      for (std::size_t i = 0; i < before.size(); ++i) ws.q[q_of(i)] = before[i];
      for (std::size_t i = 0; i < tops_.size(); ++i) {
        targets.orientations[i] = R_[i][static_cast<std::size_t>(f)];
      }
      minimizer.minimize(targets, ws.q);
      before.resize(posture_.coordinates.size());
      for (std::size_t i = 0; i < before.size(); ++i) {
        before[i] = ws.q[q_of(i)];
        posture_.values(f, static_cast<Eigen::Index>(i)) = before[i];
      }
    }
  }

  std::size_t q_of(std::size_t i) const {
    const int c = posture_.coordinates[i];
    return static_cast<std::size_t>(tree_.q_of_coordinate[static_cast<std::size_t>(c)]);
  }

  const MusculoskeletalModel& model_;
  const KinematicTree& tree_;
  const MarkerTrajectories& markers_;
  TrackingProblem tracking_;
  Vector3d up_;
  std::vector<int> tops_, carriers_;
  KinematicTree held_;
  IkProblem problem_;
  std::vector<std::vector<Eigen::Matrix3d>> R_;  // tops × frames
  TrackingResult solved_;
  UprightPosture posture_;
};

}  // namespace

UprightPosture upright_posture(const MusculoskeletalModel& model, const KinematicTree& tree,
                               const MarkerFile& recording, const IkTaskSet& tasks,
                               double posture_weight, const TrackingOptions& options) {
  if (!(posture_weight > 0.0) || !(model.gravity.norm() > 0.0)) return {};
  return UprightSolver(model, tree, recording, tasks).solve(posture_weight, options);
}

}  // namespace sinew
