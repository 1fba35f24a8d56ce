#include "pipeline/lab_attach.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <stdexcept>

#include "data/computed_points.h"
#include "data/marker_matching.h"
#include "data/marker_names.h"
#include "data/output_file.h"
#include "ik/marker_attachment.h"
#include "ik/marker_clusters.h"
#include "ik/marker_placement.h"
#include "ik/tracking.h"
#include "model/osim_document.h"
#include "model/osim_file.h"
#include "model/segment_words.h"
#include "pipeline/lab_motion.h"

namespace sinew {
namespace {

using Eigen::Vector3d;
using Fate = MarkerAttachment::Fate;

constexpr int kFrames = 150;         // tell as much of a walk as all
constexpr int kRounds = 8;           // a chain of clusters from the pelvis to the toes, or the hand
constexpr double kSamePlace = 0.04;  // [m] a marker that was put on anew between trials is farther

// A marker of the recording that has no name in the model, and what became of it.
struct Unmatched {
  int recorded = -1;
  std::string name;
  int body = -1;
  Vector3d p_BM = Vector3d::Constant(kNaN);
  std::string why;
  std::optional<double> confidence;
  bool computed = false;  // or nobody named it: no candidate
};

class LabAttacher {
 public:
  LabAttacher(const LabAttachment& job, int threads)
      : job_(job), threads_(threads), model_(read_osim(job.model_file)) {
    const MarkerTrajectories& all = *job.walk;
    walk_ = some_frames(all, 0, all.frame_count() - 1, kFrames);
    const std::vector<std::string> reasons = why_no_marker(all);
    for (int m = 0; m < all.marker_count(); ++m) {
      const std::string& name = all.names[static_cast<std::size_t>(m)];
      if (model_.find_marker(name) >= 0) continue;
      if (!all.p_WM.col(3 * m).array().isFinite().any()) continue;
      unmatched_.push_back({m,
                            name,
                            -1,
                            Vector3d::Constant(kNaN),
                            reasons[static_cast<std::size_t>(m)],
                            {},
                            !reasons[static_cast<std::size_t>(m)].empty()});
      if (reasons[static_cast<std::size_t>(m)].empty()) candidates_.push_back(m);
    }
  }

  bool any() const { return !unmatched_.empty(); }

  // Not to be attached, nor to tell where others are.
  void leave_out(const Unmatched& marker) { std::erase(candidates_, marker.recorded); }

  // Rounds, for what is attached may tell where another segment is.
  void find() {
    for (int round = 0; round < kRounds && !candidates_.empty(); ++round) {
      update();
      const std::size_t before = candidates_.size();
      attach_single();
      // Singles first: a group is for segments that these leave without a marker.
      if (candidates_.size() == before) attach_groups();
      if (candidates_.size() == before) break;
    }
  }

  // The place of a marker in a body that the user names.
  Vector3d place(const Unmatched& marker, int body) {
    if (!ready_) update();
    return place_of(marker.recorded, body);
  }

  std::vector<Unmatched>& unmatched() { return unmatched_; }
  const MusculoskeletalModel& model() const { return model_; }

 private:
  struct Poses {
    BodyPoses poses;
    MarkerTrajectories markers;
  };

  Poses solve(const MarkerTrajectories& markers) const {
    const KinematicTree tree = compile_tree(model_);
    IkTaskSet tasks;
    tasks.tasks = marker_tasks(markers, model_);
    for (const IkTask& task : posture_tasks(markers, model_, default_posture_weight())) {
      tasks.tasks.push_back(task);
    }
    BindingOptions binding;
    binding.name_unmatched = false;
    const MarkerFile file{"markers", markers, {}};
    const TrackingProblem tracking = bind_recording(model_, tree, file, &tasks, nullptr, binding);
    TrackingOptions options;
    options.threads = threads_;
    const TrackingResult solved = track(model_, tree, tracking, markers, options);
    return {body_poses(model_, tree, tracking, markers, solved), markers};
  }

  void update() {
    walking_ = solve(walk_);
    if (job_.standing != nullptr) {
      standing_ = solve(average_frames(*job_.standing, 0, job_.standing->frame_count() - 1));
    }
    ready_ = true;
  }

  Vector3d place_of(int recorded, int body) const {
    const Vector3d walked = place_in_body(walking_.poses, walk_, recorded, body).p_BM;
    if (!standing_ || !standing_->poses.determined[static_cast<std::size_t>(body)]) return walked;
    const int column =
        standing_->markers.find_marker(walk_.names[static_cast<std::size_t>(recorded)]);
    if (column < 0) return walked;
    const Vector3d stood = place_in_body(standing_->poses, standing_->markers, column, body).p_BM;
    return (stood - walked).norm() < kSamePlace ? stood : walked;
  }

  Unmatched& of(int recorded) {
    return *std::find_if(unmatched_.begin(), unmatched_.end(),
                         [&](const Unmatched& marker) { return marker.recorded == recorded; });
  }

  void attach(int recorded, int body, const Vector3d& p_BM) {
    Unmatched& marker = of(recorded);
    marker.body = body;
    marker.p_BM = p_BM;
    model_.markers.push_back({marker.name, body, p_BM, false, {}});
    candidates_.erase(std::find(candidates_.begin(), candidates_.end(), recorded));
  }

  std::string words(int body) const {
    return body == 0 ? "the laboratory"
                     : segments_in_words(
                           {segment_of_body(model_.bodies[static_cast<std::size_t>(body)].name)});
  }

  std::string why(const MarkerAttachment& a) const {
    const auto mm = [](double metres) { return fmt::format("{:.0f} mm", 1e3 * metres); };
    switch (a.fate) {
      case Fate::kSeldom:
        return "measured in too few frames to tell";
      case Fate::kStill:
        return "stays in the laboratory";
      case Fate::kLoose:
        return a.body < 0 ? "no body is known well enough"
                          : fmt::format("keeps its place on no segment: on {} it moves by {}",
                                        words(a.body), mm(a.spread));
      case Fate::kFar:
        return fmt::format("moves with {}, but is not on it", words(a.body));
      case Fate::kAmbiguous:
        return fmt::format("moves by {} on {} and by {} on {}", mm(a.spread), words(a.body),
                           mm(a.next_spread), words(a.next_body));
      default:
        return a.next_body < 0 ? fmt::format("moves by {} on {}", mm(a.spread), words(a.body))
                               : fmt::format("moves by {} on {}, by {} on {}", mm(a.spread),
                                             words(a.body), mm(a.next_spread), words(a.next_body));
    }
  }

  // A model without a head carries no head's markers, unless its author put some on the trunk.
  bool contradicts(const MarkerAttachment& a) const {
    if (parse_marker_name(a.name).place != MarkerPlace::kHead) return false;
    if (segment_of_body(model_.bodies[static_cast<std::size_t>(a.body)].name).part == "head") {
      return false;
    }
    return std::none_of(model_.markers.begin(), model_.markers.end(), [&](const Marker& marker) {
      return marker.body == a.body && parse_marker_name(marker.name).place == MarkerPlace::kHead;
    });
  }

  void attach_single() {
    for (const MarkerAttachment& a : find_attachments(model_, walking_.poses, walk_, candidates_)) {
      Unmatched& marker = of(a.recorded);
      marker.why = why(a);
      if (a.fate != Fate::kAttached) continue;
      if (contradicts(a)) {
        marker.why += "; but it is a head's by its name, and the model has no head there";
        continue;
      }
      marker.confidence = a.confidence();
      attach(a.recorded, a.body, place_of(a.recorded, a.body));
    }
  }

  void attach_groups() {
    if (!standing_) return;
    for (const ClusterAttachment& cluster : attach_clusters(
             model_, rigid_groups(walk_, candidates_), standing_->markers,
             standing_->poses.X_WB.front(), standing_->poses.determined, walk_, walking_.poses)) {
      for (std::size_t i = 0; i < cluster.group.size(); ++i) {
        Unmatched& marker = of(cluster.group[i]);
        marker.why = fmt::format(
            "one of {} that keep their distances to {:.0f} mm; as part of {} its joints stay "
            "within {:.0f} mm",
            cluster.group.size(), 1e3 * cluster.distance_sd, words(cluster.body),
            1e3 * cluster.joint_error);
        marker.confidence =
            std::isnan(cluster.next_error) ? 0.9 : 1.0 - cluster.joint_error / cluster.next_error;
        attach(cluster.group[i], cluster.body, cluster.p_BM[i]);
      }
    }
  }

  const LabAttachment& job_;
  int threads_;
  MusculoskeletalModel model_;
  MarkerTrajectories walk_;
  std::vector<Unmatched> unmatched_;
  std::vector<int> candidates_;  // columns of the walk that are not attached yet
  Poses walking_;
  std::optional<Poses> standing_;
  bool ready_ = false;
};

// NAME=BODY of --attach; names may stand without their subject.
std::map<std::string, std::string> said_bodies(const std::vector<std::string>& said,
                                               const std::vector<Unmatched>& unmatched) {
  std::map<std::string, std::string> bodies;
  std::vector<std::string> names;
  for (const Unmatched& marker : unmatched) names.push_back(marker.name);
  for (const std::string& text : said) {
    const std::size_t equals = text.rfind('=');
    const std::string name = text.substr(0, equals);
    if (equals == text.npos || name.empty()) {
      throw std::invalid_argument(fmt::format("--attach is '{}'; expected NAME=BODY", text));
    }
    if (std::find(names.begin(), names.end(), name) == names.end()) {
      const std::string nearest = nearest_name(name, names);
      throw std::invalid_argument(
          fmt::format("--attach names '{}', which is no recorded marker without a name in the "
                      "model{}",
                      name, nearest.empty() ? "" : "; is it " + nearest + "?"));
    }
    const auto [place, first] = bodies.emplace(name, text.substr(equals + 1));
    if (!first) {
      throw std::invalid_argument(
          fmt::format("--attach names '{}' twice, for {} and for {}; give one", name, place->second,
                      text.substr(equals + 1)));
    }
  }
  return bodies;
}

}  // namespace

namespace {

// What the user's map gives no name in the model is left out, unless --attach says otherwise.
void leave_out_of_map(const LabOptions& options, const std::map<std::string, std::string>& said,
                      LabAttacher& attacher, DecisionLog& log) {
  if (options.map.empty()) return;
  const MarkerMap map = read_marker_map(options.map);
  for (const Unmatched& marker : attacher.unmatched()) {
    const bool left_out = std::any_of(map.begin(), map.end(), [&](const auto& entry) {
      return entry.second.empty() &&
             (entry.first == marker.name || entry.first.ends_with(":" + marker.name));
    });
    if (!left_out || said.contains(marker.name)) continue;
    attacher.leave_out(marker);
    log.say("attach " + marker.name, "", options.given_now.contains("--map"));
  }
}

}  // namespace

void attach_lab_markers(const LabAttachment& job, const LabOptions& options, int threads,
                        DecisionLog& log) {
  LabAttacher attacher(job, threads);
  if (!attacher.any()) {
    said_bodies(options.attach, {});
    return;
  }
  const auto said = said_bodies(options.attach, attacher.unmatched());
  if (options.no_attach) log.say("attach", false, options.given_now.contains("--no-attach"));
  const bool wanted = log.settle_flag({"attach",
                                       {},
                                       true,
                                       "markers that the model lacks, if they keep their distances "
                                       "to a segment",
                                       {},
                                       "",
                                       "--no-attach"},
                                      true);
  leave_out_of_map(options, said, attacher, log);
  if (wanted) attacher.find();
  MusculoskeletalModel attached = attacher.model();
  attached.markers.clear();
  for (Unmatched& marker : attacher.unmatched()) {
    const std::string decision = "attach " + marker.name;
    const auto by_user = said.find(marker.name);
    if (by_user != said.end()) {
      log.say(decision, by_user->second, options.given_now.contains("--attach"));
    }
    if ((!wanted || marker.computed) && !log.said(decision)) continue;
    const std::string found =
        marker.body < 0 ? "" : attached.bodies[static_cast<std::size_t>(marker.body)].name;
    const std::string value = log.settle_text({decision,
                                               {},
                                               found,
                                               marker.why,
                                               marker.confidence,
                                               "",
                                               "--attach " + marker.name + "=BODY"});
    if (value.empty()) continue;
    const int body = attached.find_body(value);
    if (body <= 0) {
      std::vector<std::string> names;
      for (std::size_t b = 1; b < attached.bodies.size(); ++b)
        names.push_back(attached.bodies[b].name);
      throw InputError(
          {job.model_file.string()},
          {fmt::format("has no body '{}', which '{}' is to be attached to", value, marker.name),
           nearest_name(value, names), "", "Correct --attach."});
    }
    const Vector3d p_BM = value == found ? marker.p_BM : attacher.place(marker, body);
    attached.markers.push_back({marker.name, body, p_BM, false, {}});
  }
  if (attached.markers.empty()) return;
  write_file_atomically(job.marker_file, write_marker_set(attached));
  OsimDocument document(job.model_file);
  document.merge_markers(job.marker_file);
  write_file_atomically(job.model_file, document.to_string());
}

}  // namespace sinew
