#include "ik/auto_scale_samples.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "model/scale_measurements.h"

namespace sinew {
namespace {

// The frame in which most markers are measured.
int fullest_frame(const MarkerTrajectories& markers) {
  Eigen::Index frame = 0;
  markers.p_WM.array().isFinite().rowwise().count().maxCoeff(&frame);
  return static_cast<int>(frame);
}

// Changes of the distances between markers, each to this many others at most.
constexpr int kPartners = 8;
// Movement is looked at so often [s]: a twentieth of a gait cycle.
constexpr double kStep = 0.05;
// Change from one look to the next that noise and sway make, and that people make at most [m].
constexpr double kStill = 0.002, kQuickest = 0.05;
// Frames whose distances differ by this much are different poses: soft tissue is another, too [m].
constexpr double kOtherPose = 0.02;

// How far the distances between markers differ between two frames, RMS [m]; 0 if none is in both.
double shape_change(const MarkerTrajectories& markers, int a, int b) {
  const int n = markers.marker_count(), stride = std::max(1, n / kPartners);
  double sum = 0.0;
  int count = 0;
  for (int i = 0; i < n; ++i) {
    for (int j = i + 1; j < n; j += stride) {
      const double change = (markers.position(a, i) - markers.position(a, j)).norm() -
                            (markers.position(b, i) - markers.position(b, j)).norm();
      if (!std::isfinite(change)) continue;
      sum += change * change;
      ++count;
    }
  }
  return count == 0 ? 0.0 : std::sqrt(sum / count);
}

// `count` frames from first to last, evenly spread over movement, or over time if there is none.
std::vector<int> spread_frames(const MarkerTrajectories& markers, int first, int last, int count) {
  const int available = last - first + 1;
  const int step = std::clamp(static_cast<int>(std::lround(kStep * markers.rate)), 1,
                              std::max(1, available / (4 * count)));  // four looks a frame or more
  std::vector<int> looks;
  std::vector<double> way;  // up to each look
  for (int f = first; f <= last; f += step) {
    const double change = looks.empty() ? 0.0 : shape_change(markers, looks.back(), f);
    const double before = way.empty() ? 0.0 : way.back();
    way.push_back(before + std::min(std::max(0.0, change - kStill), kQuickest));
    looks.push_back(f);
  }
  std::vector<int> frames;
  for (int i = 0; i < count; ++i) {
    const double share = count == 1 ? 0.0 : static_cast<double>(i) / (count - 1);
    if (way.back() < kOtherPose) {
      frames.push_back(first + static_cast<int>(std::llround(share * (available - 1))));
      continue;
    }
    const auto at = std::lower_bound(way.begin(), way.end(), share * way.back());
    frames.push_back(looks[static_cast<std::size_t>(at - way.begin())]);
  }
  frames.erase(std::unique(frames.begin(), frames.end()), frames.end());
  return frames;
}

// Poses among the frames that differ from each other.
int count_poses(const MarkerTrajectories& markers) {
  std::vector<int> poses;
  for (int f = 0; f < markers.frame_count(); ++f) {
    const bool known = std::any_of(poses.begin(), poses.end(), [&](int pose) {
      return shape_change(markers, pose, f) < kOtherPose;
    });
    if (!known) poses.push_back(f);
  }
  return static_cast<int>(poses.size());
}

}  // namespace

FrameSample take_frames(const AutoScaleTrial& trial, const AutoScaleOptions& options) {
  const MarkerTrajectories& all = trial.recording->markers;
  const auto [first, last] = frames_around(all, trial.from, trial.to);
  const std::vector<int> chosen =
      spread_frames(all, first, last, std::min(options.frames, last - first + 1));
  const auto count = static_cast<Eigen::Index>(chosen.size());
  FrameSample sample;
  sample.file.path = trial.recording->path;
  MarkerTrajectories& markers = sample.file.markers;
  markers.names = all.names;
  markers.rate = all.rate;
  markers.time.resize(count);
  markers.p_WM.resize(count, all.p_WM.cols());
  for (Eigen::Index i = 0; i < count; ++i) {
    const int frame = chosen[static_cast<std::size_t>(i)];
    markers.frame_numbers.push_back(all.frame_numbers[static_cast<std::size_t>(frame)]);
    markers.time[i] = all.time[frame];
    markers.p_WM.row(i) = all.p_WM.row(frame);
  }
  sample.poses = std::min<double>(options.independent_frames, count_poses(markers));
  sample.weight = std::min(1.0, sample.poses / static_cast<double>(count)) /
                  (options.marker_sd * options.marker_sd);
  return sample;
}

CompiledSamples::CompiledSamples(MusculoskeletalModel scaled,
                                 const std::vector<FrameSample>& samples, bool name_unmatched)
    : model(std::move(scaled)), tree(compile_tree(model)) {
  BindingOptions options;
  options.name_unmatched = name_unmatched;
  options.task_scale = BindingOptions::TaskScale::kMarkerSum;
  options.wires.use = WireOptions::Use::kNone;  // how long muscles are is not known yet
  for (const FrameSample& sample : samples) {
    const IkTaskSet* tasks = sample.tasks.tasks.empty() ? nullptr : &sample.tasks;
    problems.push_back(bind_recording(model, tree, sample.file, tasks, nullptr, options));
  }
}

IkTaskSet posture_tasks(const CompiledSamples& compiled, std::size_t sample,
                        const MarkerTrajectories& markers, const AutoScaleOptions& options) {
  const TrackingProblem& tracking = compiled.problems[sample];
  const MusculoskeletalModel& model = compiled.model;
  IkTaskSet set;
  IkTargets targets(tracking.problem);
  set_targets(tracking, markers, fullest_frame(markers), targets);
  IkTask task;
  task.kind = IkTask::Kind::kCoordinate;
  task.weight = std::pow(options.marker_sd / options.posture_sd, 2);
  for (const int c :
       undetermined_coordinates(model, compiled.tree, tracking, targets, compiled.tree.default_q)) {
    const Coordinate& coordinate = model.coordinates[static_cast<std::size_t>(c)];
    const bool turns = coordinate.motion == Coordinate::Motion::kRotational;
    const bool link = model.bodies[static_cast<std::size_t>(coordinate.joint) + 1].virtual_link;
    if (!turns || link || compiled.tree.v_of_coordinate[static_cast<std::size_t>(c)] < 0) continue;
    task.name = coordinate.name;
    set.tasks.push_back(task);
  }
  if (set.tasks.empty()) return set;
  for (const TrackedMarker& marker : tracking.markers) {
    IkTask tracked;
    tracked.name = model.markers[static_cast<std::size_t>(marker.model)].name;
    set.tasks.push_back(tracked);
  }
  return set;
}

}  // namespace sinew
