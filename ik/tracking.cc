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

#include "ik/continuity.h"
#include "ik/curvature.h"
#include "ik/frame_solver.h"
#include "ik/second_look.h"

namespace sinew {
namespace {

// Frames a piece: long enough that starting it costs little beside solving it, short enough to give
// every core several pieces of a ten-second trial.
constexpr int kPieceLength = 64;

// Two starts of one frame lead to different minima if their costs differ by this fraction.
constexpr double kOtherMinimum = 1e-6;

struct Piece {
  int begin, end;               // frames, relative to the first one
  std::vector<double> start_q;  // solution of frame `begin`
};

std::vector<Piece> cut(int frames) {
  std::vector<Piece> pieces;
  for (int begin = 0; begin < frames; begin += kPieceLength) {
    pieces.push_back({begin, std::min(begin + kPieceLength, frames), {}});
  }
  return pieces;
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

  // Between frames: whether to go on.
  bool ask() {
    if (options_.progress && due()) {
      const std::lock_guard lock(mutex_);
      if (!options_.progress(std::min<int>(done_, total_), total_)) stopped_ = true;
    }
    return !stopped_;
  }

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

// The first frame is solved already.
void solve_piece(const Piece& piece, FrameSolver& solver, Progress& progress,
                 TrackingResult& result) {
  std::vector<double> q = piece.start_q;
  solver.begin_anew();
  if (!progress.frame_done()) return;
  for (int frame = piece.begin + 1; frame < piece.end; ++frame) {
    solver.store(frame, solver.solve(frame, q), q, result);
    if (!progress.frame_done()) return;
  }
}

// Runs body(i) for i in [0, count) on so many threads.
template <typename Body>
void in_parallel(int threads, std::size_t count, const Body& body) {
  if (threads == 0) threads = tbb::info::default_concurrency();
  // Without this TBB gives no more threads than there are cores, and says so on the terminal.
  const tbb::global_control allowed(
      tbb::global_control::max_allowed_parallelism,
      static_cast<std::size_t>(std::max(threads, tbb::info::default_concurrency())));
  tbb::task_arena arena(threads);
  arena.execute([&] { tbb::parallel_for(std::size_t{0}, count, body, tbb::simple_partitioner()); });
}

class Tracker {
 public:
  Tracker(const KinematicTree& tree, const TrackingProblem& tracking,
          const MarkerTrajectories& markers, const TrackingOptions& options, TrackingResult& result)
      : tree_(tree),
        tracking_(tracking),
        markers_(markers),
        options_(options),
        result_(result),
        progress_(options, static_cast<int>(result.frames.size())),
        leader_(tree, tracking, markers, options) {}

  void run() {
    if (result_.frames.empty()) return;
    if (options_.unrelated_frames) {
      solve_unrelated();
    } else {
      solve_pieces();
      join_pieces();
      look_again(
          leader_, tree_, tracking_, [&] { return progress_.ask(); }, result_);
    }
    result_.stopped = progress_.stopped();
  }

 private:
  void solve_unrelated() {
    result_.searched.resize(result_.frames.size());
    in_parallel(options_.threads, result_.frames.size(), [&](std::size_t i) {
      if (progress_.stopped()) return;
      FrameSolver solver(tree_, tracking_, markers_, options_);
      std::vector<double> q = tree_.default_q;
      const int frame = static_cast<int>(i);
      solver.store(frame, solver.solve_cold(frame, q), q, result_);
      result_.searched[i] = {frame, solver.search()};
      progress_.frame_done();
    });
  }

  // The first frame of every piece, each from the one before, then the pieces.
  void solve_pieces() {
    pieces_ = cut(static_cast<int>(result_.frames.size()));
    std::vector<double> q = tree_.default_q;
    for (Piece& piece : pieces_) {
      leader_.begin_anew();
      const bool first = piece.begin == 0;
      const Summary& summary = first ? leader_.solve_cold(0, q) : leader_.solve(piece.begin, q);
      leader_.store(piece.begin, summary, q, result_);
      if (first) result_.searched.push_back({0, leader_.search()});
      piece.start_q = q;
    }
    in_parallel(options_.threads, pieces_.size(), [&](std::size_t i) {
      if (progress_.stopped()) return;
      FrameSolver solver(tree_, tracking_, markers_, options_);
      solve_piece(pieces_[i], solver, progress_, result_);
    });
  }

  // The start of a piece and the end of the one before are independent ways to the same frame.
  void join_pieces() {
    std::vector<double> q = tree_.default_q;
    for (std::size_t i = 1; i < pieces_.size() && progress_.ask(); ++i) {
      const int frame = pieces_[i].begin;
      read_solution(tree_, result_, frame - 1, q);
      leader_.begin_anew();
      const Summary& summary = leader_.solve(frame, q);
      const double cost = summary.final_cost, had = cost_of(frame);
      if (std::abs(cost - had) <= kOtherMinimum * std::min(cost, had) + noise_) continue;
      if (cost < had) {
        leader_.store(frame, summary, q, result_);
      } else {
        q = pieces_[i].start_q;
      }
      if (const Summary* lower = leader_.look_again(frame, q, std::min(cost, had))) {
        leader_.store(frame, *lower, q, result_);
      }
      result_.searched.push_back({frame, leader_.search()});
      sweep(leader_, frame - 1, true, q, result_);
      sweep(leader_, frame + 1, false, q, result_);
    }
  }

  double cost_of(int frame) const { return result_.frames[static_cast<std::size_t>(frame)].cost; }

  const KinematicTree& tree_;
  const TrackingProblem& tracking_;
  const MarkerTrajectories& markers_;
  const TrackingOptions& options_;
  TrackingResult& result_;
  Progress progress_;
  FrameSolver leader_;
  std::vector<Piece> pieces_;
  const double noise_ = cost_noise(tracking_);
};

}  // namespace

void TrackingOptions::validate() const {
  minimizer.validate();
  cold_start.validate();
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
  Tracker(tree, tracking, markers, options, result).run();
  if (!result.stopped && !options.unrelated_frames) {
    make_continuous(model, tree, tracking, markers, options.first_frame, result);
  }
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
    measure_frame(tracking, targets, ws, first_frame + frame, frame, result);
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
