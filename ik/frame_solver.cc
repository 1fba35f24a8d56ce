#include "ik/frame_solver.h"

#include <algorithm>
#include <cmath>

namespace sinew {
namespace {

void read_coordinates(const KinematicTree& tree, const std::vector<double>& q,
                      Eigen::Ref<Eigen::RowVectorXd> row) {
  for (std::size_t c = 0; c < tree.q_of_coordinate.size(); ++c) {
    row[static_cast<Eigen::Index>(c)] = q[static_cast<std::size_t>(tree.q_of_coordinate[c])];
  }
}

void measure_wires(const TrackingProblem& tracking, const KinematicWorkspace& ws, int frame,
                   TrackingResult& result) {
  for (std::size_t i = 0; i < tracking.wires.size(); ++i) {
    result.wire_lengths(frame, static_cast<Eigen::Index>(i)) =
        wire_length(tracking.problem, tracking.problem.wires[i], ws);
  }
  for (std::size_t i = 0; i < tracking.virtual_links.size(); ++i) {
    result.furcations.row(frame).segment<3>(3 * static_cast<Eigen::Index>(i)) =
        ws.X_WB[static_cast<std::size_t>(tracking.virtual_links[i])].p.transpose();
  }
}

}  // namespace

void measure_frame(const TrackingProblem& tracking, const IkTargets& targets,
                   const KinematicWorkspace& ws, int frame_index, int index,
                   TrackingResult& result) {
  measure_wires(tracking, ws, index, result);
  auto errors = result.marker_errors.row(index);
  FrameResult& frame = result.frames[static_cast<std::size_t>(index)];
  double sum = 0.0;
  frame.measured_markers = 0;
  frame.marker_max = kNaN;
  frame.worst_marker = -1;
  for (std::size_t i = 0; i < tracking.markers.size(); ++i) {
    const PositionResidual& r = tracking.problem.positions[i];
    // A filled sample is no measurement to err from.
    const bool filled =
        tracking.filled.size() > 0 && tracking.filled(frame_index, static_cast<Eigen::Index>(i));
    const double error =
        filled ? kNaN
               : (targets.positions[i] - ws.X_WB[static_cast<std::size_t>(r.link)] * r.p_BP).norm();
    errors[static_cast<Eigen::Index>(i)] = error;
    if (std::isnan(error)) continue;
    sum += error * error;
    ++frame.measured_markers;
    if (!(error <= frame.marker_max)) {
      frame.marker_max = error;
      frame.worst_marker = static_cast<int>(i);
    }
  }
  frame.marker_rms = frame.measured_markers > 0 ? std::sqrt(sum / frame.measured_markers) : kNaN;
}

TrackingResult empty_result(const MusculoskeletalModel& model, const TrackingProblem& tracking,
                            const MarkerTrajectories& markers, int first, int frames) {
  TrackingResult result;
  result.time = markers.time.segment(first, frames);
  result.coordinates.resize(frames, static_cast<Eigen::Index>(model.coordinates.size()));
  result.marker_errors.resize(frames, static_cast<Eigen::Index>(tracking.markers.size()));
  result.wire_lengths.resize(frames, static_cast<Eigen::Index>(tracking.wires.size()));
  result.furcations.resize(frames, static_cast<Eigen::Index>(3 * tracking.virtual_links.size()));
  result.frames.resize(static_cast<std::size_t>(frames));
  return result;
}

double cost_noise(const TrackingProblem& tracking) {
  double sum = 0.0;
  for (const TrackedMarker& marker : tracking.markers) sum += marker.weight;
  constexpr double kNoise = 1e-8;  // [m]
  return 0.5 * sum * kNoise * kNoise;
}

FrameSolver::FrameSolver(const KinematicTree& tree, const TrackingProblem& tracking,
                         const MarkerTrajectories& markers, const TrackingOptions& options)
    : tree_(tree),
      tracking_(tracking),
      markers_(markers),
      options_(options),
      minimizer_(tree, tracking.problem, options.minimizer),
      targets_(tracking.problem),
      warm_start_(tree, tracking.problem) {}

void FrameSolver::ask(int frame, std::vector<double>& q) {
  set_targets(tracking_, markers_, options_.first_frame + frame, targets_);
  prescribe(tree_, markers_.time[options_.first_frame + frame], q);
}

ColdStart& FrameSolver::cold() {
  if (!cold_) cold_.emplace(tree_, tracking_.problem, options_.minimizer, options_.cold_start);
  return *cold_;
}

const Summary& FrameSolver::solve(int frame, std::vector<double>& q) {
  set_targets(tracking_, markers_, options_.first_frame + frame, targets_);
  warm_start_.advance(tree_, tracking_.problem, targets_, q);
  prescribe(tree_, markers_.time[options_.first_frame + frame], q);
  solved_ = &minimizer_.workspace();
  return minimizer_.minimize(targets_, q);
}

const Summary& FrameSolver::solve_cold(int frame, std::vector<double>& q) {
  ask(frame, q);
  const Summary& summary = cold().minimize(targets_, q);
  solved_ = &cold_->workspace();
  return summary;
}

const Summary* FrameSolver::look_again(int frame, std::vector<double>& q, double cost) {
  ask(frame, q);
  if (!cold().look_again(targets_, q, cost)) return nullptr;
  solved_ = &cold_->workspace();
  return &cold_->summary();
}

void FrameSolver::store(int frame, const Summary& summary, const std::vector<double>& q,
                        TrackingResult& result) {
  FrameResult& out = result.frames[static_cast<std::size_t>(frame)];
  out.termination = summary.termination;
  out.iterations = summary.iterations;
  out.evaluations = summary.evaluations;
  out.cost = summary.final_cost;
  out.bound_push = summary.bound_push;
  out.seconds = summary.seconds;
  out.rows = summary.rows;
  read_coordinates(tree_, q, result.coordinates.row(frame));
  measure_frame(tracking_, targets_, *solved_, options_.first_frame + frame, frame, result);
}

}  // namespace sinew
