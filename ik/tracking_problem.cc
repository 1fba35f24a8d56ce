#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>

#include "ik/tracking.h"

namespace sinew {
namespace {

// "a, b, c and 12 more": enough to act on, short enough for one line.
std::string some_of(const std::vector<std::string>& names) {
  constexpr std::size_t kShown = 8;
  std::string text;
  for (std::size_t i = 0; i < std::min(names.size(), kShown); ++i) {
    text += (i == 0 ? "" : ", ") + names[i];
  }
  if (names.size() > kShown) text += fmt::format(" and {} more", names.size() - kShown);
  return text;
}

bool ever_measured(const MarkerTrajectories& markers, int marker) {
  return markers.p_WM.col(3 * marker).array().isFinite().any();
}

class Binder {
 public:
  Binder(const MusculoskeletalModel& model, const KinematicTree& tree, const MarkerFile& recording,
         const IkTaskSet* tasks, const RowMatrix* values, const BindingOptions& options)
      : model_(model),
        tree_(tree),
        recording_(recording),
        tasks_(tasks),
        values_(values),
        options_(options) {}

  TrackingProblem bind() {
    bind_markers();
    if (tasks_ != nullptr) bind_coordinates();
    bind_loops();
    bind_links();
    result_.wires = bind_wires(model_, tree_, options_.wires, result_.problem, result_.warnings);
    return std::move(result_);
  }

 private:
  void warn(std::string text) {
    result_.warnings.push_back({{recording_.path, 0}, std::move(text)});
  }
  void warn_task(const IkTask& task, std::string text) {
    result_.warnings.push_back({{tasks_->path, task.line}, std::move(text)});
  }

  void add_marker(const std::string& name, double weight) {
    const TrackedMarker tracked{name, recording_.markers.find_marker(name),
                                model_.find_marker(name), weight};
    const Marker& marker = model_.markers[static_cast<std::size_t>(tracked.model)];
    result_.markers.push_back(tracked);
    result_.problem.positions.push_back(
        {marker.body, marker.p_BM, weight * Eigen::Matrix3d::Identity()});
  }

  void bind_markers() {
    std::vector<std::string> not_in_model, never_measured, not_named;
    std::map<std::string, double> weights;
    if (tasks_ != nullptr) weights = task_weights();
    const MarkerTrajectories& markers = recording_.markers;
    for (int m = 0; m < markers.marker_count(); ++m) {
      const std::string& name = markers.names[static_cast<std::size_t>(m)];
      const auto weight = weights.find(name);
      if (model_.find_marker(name) < 0) {
        not_in_model.push_back(name);
      } else if (!ever_measured(markers, m)) {
        never_measured.push_back(name);
      } else if (tasks_ != nullptr && weight == weights.end()) {
        not_named.push_back(name);
      } else {
        const double w = tasks_ == nullptr ? 1.0 : weight->second;
        if (w > 0.0) add_marker(name, w);
      }
    }
    std::vector<std::string> not_recorded;
    for (const Marker& marker : model_.markers) {
      if (markers.find_marker(marker.name) < 0) not_recorded.push_back(marker.name);
    }
    const auto report = [&](const std::vector<std::string>& names, const char* what) {
      if (!names.empty()) warn(fmt::format("{} {}: {}", names.size(), what, some_of(names)));
    };
    if (options_.name_unmatched) {
      report(not_in_model, "recorded markers are not in the model and are not used");
      report(not_recorded, "markers of the model are not in the recording");
    }
    report(never_measured, "markers are never measured");
    report(not_named, "recorded markers have no task and are not used");
    if (result_.markers.empty()) {
      throw InputError(
          {recording_.path},
          {"no marker is left to track",
           fmt::format("names that model '{}' has too ({})", model_.name,
                       some_of(model_marker_names())),
           some_of(markers.names), "Rename markers, or add them to the model or to the tasks."});
    }
  }

  std::vector<std::string> model_marker_names() const {
    std::vector<std::string> names;
    for (const Marker& marker : model_.markers) names.push_back(marker.name);
    return names;
  }

  std::map<std::string, double> task_weights() {
    std::map<std::string, double> weights;
    for (const IkTask& task : tasks_->tasks) {
      if (task.kind != IkTask::Kind::kMarker || !task.apply) continue;
      if (model_.find_marker(task.name) < 0) {
        warn_task(task, fmt::format("marker '{}' of a task is not in the model", task.name));
      } else if (recording_.markers.find_marker(task.name) < 0) {
        warn_task(task, fmt::format("marker '{}' of a task is not in the recording", task.name));
      }
      if (!weights.emplace(task.name, task.weight).second) {
        warn_task(task,
                  fmt::format("marker '{}' has a second task; the first one counts", task.name));
      }
    }
    return weights;
  }

  void bind_coordinates() {
    const bool beside_mean = options_.task_scale == BindingOptions::TaskScale::kMarkerMean;
    double scale = 1.0;
    if (beside_mean) {
      scale = 0.0;
      for (const TrackedMarker& marker : result_.markers) scale += marker.weight;
    }
    for (const IkTask& task : tasks_->tasks) {
      if (task.kind != IkTask::Kind::kCoordinate || !task.apply) continue;
      const int c = model_.find_coordinate(task.name);
      if (c < 0) {
        warn_task(task, fmt::format("coordinate '{}' of a task is not in the model", task.name));
        continue;
      }
      const Coordinate& coordinate = model_.coordinates[static_cast<std::size_t>(c)];
      if (coordinate.locked) {
        warn_task(task, fmt::format("coordinate '{}' of a task is locked in the model: it stays at "
                                    "{:.6g}",
                                    task.name, coordinate.default_value));
        continue;
      }
      if (task.weight == 0.0) continue;
      const int q = tree_.q_of_coordinate[static_cast<std::size_t>(c)];
      const int v = tree_.v_of_coordinate[static_cast<std::size_t>(c)];
      const double weight = scale * task.weight;
      result_.problem.coordinates.push_back({q, v, weight});
      result_.coordinates.push_back(
          {c, weight, task_value(task, coordinate), file_values(task, c), beside_mean});
    }
  }

  static double task_value(const IkTask& task, const Coordinate& coordinate) {
    return task.value_type == IkTask::ValueType::kManual ? task.value : coordinate.default_value;
  }

  std::vector<double> file_values(const IkTask& task, int c) {
    if (task.value_type != IkTask::ValueType::kFromFile) return {};
    if (values_ == nullptr || !values_->col(c).array().isFinite().any()) {
      throw InputError({tasks_->path, task.line},
                       {fmt::format("coordinate '{}' takes its values from a file", task.name),
                        "a coordinate file with that column", "none",
                        "Name one as <coordinate_file>, or set <value_type>."});
    }
    const Eigen::VectorXd column = values_->col(c);
    return {column.begin(), column.end()};
  }

  void bind_loops() {
    for (const WeldConstraint& weld : model_.welds) {
      result_.problem.coincidences.push_back(
          {weld.body1, weld.body2, weld.X_B1F1.p, weld.X_B2F2.p, options_.loop_weight});
      result_.problem.alignments.push_back(
          {weld.body1, weld.body2, weld.X_B1F1.R, weld.X_B2F2.R, options_.loop_weight});
    }
    for (const PointConstraint& point : model_.point_constraints) {
      result_.problem.coincidences.push_back(
          {point.body1, point.body2, point.p_B1P1, point.p_B2P2, options_.loop_weight});
    }
  }

  void bind_links() {
    for (std::size_t b = 1; b < model_.bodies.size(); ++b) {
      if (model_.bodies[b].virtual_link) result_.virtual_links.push_back(static_cast<int>(b));
    }
    for (const int c : bind_virtual_links(model_, tree_, options_.wires, result_.problem)) {
      result_.coordinates.push_back({c,
                                     options_.wires.virtual_link_weight,
                                     model_.coordinates[static_cast<std::size_t>(c)].default_value,
                                     {},
                                     false});
    }
  }

  const MusculoskeletalModel& model_;
  const KinematicTree& tree_;
  const MarkerFile& recording_;
  const IkTaskSet* tasks_;
  const RowMatrix* values_;
  const BindingOptions options_;
  TrackingProblem result_;
};

}  // namespace

TrackingProblem bind_recording(const MusculoskeletalModel& model, const KinematicTree& tree,
                               const MarkerFile& recording, const IkTaskSet* tasks,
                               const RowMatrix* coordinate_values, const BindingOptions& options) {
  return Binder(model, tree, recording, tasks, coordinate_values, options).bind();
}

namespace {

// What coordinates beside the markers' mean are multiplied by in a frame: exactly 1 where all is
// seen.
double seen_share(const TrackingProblem& tracking, const IkTargets& targets) {
  double seen = 0.0, all = 0.0;
  for (std::size_t i = 0; i < tracking.markers.size(); ++i) {
    const double weight = tracking.markers[i].weight;
    all += weight;
    if (!std::isnan(targets.positions[i].x())) seen += position_scale(targets, i) * weight;
  }
  return (seen > 0.0 ? seen : 1.0) / all;
}

}  // namespace

void set_targets(const TrackingProblem& tracking, const MarkerTrajectories& markers, int frame,
                 IkTargets& targets) {
  const bool scaled = tracking.marker_scales.size() > 0;
  if (scaled) targets.position_scales.resize(tracking.markers.size(), 1.0);
  for (std::size_t i = 0; i < tracking.markers.size(); ++i) {
    targets.positions[i] = markers.position(frame, tracking.markers[i].recorded);
    if (!scaled) continue;
    targets.position_scales[i] = tracking.marker_scales(frame, static_cast<Eigen::Index>(i));
  }
  for (std::size_t i = 0; i < tracking.coordinates.size(); ++i) {
    const TrackedCoordinate& c = tracking.coordinates[i];
    targets.coordinates[i] = c.values.empty() ? c.value : c.values[static_cast<std::size_t>(frame)];
  }
  if (std::none_of(tracking.coordinates.begin(), tracking.coordinates.end(),
                   [](const TrackedCoordinate& c) { return c.beside_mean; })) {
    return;
  }
  const double share = seen_share(tracking, targets);
  targets.coordinate_scales.resize(tracking.coordinates.size(), 1.0);
  for (std::size_t i = 0; i < tracking.coordinates.size(); ++i) {
    targets.coordinate_scales[i] = tracking.coordinates[i].beside_mean ? share : 1.0;
  }
}

}  // namespace sinew
