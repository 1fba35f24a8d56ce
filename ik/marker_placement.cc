#include "ik/marker_placement.h"

#include <fmt/format.h>

#include <cmath>
#include <set>
#include <stdexcept>

#include "model/scale_measurements.h"

namespace sinew {
namespace {

using Eigen::Vector3d;
using Fate = PlacedMarker::Fate;

// The tasks, and one of the default weight for every marker that no task weighs.
IkTaskSet complete_tasks(const MusculoskeletalModel& model, const MarkerTrajectories& markers,
                         const IkTaskSet* tasks, double default_weight) {
  IkTaskSet complete;
  std::set<std::string> weighed;
  if (tasks != nullptr) {
    complete.path = tasks->path;
    for (const IkTask& task : tasks->tasks) {
      if (!task.apply) continue;
      complete.tasks.push_back(task);
      if (task.kind == IkTask::Kind::kMarker) weighed.insert(task.name);
    }
  }
  for (const Marker& marker : model.markers) {
    if (weighed.contains(marker.name) || markers.find_marker(marker.name) < 0) continue;
    IkTask task;
    task.name = marker.name;
    task.weight = default_weight;
    complete.tasks.push_back(task);
  }
  return complete;
}

void warn_of_movement(const MarkerFile& trial, int first, int last, double limit,
                      std::vector<Warning>& warnings) {
  const MarkerTrajectories& markers = trial.markers;
  for (int m = 0; m < markers.marker_count(); ++m) {
    Vector3d low = Vector3d::Constant(std::numeric_limits<double>::infinity()), high = -low;
    for (int frame = first; frame <= last; ++frame) {
      const Vector3d p = markers.position(frame, m);
      if (p.hasNaN()) continue;
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
    const double movement = (high - low).maxCoeff();
    if (!(movement > limit)) continue;
    warnings.push_back(
        {{trial.path, 0},
         fmt::format("marker '{}' moves by {:.1f} mm in the static trial; the limit "
                     "is {:.1f} mm",
                     markers.names[static_cast<std::size_t>(m)], 1e3 * movement, 1e3 * limit)});
  }
}

// Poses of all bodies at the coordinates found.
KinematicWorkspace pose_at(const KinematicTree& tree, const Eigen::VectorXd& coordinates) {
  KinematicWorkspace workspace(tree);
  for (std::size_t c = 0; c < tree.q_of_coordinate.size(); ++c) {
    workspace.q[static_cast<std::size_t>(tree.q_of_coordinate[c])] =
        coordinates[static_cast<Eigen::Index>(c)];
  }
  update_poses(tree, workspace);
  return workspace;
}

// Decides for each marker what becomes of it, and moves or removes it.
void settle_markers(const MusculoskeletalModel& model, const MarkerTrajectories& mean,
                    const KinematicWorkspace& pose, bool move, MarkerPlacementResult& result) {
  result.model = model;
  std::vector<Marker> kept;
  for (Marker marker : model.markers) {
    PlacedMarker placed;
    placed.name = marker.name;
    const int recorded = mean.find_marker(marker.name);
    const RigidTransform& X_WB = pose.X_WB[static_cast<std::size_t>(marker.body)];
    if (recorded < 0) {
      placed.fate = Fate::kRemoved;
    } else if (const Vector3d p_WM = mean.position(0, recorded); p_WM.hasNaN()) {
      placed.fate = Fate::kNotMeasured;
    } else {
      placed.distance = (X_WB * marker.p_BM - p_WM).norm();
      placed.fate = marker.fixed ? Fate::kFixed : Fate::kMoved;
      if (!marker.fixed && move) marker.p_BM = X_WB.inverse() * p_WM;
    }
    if (placed.fate != Fate::kRemoved || !move) kept.push_back(marker);
    result.markers.push_back(placed);
  }
  result.model.markers = std::move(kept);
}

void summarize_fit(const TrackingProblem& tracking, MarkerPlacementResult& result) {
  double sum = 0.0;
  int count = 0;
  for (const TrackedMarker& tracked : tracking.markers) {
    PlacedMarker& placed = result.markers[static_cast<std::size_t>(tracked.model)];
    placed.weight = tracked.weight;
    if (std::isnan(placed.distance)) continue;
    sum += placed.distance * placed.distance;
    ++count;
    if (!(placed.distance <= result.marker_max)) {
      result.marker_max = placed.distance;
      result.worst_marker = placed.name;
    }
  }
  if (count > 0) result.marker_rms = std::sqrt(sum / count);
}

}  // namespace

void MarkerPlacementOptions::validate() const {
  minimizer.validate();
  cold_start.validate();
  if (!(default_weight >= 0.0) || !std::isfinite(default_weight)) {
    throw std::invalid_argument(fmt::format(
        "MarkerPlacementOptions.default_weight is {}; expected 0 or more", default_weight));
  }
  if (max_marker_movement && !(*max_marker_movement > 0.0)) {
    throw std::invalid_argument(
        fmt::format("MarkerPlacementOptions.max_marker_movement is {}; expected more than 0 m",
                    *max_marker_movement));
  }
}

MarkerTrajectories average_frames(const MarkerTrajectories& markers, int first, int last) {
  MarkerTrajectories mean;
  mean.names = markers.names;
  mean.rate = markers.rate;
  mean.frame_numbers = {markers.frame_numbers[static_cast<std::size_t>(first)]};
  mean.time = markers.time.segment(first, 1);
  mean.p_WM = RowMatrix::Constant(1, markers.p_WM.cols(), kNaN);
  for (int m = 0; m < markers.marker_count(); ++m) {
    Vector3d sum = Vector3d::Zero();
    int count = 0;
    for (int frame = first; frame <= last; ++frame) {
      const Vector3d p = markers.position(frame, m);
      if (p.hasNaN()) continue;
      sum += p;
      ++count;
    }
    if (count > 0) mean.p_WM.row(0).segment<3>(3 * m) = (sum / count).transpose();
  }
  return mean;
}

BoundPlacement bind_placement(const MusculoskeletalModel& model, const KinematicTree& tree,
                              const MarkerFile& trial, const IkTaskSet* tasks,
                              const RowMatrix* coordinate_values,
                              const MarkerPlacementOptions& options) {
  const auto [first, last] = frames_around(trial.markers, options.from, options.to);
  BoundPlacement bound{{trial.path, average_frames(trial.markers, first, last), {}}, {}};
  const IkTaskSet complete =
      complete_tasks(model, bound.mean.markers, tasks, options.default_weight);
  bound.tracking = bind_recording(model, tree, bound.mean, &complete, coordinate_values);
  return bound;
}

MarkerPlacementResult place_markers(const MusculoskeletalModel& model, const MarkerFile& trial,
                                    const IkTaskSet* tasks, const RowMatrix* coordinate_values,
                                    const MarkerPlacementOptions& options) {
  options.validate();
  MarkerPlacementResult result;
  const auto [first, last] = frames_around(trial.markers, options.from, options.to);
  if (options.max_marker_movement) {
    warn_of_movement(trial, first, last, *options.max_marker_movement, result.warnings);
  }
  const KinematicTree tree = compile_tree(model);
  const auto [mean, tracking] =
      bind_placement(model, tree, trial, tasks, coordinate_values, options);
  result.warnings.insert(result.warnings.end(), tracking.warnings.begin(), tracking.warnings.end());

  TrackingOptions tracking_options;
  tracking_options.minimizer = options.minimizer;
  tracking_options.cold_start = options.cold_start;
  tracking_options.threads = 1;
  const TrackingResult tracked = track(model, tree, tracking, mean.markers, tracking_options);
  result.coordinates = tracked.coordinates.row(0).transpose();
  result.time = mean.markers.time[0];
  result.frames = last - first + 1;
  result.termination = tracked.frames[0].termination;
  result.search = tracked.searched[0].search;
  settle_markers(model, mean.markers, pose_at(tree, result.coordinates), options.move_markers,
                 result);
  summarize_fit(tracking, result);
  return result;
}

}  // namespace sinew
