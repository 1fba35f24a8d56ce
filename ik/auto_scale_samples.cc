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

}  // namespace

FrameSample take_frames(const AutoScaleTrial& trial, const AutoScaleOptions& options) {
  const MarkerTrajectories& all = trial.recording->markers;
  const auto [first, last] = frames_around(all, trial.from, trial.to);
  const int available = last - first + 1, count = std::min(options.frames, available);
  FrameSample sample;
  sample.file.path = trial.recording->path;
  MarkerTrajectories& markers = sample.file.markers;
  markers.names = all.names;
  markers.rate = all.rate;
  markers.time.resize(count);
  markers.p_WM.resize(count, all.p_WM.cols());
  for (int i = 0; i < count; ++i) {
    const int frame =
        count == 1
            ? first
            : first + static_cast<int>(std::llround(double(i) * (available - 1) / (count - 1)));
    markers.frame_numbers.push_back(all.frame_numbers[static_cast<std::size_t>(frame)]);
    markers.time[i] = all.time[frame];
    markers.p_WM.row(i) = all.p_WM.row(frame);
  }
  sample.weight =
      std::min(1.0, options.independent_frames / count) / (options.marker_sd * options.marker_sd);
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
