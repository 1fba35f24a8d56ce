#include "ik/tracking.h"

#include <fmt/format.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <mutex>
#include <stdexcept>

#include "ik/curvature.h"
#include "ik/warm_start.h"

namespace sinew {
namespace {

// Frames a piece: long enough that starting it costs little beside solving it, short enough to give
// every core several pieces of a ten-second trial.
constexpr int kPieceLength = 64;

// A piece is solved again if the piece before it leads to a start that is better by this fraction:
// another minimum, not rounding.
constexpr double kBetterStart = 1e-6;

struct Piece {
  int begin, end;               // frames, relative to the first one
  std::vector<double> start_q;  // solution of frame `begin`
  double start_cost = kNaN;
};

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

// Distances of tracked markers at the poses of `ws`, their summary, and the wires. `frame_index` is
// the recording's, `index` the result's.
void measure(const TrackingProblem& tracking, const IkTargets& targets,
             const KinematicWorkspace& ws, int frame_index, int index, TrackingResult& result) {
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

// One worker's solver with all that it needs for a frame.
class FrameSolver {
 public:
  FrameSolver(const KinematicTree& tree, const TrackingProblem& tracking,
              const MarkerTrajectories& markers, const TrackingOptions& options)
      : tree_(tree),
        tracking_(tracking),
        markers_(markers),
        first_(options.first_frame),
        minimizer_(tree, tracking.problem, options.minimizer),
        targets_(tracking.problem),
        warm_start_(tree) {}

  // The next frame is not the one after the last.
  void begin_anew() { warm_start_.reset(); }

  const Summary& solve(int frame, std::vector<double>& q) {
    set_targets(tracking_, markers_, first_ + frame, targets_);
    warm_start_.advance(tree_, tracking_.problem, targets_, q);
    prescribe(tree_, markers_.time[first_ + frame], q);
    return minimizer_.minimize(targets_, q);
  }

  void store(int frame, const Summary& summary, const std::vector<double>& q,
             TrackingResult& result) {
    FrameResult& out = result.frames[static_cast<std::size_t>(frame)];
    out.termination = summary.termination;
    out.iterations = summary.iterations;
    out.evaluations = summary.evaluations;
    out.cost = summary.final_cost;
    out.rows = summary.rows;
    read_coordinates(tree_, q, result.coordinates.row(frame));
    measure(tracking_, targets_, minimizer_.workspace(), first_ + frame, frame, result);
  }

 private:
  const KinematicTree& tree_;
  const TrackingProblem& tracking_;
  const MarkerTrajectories& markers_;
  int first_;
  Minimizer minimizer_;
  IkTargets targets_;
  WarmStart warm_start_;
};

std::vector<Piece> cut(int frames) {
  std::vector<Piece> pieces;
  for (int begin = 0; begin < frames; begin += kPieceLength) {
    pieces.push_back({begin, std::min(begin + kPieceLength, frames), {}, kNaN});
  }
  return pieces;
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

// Reports progress from any thread, one at a time, and remembers a request to stop.
class Progress {
 public:
  Progress(const TrackingOptions& options, int total) : options_(options), total_(total) {}
  bool frame_done() {
    const int done = ++done_;
    // Every 16 frames is a few milliseconds apart on most models.
    if (options_.progress && (done % 16 == 0 || done == total_ || due())) {
      const std::lock_guard lock(mutex_);
      if (!options_.progress(std::min(done, total_), total_)) stopped_ = true;
    }
    return !stopped_;
  }
  bool stopped() const { return stopped_; }

 private:
  using Clock = std::chrono::steady_clock;

  // Ten times a second where frames take longer: true for one thread of all that ask.
  bool due() {
    const Clock::rep now = Clock::now().time_since_epoch().count();
    Clock::rep last = last_;
    return now - last > Clock::duration(std::chrono::milliseconds(100)).count() &&
           last_.compare_exchange_strong(last, now);
  }

  const TrackingOptions& options_;
  const int total_;
  std::atomic<Clock::rep> last_ = Clock::now().time_since_epoch().count();
  std::atomic<int> done_ = 0;
  std::atomic<bool> stopped_ = false;
  std::mutex mutex_;
};

void solve_piece(const Piece& piece, FrameSolver& solver, Progress& progress,
                 TrackingResult& result) {
  std::vector<double> q = piece.start_q;
  solver.begin_anew();
  for (int frame = piece.begin; frame < piece.end; ++frame) {
    solver.store(frame, solver.solve(frame, q), q, result);
    if (!progress.frame_done()) return;
  }
}

}  // namespace

void TrackingOptions::validate() const {
  minimizer.validate();
  if (threads < 0) {
    throw std::invalid_argument(
        fmt::format("TrackingOptions.threads is {}; expected 0 or more", threads));
  }
}

TrackingResult track(const MusculoskeletalModel& model, const KinematicTree& tree,
                     const TrackingProblem& tracking, const MarkerTrajectories& markers,
                     const TrackingOptions& options) {
  options.validate();
  const int end = options.end_frame < 0 ? markers.frame_count() : options.end_frame;
  const int frames = end - options.first_frame;
  if (frames < 0 || options.first_frame < 0 || end > markers.frame_count()) {
    throw std::invalid_argument(fmt::format("frames {} to {} are not in a recording of {} frames",
                                            options.first_frame, end, markers.frame_count()));
  }
  const auto start = std::chrono::steady_clock::now();
  TrackingResult result = empty_result(model, tracking, markers, options.first_frame, frames);
  std::vector<Piece> pieces = cut(frames);
  Progress progress(options, frames);

  // The first frame of every piece, each from the one before.
  FrameSolver leader(tree, tracking, markers, options);
  std::vector<double> q = tree.default_q;
  for (Piece& piece : pieces) {
    leader.begin_anew();
    piece.start_cost = leader.solve(piece.begin, q).final_cost;
    piece.start_q = q;
  }

  const int threads = options.threads == 0 ? tbb::info::default_concurrency() : options.threads;
  // Without this TBB gives no more threads than there are cores, and says so on the terminal.
  const tbb::global_control allowed(
      tbb::global_control::max_allowed_parallelism,
      static_cast<std::size_t>(std::max(threads, tbb::info::default_concurrency())));
  tbb::task_arena arena(threads);
  arena.execute([&] {
    tbb::parallel_for(
        std::size_t{0}, pieces.size(),
        [&](std::size_t i) {
          if (progress.stopped()) return;
          FrameSolver solver(tree, tracking, markers, options);
          solve_piece(pieces[i], solver, progress, result);
        },
        tbb::simple_partitioner());
  });

  // Where the end of one piece leads to a better start of the next, solve that one again.
  for (std::size_t i = 1; i < pieces.size() && !progress.stopped(); ++i) {
    for (std::size_t c = 0; c < tree.q_of_coordinate.size(); ++c) {
      q[static_cast<std::size_t>(tree.q_of_coordinate[c])] =
          result.coordinates(pieces[i].begin - 1, static_cast<Eigen::Index>(c));
    }
    leader.begin_anew();
    const double cost = leader.solve(pieces[i].begin, q).final_cost;
    if (cost < pieces[i].start_cost * (1.0 - kBetterStart)) {
      pieces[i].start_q = q;
      solve_piece(pieces[i], leader, progress, result);
    }
  }
  result.stopped = progress.stopped();
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
  result.seconds = elapsed.count();
  return result;
}

TrackingResult evaluate_coordinates(const MusculoskeletalModel& model, const KinematicTree& tree,
                                    const TrackingProblem& tracking,
                                    const MarkerTrajectories& markers, int first_frame,
                                    const RowMatrix& coordinates) {
  const int frames = static_cast<int>(coordinates.rows());
  TrackingResult result = empty_result(model, tracking, markers, first_frame, frames);
  result.coordinates = coordinates;
  KinematicWorkspace ws(tree);
  IkTargets targets(tracking.problem);
  for (int frame = 0; frame < frames; ++frame) {
    for (std::size_t c = 0; c < tree.q_of_coordinate.size(); ++c) {
      ws.q[static_cast<std::size_t>(tree.q_of_coordinate[c])] =
          coordinates(frame, static_cast<Eigen::Index>(c));
    }
    update_poses(tree, ws);
    set_targets(tracking, markers, first_frame + frame, targets);
    FrameResult& out = result.frames[static_cast<std::size_t>(frame)];
    out.cost = cost(tree, tracking.problem, targets, ws);
    measure(tracking, targets, ws, first_frame + frame, frame, result);
  }
  return result;
}

std::vector<int> undetermined_coordinates(const MusculoskeletalModel& model,
                                          const KinematicTree& tree,
                                          const TrackingProblem& tracking, const IkTargets& targets,
                                          std::span<const double> q) {
  constexpr double kNullEigenvalue = 1e-10;  // of the largest: rounding of a sum of squares
  constexpr double kNullEntry = 1e-3;
  KinematicWorkspace ws(tree);
  std::copy(q.begin(), q.end(), ws.q.begin());
  update_kinematics(tree, ws);
  CostCurvature curvature(tree, tracking.problem);
  Eigen::MatrixXd H(tree.unknown_count(), tree.unknown_count());
  curvature.update(tree, tracking.problem, targets, ws);
  curvature.matrix(tracking.problem, targets, ws, H);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(H);
  std::vector<bool> free_v(static_cast<std::size_t>(tree.v_count()), false);
  for (Eigen::Index e = 0; e < H.rows(); ++e) {
    if (solver.eigenvalues()[e] > kNullEigenvalue * solver.eigenvalues()[H.rows() - 1]) continue;
    for (Eigen::Index x = 0; x < H.rows(); ++x) {
      if (std::abs(solver.eigenvectors()(x, e)) > kNullEntry) {
        free_v[static_cast<std::size_t>(tree.unknown_v[static_cast<std::size_t>(x)])] = true;
      }
    }
  }
  for (const KinematicTree::Coupling& c : tree.couplings) {
    if (free_v[static_cast<std::size_t>(c.independent_v)]) {
      free_v[static_cast<std::size_t>(c.dependent_v)] = true;
    }
  }
  std::vector<int> result;
  for (std::size_t c = 0; c < model.coordinates.size(); ++c) {
    if (free_v[static_cast<std::size_t>(tree.v_of_coordinate[c])]) {
      result.push_back(static_cast<int>(c));
    }
  }
  return result;
}

}  // namespace sinew
