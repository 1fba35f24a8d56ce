#include <fmt/format.h>

#include <algorithm>

#include "ik/assembler.h"
#include "tests/bench/bench_tables.h"
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
  double iterations = 0.0, evaluations = 0.0, converged = 0.0, cost = 0.0;  // means over frames
};

MethodTimes time_method(const PublishedTrial& trial, Method method, int frames) {
  TrackingOptions options = some_frames(trial, frames);
  options.minimizer.method = method;
  MethodTimes times{method};
  times.seconds = std::numeric_limits<double>::infinity();
  TrackingResult result;
  for (int round = 0; round < 3; ++round) {
    result = track(trial.model, trial.tree, trial.tracking, trial.recording.markers, options);
    times.seconds = std::min(times.seconds, result.seconds);
    if (result.seconds > 5.0) break;
  }
  const auto count = static_cast<double>(result.frames.size());
  for (const FrameResult& frame : result.frames) {
    times.iterations += frame.iterations / count;
    times.evaluations += frame.evaluations / count;
    times.converged += (converged(frame.termination) ? 1.0 : 0.0) / count;
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
      if (all.back().converged == 1.0) fastest = std::min(fastest, all.back().seconds);
    }
    for (const MethodTimes& t : all) {
      fmt::print(
          "| {:20} | {:25} | {:8.3f} | {:6.1f}x | {:10.1f} | {:11.1f} | {:7.0f} % | {:12.6g} |\n",
          trial.name, to_string(t.method), 1e3 * t.seconds, t.seconds / fastest, t.iterations,
          t.evaluations, 100.0 * t.converged, t.cost);
    }
  }
  fmt::print(
      "\nThe ratio is to the fastest method that converged at every frame. A frame that stops at "
      "the\n"
      "most iterations has not converged.\n\n");
}

void print_assembler_times(int frames) {
  fmt::print(
      "A frame by Gauss-Newton and by Simbody's Assembler, one thread, each from its own frame "
      "before (at\nmost {} frames a trial)\n\n"
      "| trial                | Sinew ms | Assembler, 1e-7 |   ratio | Assembler, default |   "
      "ratio | "
      "our cost over its |\n"
      "| -------------------- | -------: | --------------: | ------: | -----------------: | "
      "------: | "
      "----------------: |\n",
      frames);
  for (const PublishedFiles& files : published_files()) {
    if (missing(files)) continue;
    const PublishedTrial trial = read_published(files);
    ComparisonOptions options;
    options.first_frame = trial.first_frame;
    options.end_frame = trial.first_frame + std::min(frames, trial.frame_count());
    const Comparison c = compare_with_assembler(trial.model, trial.tree, trial.tracking,
                                                trial.recording.markers, options);
    const double per_frame = 1e3 / static_cast<double>(c.frames.size());
    fmt::print("| {:20} | {:8.3f} | {:15.3f} | {:6.1f}x | {:18.3f} | {:6.1f}x | {:17.2e} |\n",
               trial.name, per_frame * c.seconds, per_frame * c.assembler_seconds,
               c.assembler_seconds / c.seconds, per_frame * c.assembler_default_seconds,
               c.assembler_default_seconds / c.seconds, c.worst_cost_excess);
  }
  fmt::print(
      "\nSame markers, weights, locks and clamps. Cost: the largest (ours - its)/its over the "
      "frames, with\nits accuracy 1e-7; negative: ours is lower everywhere.\n\n");
}

}  // namespace sinew
