#include "ik/assembler.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <stdexcept>

#include "ik/assembler_goal.h"
#include "ik/second_look.h"

namespace sinew {
namespace {

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

}  // namespace

struct AssemblerSolver::Simbody {
  SimbodyModel model;
  SimTK::Assembler assembler;
  SimTK::Markers* markers = nullptr;  // owned by the assembler
  AssemblerGoal* others = nullptr;    // ", where there are other residuals
  std::vector<std::pair<int, CompiledFunction>> prescribed;
  SimTK::Array_<SimTK::Vec3> observations;
  bool started = false;

  explicit Simbody(const MusculoskeletalModel& description)
      : model(description, {.couplers_as_constraints = true, .loops_as_constraints = true}),
        assembler(model.system()) {}
};

AssemblerSolver::~AssemblerSolver() = default;

AssemblerSolver::AssemblerSolver(const MusculoskeletalModel& model, const TrackingProblem& tracking,
                                 double accuracy)
    : simbody_(std::make_unique<Simbody>(model)) {
  Simbody& s = *simbody_;
  if (accuracy > 0.0) s.assembler.setAccuracy(accuracy);
  std::vector<bool> dependent(model.coordinates.size(), false);
  for (const CoordinateCoupler& c : model.couplers) {
    dependent[static_cast<std::size_t>(c.dependent)] = true;
  }
  for (std::size_t c = 0; c < model.coordinates.size(); ++c) {
    const Coordinate& coordinate = model.coordinates[c];
    const int i = static_cast<int>(c);
    if (dependent[c]) continue;
    if (coordinate.locked || coordinate.prescribed) {
      s.assembler.lockQ(s.model.mobilizer(i), s.model.mobilizer_q(i));
      if (coordinate.prescribed && !coordinate.locked) {
        s.prescribed.emplace_back(i, CompiledFunction(*coordinate.prescribed));
      }
    } else if (coordinate.clamped) {
      s.assembler.restrictQ(s.model.mobilizer(i), s.model.mobilizer_q(i), coordinate.range_min,
                            coordinate.range_max);
    }
  }
  auto markers = std::make_unique<SimTK::Markers>();
  SimTK::Array_<SimTK::Markers::MarkerIx> order;
  for (std::size_t i = 0; i < tracking.markers.size(); ++i) {
    const PositionResidual& r = tracking.problem.positions[i];
    order.push_back(markers->addMarker(tracking.markers[i].name, s.model.body(r.link),
                                       to_simtk(r.p_BP), tracking.markers[i].weight));
  }
  markers->defineObservationOrder(order);
  s.markers = markers.release();
  s.assembler.adoptAssemblyGoal(s.markers);
  if (!tracking.coordinates.empty() || !tracking.wires.empty()) {
    s.others = new AssemblerGoal(s.model, tracking);
    s.assembler.adoptAssemblyGoal(s.others);
  }
}

AssemblerSolver::Frame AssemblerSolver::solve(const IkTargets& targets, double time,
                                              std::span<double> q) {
  Simbody& s = *simbody_;
  s.observations.clear();
  for (const Eigen::Vector3d& p : targets.positions) s.observations.push_back(to_simtk(p));
  if (s.others != nullptr) s.others->set_targets(targets);
  SimTK::State state = s.model.default_state();
  for (const auto& [coordinate, function] : s.prescribed) {
    q[static_cast<std::size_t>(coordinate)] = function.value(time);
  }
  Frame frame;
  const bool first = !s.started;
  if (first || !s.prescribed.empty()) {  // locked values are taken from the state
    s.model.set_q(state, q);
    s.assembler.initialize(state);
    s.started = true;
  }
  s.markers->moveAllObservations(s.observations);
  const auto start = std::chrono::steady_clock::now();
  try {
    if (first) {
      s.assembler.assemble();
    } else {
      s.assembler.track(time);
    }
    frame.succeeded = true;
  } catch (const std::exception& error) {
    frame.failure = error.what();
  }
  frame.seconds = seconds_since(start);
  frame.constraint_error = s.assembler.calcCurrentErrorNorm();
  s.assembler.updateFromInternalState(state);
  s.model.get_q(state, q);
  return frame;
}

void AssemblerComparisonOptions::validate() const {
  minimizer.validate();
  const auto reject = [](const char* field, double value, const char* bound) {
    throw std::invalid_argument(
        fmt::format("AssemblerComparisonOptions.{} is {}; expected {}", field, value, bound));
  };
  if (!(accuracy > 0.0 && accuracy < 1.0)) reject("accuracy", accuracy, "more than 0, less than 1");
  if (every < 1) reject("every", every, "1 or more");
  if (!(tolerance >= 0.0)) reject("tolerance", tolerance, "0 or more");
}

namespace {

// Evaluates any q as it is: no coupler is eliminated, so that a solution that breaks one pays or
// gains nothing by our projection.
class PlainCost {
 public:
  PlainCost(MusculoskeletalModel model, const MarkerTrajectories& markers,
            const TrackingProblem& tracking)
      : model_(without_couplers(std::move(model))),
        tree_(compile_tree(model_, {.ignore_locks = true})),
        tracking_(tracking),
        markers_(markers) {}

  TrackingResult operator()(int frame, const RowMatrix& q) const {
    return evaluate_coordinates(model_, tree_, tracking_, markers_, frame, q);
  }

 private:
  static MusculoskeletalModel without_couplers(MusculoskeletalModel model) {
    model.couplers.clear();
    return model;
  }
  const MusculoskeletalModel model_;
  const KinematicTree tree_;
  const TrackingProblem& tracking_;
  const MarkerTrajectories& markers_;
};

}  // namespace

Comparison compare_with_assembler(const MusculoskeletalModel& model, const KinematicTree& tree,
                                  const TrackingProblem& tracking,
                                  const MarkerTrajectories& markers,
                                  const AssemblerComparisonOptions& options) {
  options.validate();
  const int end = options.end_frame < 0 ? markers.frame_count() : options.end_frame;
  const PlainCost plain_cost(model, markers, tracking);
  const auto coordinates = static_cast<Eigen::Index>(model.coordinates.size());
  Comparison result;
  result.angle_rms = result.angle_max = Eigen::VectorXd::Zero(coordinates);

  TrackingOptions ours_options;
  ours_options.minimizer = options.minimizer;
  ours_options.cold_start = options.cold_start;
  ours_options.first_frame = options.first_frame;
  ours_options.end_frame = end;
  ours_options.threads = 1;
  const TrackingResult tracked = track(model, tree, tracking, markers, ours_options);
  AssemblerSolver assembler(model, tracking, options.accuracy);
  AssemblerSolver default_assembler(model, tracking, 0.0);
  result.assembler_default_seconds = 0.0;
  IkTargets targets(tracking.problem);
  std::vector<double> defaults;
  for (const Coordinate& c : model.coordinates) {
    defaults.push_back(c.clamped ? std::clamp(c.default_value, c.range_min, c.range_max)
                                 : c.default_value);
  }
  std::vector<double> assembler_q = defaults, default_assembler_q = defaults;
  RowMatrix row(1, coordinates);
  const double noise = cost_noise(tracking);
  const int total = (end - options.first_frame + options.every - 1) / options.every;

  for (int frame = options.first_frame; frame < end; frame += options.every) {
    set_targets(tracking, markers, frame, targets);
    ComparedFrame out;
    out.frame = frame;
    out.time = markers.time[frame];
    const int index = frame - options.first_frame;
    const FrameResult& solved = tracked.frames[static_cast<std::size_t>(index)];
    out.termination = solved.termination;
    out.seconds = solved.seconds;
    const Eigen::RowVectorXd ours = tracked.coordinates.row(index);
    row.row(0) = ours;
    const TrackingResult our_errors = plain_cost(frame, row);
    out.cost = our_errors.frames[0].cost;
    out.marker_rms = our_errors.frames[0].marker_rms;

    const AssemblerSolver::Frame theirs = assembler.solve(targets, out.time, assembler_q);
    out.assembler_succeeded = theirs.succeeded;
    out.assembler_seconds = theirs.seconds;
    out.assembler_constraint_error = theirs.constraint_error;
    row.row(0) = Eigen::Map<const Eigen::RowVectorXd>(assembler_q.data(), coordinates);
    const TrackingResult their_errors = plain_cost(frame, row);
    out.assembler_cost = their_errors.frames[0].cost;
    out.assembler_marker_rms = their_errors.frames[0].marker_rms;
    result.assembler_default_seconds +=
        default_assembler.solve(targets, out.time, default_assembler_q).seconds;

    const Eigen::VectorXd difference = (ours - row.row(0)).transpose().cwiseAbs();
    result.angle_rms += difference.cwiseAbs2();
    result.angle_max = result.angle_max.cwiseMax(difference);
    const double theirs_or_noise = std::max(out.assembler_cost, noise);
    const double excess = (std::max(out.cost, noise) - theirs_or_noise) / theirs_or_noise;
    if (!(excess <= result.worst_cost_excess)) result.worst_cost_excess = excess;
    out.worse = !(excess <= options.tolerance) || !converged(solved.termination);
    result.worse_frames += out.worse ? 1 : 0;
    result.assembler_failures += theirs.succeeded ? 0 : 1;
    result.seconds += out.seconds;
    result.assembler_seconds += out.assembler_seconds;
    if (result.frames.empty()) {
      std::vector<double> q = tree.default_q;
      read_solution(tree, tracked, index, q);
      result.undetermined = undetermined_coordinates(model, tree, tracking, targets, q);
    }
    result.frames.push_back(out);
    if (options.progress && !options.progress(static_cast<int>(result.frames.size()), total)) {
      result.stopped = true;
      break;
    }
  }
  result.angle_rms =
      (result.angle_rms / std::max<double>(1.0, static_cast<double>(result.frames.size())))
          .cwiseSqrt();
  return result;
}

}  // namespace sinew
