#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>

#include "data/output_file.h"
#include "ik/minimizer.h"
#include "ik/warm_start.h"
#include "pipeline/bench.h"
#include "pipeline/command.h"
#include "pipeline/cpu_time.h"
#include "pipeline/option_checks.h"
#include "pipeline/version.h"
#include "pipeline/walk_case.h"

namespace sinew {
namespace {

using Json = nlohmann::ordered_json;
using Level = WholeBodyOptions::Level;

// What one method did on one recording. Means are over the frames that were solved.
struct WalkRow {
  std::string model;
  int dof = 0, wires = 0, frames = 0;
  bool warm_start = false;
  std::string method, gradient;
  double seconds = kNaN;  // a frame
  double iterations = kNaN, final_cost = kNaN;
  Termination termination = Termination::kNone;  // of the frame that ended worst
  std::vector<double> costs = {};                // frames
};

Json to_json(const WalkRow& row) {
  return {{"model", row.model},
          {"dof", row.dof},
          {"wires", row.wires},
          {"frames", row.frames},
          {"warm_start", row.warm_start},
          {"method", row.method},
          {"gradient", row.gradient},
          {"ms_per_frame", finite_or_null(1e3 * row.seconds)},
          {"iterations", finite_or_null(row.iterations)},
          {"final_cost", finite_or_null(row.final_cost)},
          {"termination", to_string(row.termination)}};
}

// From the best end of a frame to the worst.
int rank(Termination termination) {
  switch (termination) {
    case Termination::kNone:
      return 0;
    case Termination::kGradient:
      return 1;
    case Termination::kCostChange:
      return 2;
    case Termination::kStalled:
      return 3;
    case Termination::kMaxIterations:
      return 4;
    case Termination::kTimeLimit:
      return 5;
    default:
      return 6;
  }
}

// The frames of a recording and where each starts.
struct WalkFrames {
  std::vector<int> frames;
  bool warm_start;  // from the solutions of the frames before, see WarmStart
  std::vector<double> start_q;
};

// From the default pose with the paper's limits and tolerances, from frame to frame with those of
// `sinew ik`; the same for every method.
MinimizerOptions walk_options(Method method, GradientKind gradient, bool warm_start) {
  MinimizerOptions options;
  if (!warm_start) {
    options = paper_options(method);
    // A step without bound from there ends in another minimum, whatever the method.
    options.largest_turn = MinimizerOptions{}.largest_turn;
  }
  options.method = method;
  options.gradient = gradient;
  return options;
}

class WalkBench {
 public:
  WalkBench(const WalkCase& walk, std::string model, double budget)
      : walk_(walk), model_(std::move(model)), budget_(budget), targets_(walk.tracking.problem) {}

  WalkRow run(const WalkFrames& frames, Method method, GradientKind gradient) {
    WalkRow best;
    double total = 0.0;
    for (int repetition = 0; repetition < kMostRepetitions && total < kShortRun; ++repetition) {
      WalkRow row = run_once(frames, method, gradient);
      total += row.seconds * row.frames;
      if (!(best.seconds <= row.seconds)) best = std::move(row);
      if (interrupted()) break;
    }
    return best;
  }

  // Where a recording with warm start begins: the solution of its first frame.
  std::vector<double> solve_first(int frame) {
    std::vector<double> q = walk_.tree.default_q;
    Minimizer minimizer(walk_.tree, walk_.tracking.problem, {});
    set_targets(walk_.tracking, walk_.recording.markers, frame, targets_);
    minimizer.minimize(targets_, q);
    return q;
  }

 private:
  WalkRow run_once(const WalkFrames& frames, Method method, GradientKind gradient) {
    WalkRow row{.model = model_,
                .dof = walk_.tree.unknown_count(),
                .wires = static_cast<int>(walk_.tracking.problem.wires.size()),
                .warm_start = frames.warm_start,
                .method = to_string(method),
                .gradient = to_string(gradient)};
    MinimizerOptions options = walk_options(method, gradient, frames.warm_start);
    const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(budget_);
    options.stop = [end] { return interrupted() || std::chrono::steady_clock::now() > end; };
    Minimizer minimizer(walk_.tree, walk_.tracking.problem, options);
    WarmStart warm_start(walk_.tree, walk_.tracking.problem);
    std::vector<double> q = frames.start_q;
    double seconds = 0.0, iterations = 0.0, cost = 0.0;
    for (const int frame : frames.frames) {
      if (!frames.warm_start) q = frames.start_q;
      set_targets(walk_.tracking, walk_.recording.markers, frame, targets_);
      const double start = cpu_seconds();
      if (frames.warm_start) {
        warm_start.advance(walk_.tree, walk_.tracking.problem, targets_, q);
      }
      const Summary& summary = minimizer.minimize(targets_, q);
      seconds += cpu_seconds() - start;
      iterations += summary.iterations;
      cost += summary.final_cost;
      row.costs.push_back(summary.final_cost);
      ++row.frames;
      if (rank(summary.termination) > rank(row.termination)) row.termination = summary.termination;
      if (interrupted() || std::chrono::steady_clock::now() > end) break;
    }
    const double count = row.frames;
    row.seconds = seconds / count;
    row.iterations = iterations / count;
    row.final_cost = cost / count;
    return row;
  }

  const WalkCase& walk_;
  std::string model_;
  double budget_;
  IkTargets targets_;
};

// What the paper says DGC saves of a method's time, in its text; Table VI is not in it.
const char* paper_saving(const std::string& method, const std::string& model) {
  if (method == "conjugate-gradient") return model == "detailed" ? "95" : ">= 75";
  return method == "bfgs" ? ">= 75" : "";
}

struct BenchWalkCommand {
  std::string methods = "all", json;
  std::vector<std::string> levels = {"simplified", "detailed"};
  double budget = 60.0;
  MarkerArtifacts artifacts{.noise = 0.001, .soft_tissue = 0.01};

  int run() const {
    watch_interrupts();
    const std::vector<Method> chosen = methods_in(names_in(methods));
    std::vector<WalkRow> rows;
    for (const std::string& level : levels) {
      run_level(level, chosen, rows);
      if (interrupted()) {
        fmt::print(stderr, "stopped; no results were written\n");
        return kExitFailed;
      }
    }
    if (!json.empty()) {
      Json report;
      report["environment"] = component_versions();
      report["rows"] = Json::array();
      for (const WalkRow& row : rows) report["rows"].push_back(to_json(row));
      write_file_atomically(json, report.dump(2) + "\n");
    }
    return kExitOk;
  }

  void run_level(const std::string& level, const std::vector<Method>& chosen,
                 std::vector<WalkRow>& rows) const {
    const WalkCase walk =
        make_walk_case(level == "detailed" ? Level::kDetailed : Level::kSimplified, artifacts);
    WalkBench bench(walk, level, budget);
    const std::vector<double> first = bench.solve_first(0);
    std::vector<int> all;
    for (int i = 1; i < walk.recording.markers.frame_count(); ++i) all.push_back(i);
    const WalkFrames sets[] = {{paper_frames(walk), false, walk.tree.default_q},
                               {all, true, first}};
    for (const WalkFrames& frames : sets) {
      print_head(walk, level, frames);
      // The first row of the table's comparison: the lowest cost that any method may find.
      const WalkRow reference = bench.run(frames, Method::kGaussNewton, GradientKind::kDecomposed);
      const WalkRow* jacobian = nullptr;
      for (const Method method : chosen) {
        for (const GradientKind gradient : gradients_for(method)) {
          if (interrupted()) return;
          announce(method, gradient);
          rows.push_back(bench.run(frames, method, gradient));
          const WalkRow& row = rows.back();
          const bool follows = gradient == GradientKind::kDecomposed && rows.size() > 1 &&
                               gradients_for(method).size() == 2;
          jacobian = follows ? &rows[rows.size() - 2] : nullptr;
          print(row, reference, jacobian);
        }
      }
    }
  }

  // On a terminal only; the row overwrites it.
  void announce(Method method, GradientKind gradient) const {
    if (!isatty(STDERR_FILENO)) return;
    fmt::print(stderr, "  {:<24} {:<8} at most {} s ...\r", to_string(method), to_string(gradient),
               budget);
    std::fflush(stderr);
  }

  static void print_head(const WalkCase& walk, const std::string& level, const WalkFrames& frames) {
    fmt::print("{} body, {} degrees of freedom, {} wires; {} frames, {}\n", level,
               walk.tree.unknown_count(), walk.tracking.problem.wires.size(), frames.frames.size(),
               frames.warm_start
                   ? "each from the solutions before it, to the tolerance of sinew ik"
                   : "0.2 s apart, each from the default pose, to the paper's tolerances");
    fmt::print("  {:<24} {:<8} {:>11} {:>6} {:>10} {:>12} {:>8}  {:<15} | {:>10} {:>10}\n",
               "method", "gradient", "ms a frame", "frames", "iterations", "final cost", "excess",
               "ended by", "DGC saves", "paper");
  }

  static void print(const WalkRow& row, const WalkRow& reference, const WalkRow* jacobian) {
    double excess = 0.0;  // largest over the frames
    const std::size_t common = std::min(row.costs.size(), reference.costs.size());
    for (std::size_t i = 0; i < common; ++i) {
      const double each = row.costs[i] / reference.costs[i] - 1.0;
      if (std::abs(each) > std::abs(excess)) excess = each;
    }
    fmt::print("  {:<24} {:<8} {:11.4f} {:6} {:10.1f} {:12.8f} {:8.0e}  {:<15} |", row.method,
               row.gradient, 1e3 * row.seconds, row.frames, row.iterations, row.final_cost, excess,
               to_string(row.termination));
    if (jacobian != nullptr) {
      fmt::print(" {:8.1f} % {:>8}", 100.0 * (1.0 - row.seconds / jacobian->seconds),
                 paper_saving(row.method, row.model));
    }
    fmt::print("\n");
    std::fflush(stdout);
  }
};

}  // namespace

void add_bench_walk(CLI::App& bench, int& exit_code) {
  auto command = std::make_shared<BenchWalkCommand>();
  CLI::App* sub = bench.add_subcommand("walk",
                                       "The whole body walking, as in evaluation 2 of Ayusawa & "
                                       "Nakamura 2012: ten samples each from "
                                       "the default pose, and the whole recording with warm start");
  sub->add_option("--levels", command->levels, "simplified, detailed or both")
      ->delimiter(',')
      ->check(CLI::IsMember({"simplified", "detailed"}))
      ->capture_default_str();
  sub->add_option("--methods", command->methods,
                  "all, or names separated by commas: " + method_names())
      ->capture_default_str();
  sub->add_option("--budget", command->budget, "Cut each run off after this time [s]")
      ->check(more_than_zero())
      ->capture_default_str();
  sub->add_option("--noise", command->artifacts.noise,
                  "Noise of the markers [m], standard deviation")
      ->check(zero_or_more())
      ->capture_default_str();
  sub->add_option("--soft-tissue", command->artifacts.soft_tissue,
                  "How far skin carries markers, as in `sinew example` [m]")
      ->check(zero_or_more())
      ->capture_default_str();
  sub->add_option("--json", command->json, "Write all rows to this file");
  sub->callback([command, &exit_code] { exit_code = command->run(); });
}

}  // namespace sinew
