#include <fmt/format.h>

#include <algorithm>

#include "ik/assembler.h"
#include "tests/bench/bench_tables.h"
#include "tests/bench/stopwatch.h"
#include "tests/ik/methods.h"
#include "tests/ik/published_trials.h"

namespace sinew {
namespace {

TrackingOptions some_frames(const PublishedTrial& trial, int frames) {
  TrackingOptions options = trial.options();
  options.end_frame = options.first_frame + std::min(frames, trial.frame_count());
  return options;
}

struct MethodTimes {
  Method method;
  double seconds = 0.0;
  int frames = 0, converged = 0;
  double iterations = 0.0, evaluations = 0.0, cost = 0.0;  // means over frames
};

MethodTimes time_method(const PublishedTrial& trial, Method method, int frames) {
  TrackingOptions options = some_frames(trial, frames);
  options.minimizer.method = method;
  MethodTimes times{method};
  times.seconds = std::numeric_limits<double>::infinity();
  TrackingResult result;
  for (int round = 0; round < 3; ++round) {
    const double start = cpu_seconds();
    result = track(trial.model, trial.tree, trial.tracking, trial.recording.markers, options);
    const double seconds = cpu_seconds() - start;
    times.seconds = std::min(times.seconds, seconds);
    if (seconds > 2.0) break;
  }
  times.frames = static_cast<int>(result.frames.size());
  const double count = times.frames;
  for (const FrameResult& frame : result.frames) {
    times.iterations += frame.iterations / count;
    times.evaluations += frame.evaluations / count;
    times.converged += converged(frame.termination);
    times.cost += frame.cost / count;
  }
  times.seconds /= count;
  return times;
}

bool missing(const PublishedFiles& files) {
  if (is_present(files)) return false;
  fmt::print("{}: no recordings, {} is missing\n", files.name,
             (kPublishedData / files.model).string());
  return true;
}

}  // namespace

void print_frame_times(int frames) {
  fmt::print(
      "A frame by every method, one thread, each from the frame before (at most {} frames a trial, "
      "2000\niterations a frame)\n\n"
      "| trial                | method                    | ms/frame |   ratio | iterations | "
      "evaluations | converged |    mean cost |\n"
      "| -------------------- | ------------------------- | -------: | ------: | ---------: | "
      "----------: | --------: | -----------: |\n",
      frames);
  for (const PublishedFiles& files : published_files()) {
    if (missing(files)) continue;
    const PublishedTrial trial = read_published(files);
    std::vector<MethodTimes> all;
    double fastest = std::numeric_limits<double>::infinity();
    for (const Method method : kEveryMethod) {
      all.push_back(time_method(trial, method, frames));
      if (all.back().converged == all.back().frames)
        fastest = std::min(fastest, all.back().seconds);
    }
    for (const MethodTimes& t : all) {
      fmt::print(
          "| {:20} | {:25} | {:8.3f} | {:6.1f}x | {:10.1f} | {:11.1f} | {:7.0f} % | {:12.6g} |\n",
          trial.name, to_string(t.method), 1e3 * t.seconds, t.seconds / fastest, t.iterations,
          t.evaluations, 100.0 * t.converged / t.frames, t.cost);
    }
  }
  fmt::print(
      "\nThe ratio is to the fastest method that converged at every frame. A frame that stops at "
      "the\n"
      "most iterations has not converged.\n\n");
}

namespace {

// Frames of a trial one after the other, the first from the default pose; solve(frame, targets, q)
// solves one. Returns the seconds inside solve a frame, and the costs.
template <typename Solve>
double time_frames(const PublishedTrial& trial, int frames, std::vector<double> q,
                   const Solve& solve, RowMatrix& coordinates) {
  IkTargets targets(trial.tracking.problem);
  coordinates.resize(frames, static_cast<Eigen::Index>(trial.model.coordinates.size()));
  double seconds = 0.0;
  for (int frame = 0; frame < frames; ++frame) {
    set_targets(trial.tracking, trial.recording.markers, trial.first_frame + frame, targets);
    const double start = cpu_seconds();
    solve(frame, targets, q);
    seconds += cpu_seconds() - start;
    // Without quaternions q stands in the order of the coordinates.
    coordinates.row(frame) = Eigen::Map<const Eigen::RowVectorXd>(q.data(), coordinates.cols());
  }
  return seconds / frames;
}

struct AssemblerTimes {
  double seconds = 0.0;
  RowMatrix coordinates;
};

AssemblerTimes time_assembler(const PublishedTrial& trial, int frames, double accuracy) {
  AssemblerTimes times;
  AssemblerSolver solver(trial.model, trial.tracking, accuracy);
  std::vector<double> q;
  for (const Coordinate& c : trial.model.coordinates) q.push_back(c.default_value);
  int failures = 0;
  times.seconds = time_frames(
      trial, frames, q,
      [&](int frame, const IkTargets& targets, std::vector<double>& at) {
        const double time = trial.recording.markers.time[trial.first_frame + frame];
        failures += !solver.solve(targets, time, at).succeeded;
      },
      times.coordinates);
  if (failures > 0) fmt::print("{}: the Assembler failed at {} frames\n", trial.name, failures);
  return times;
}

// The largest (ours − theirs)/theirs over the frames.
double worst_excess(const PublishedTrial& trial, const RowMatrix& ours, const RowMatrix& theirs) {
  const auto costs = [&](const RowMatrix& q) {
    return evaluate_coordinates(trial.model, trial.tree, trial.tracking, trial.recording.markers,
                                trial.first_frame, q)
        .frames;
  };
  const std::vector<FrameResult> a = costs(ours), b = costs(theirs);
  double worst = -1.0;
  for (std::size_t i = 0; i < a.size(); ++i) worst = std::max(worst, a[i].cost / b[i].cost - 1.0);
  return worst;
}

void print_assembler_row(const PublishedTrial& trial, int frames) {
  Minimizer minimizer(trial.tree, trial.tracking.problem, {});
  RowMatrix ours;
  double seconds = std::numeric_limits<double>::infinity();
  for (int round = 0; round < 5; ++round) {
    seconds = std::min(seconds, time_frames(
                                    trial, frames, trial.tree.default_q,
                                    [&](int, const IkTargets& targets, std::vector<double>& q) {
                                      minimizer.minimize(targets, q);
                                    },
                                    ours));
  }
  fmt::print("| {:20} | {:8.3f} |", trial.name, 1e3 * seconds);
  for (const double accuracy : {1e-7, 0.0}) {
    const AssemblerTimes theirs = time_assembler(trial, frames, accuracy);
    fmt::print(" {:8.3f} | {:7.1f}x | {:10.2e} |", 1e3 * theirs.seconds, theirs.seconds / seconds,
               worst_excess(trial, ours, theirs.coordinates));
  }
  fmt::print("\n");
}

}  // namespace

void print_assembler_times(int frames) {
  fmt::print(
      "A frame by Gauss-Newton and by Simbody's Assembler, one thread, each from its own frame "
      "before (at\nmost {} frames a trial)\n\n"
      "|                      |   Sinew  | {:^34} | {:^34} |\n"
      "| trial                | ms/frame | ms/frame |    ratio | our excess | ms/frame |    ratio "
      "| "
      "our excess |\n"
      "| -------------------- | -------: | -------: | -------: | ---------: | -------: | -------: "
      "| "
      "---------: |\n",
      frames, "Assembler, accuracy 1e-7", "Assembler, its default 1e-3");
  for (const PublishedFiles& files : published_files()) {
    if (missing(files)) continue;
    const PublishedTrial trial = read_published(files);
    print_assembler_row(trial, std::min(frames, trial.frame_count()));
  }
  fmt::print(
      "\nSame markers, weights, locks and clamps; couplers are constraints there and eliminated "
      "here. Excess:\nthe largest (our cost - its)/its over the frames; negative: ours is lower at "
      "every frame.\n\n");
}

}  // namespace sinew
