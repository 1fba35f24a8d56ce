// Starts every pair of a list from many poses with every method and tells how often each ends at
// the lowest minimum that any found. Usage: survey LIST [STARTS] [FRAMES]; a line of LIST is
// `name|model|markers|tasks|from|to|walk or static`; tasks, which may be empty, are an IK setup or
// task set, or of a static trial a ScaleTool setup.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <optional>
#include <random>
#include <sstream>

#include "data/scale_setup.h"
#include "data/tool_setup.h"
#include "data/trc_file.h"
#include "ik/cold_start.h"
#include "ik/marker_placement.h"
#include "ik/minimizer.h"
#include "ik/tracking.h"
#include "model/osim_file.h"
#include "tests/bench/stopwatch.h"

namespace sinew {
namespace {

constexpr Method kMethods[] = {Method::kGaussNewton, Method::kBfgs, Method::kLbfgs,
                               Method::kLevenbergMarquardt, Method::kArticulated};
constexpr double kSame = 1e-6;
constexpr double kMostSeconds = 60.0;  // of one pair, after which no further frame is begun

struct Pair {
  std::string name, model, markers, tasks;
  double from = 0.0, to = 1e9;
  bool still = false;
};

std::vector<Pair> read_list(const std::string& path) {
  std::ifstream file(path);
  std::vector<Pair> pairs;
  for (std::string line; std::getline(file, line);) {
    if (line.empty() || line[0] == '#') continue;
    std::vector<std::string> cells;
    std::stringstream stream(line);
    for (std::string cell; std::getline(stream, cell, '|');) cells.push_back(cell);
    if (cells.size() != 7) {
      throw std::runtime_error("a line of the list has not seven cells: " + line);
    }
    Pair pair{cells[0], cells[1], cells[2], cells[3]};
    if (!cells[4].empty()) pair.from = std::stod(cells[4]);
    if (!cells[5].empty()) pair.to = std::stod(cells[5]);
    pair.still = cells[6] == "static";
    pairs.push_back(pair);
  }
  return pairs;
}

// Entries of q of unknowns drawn within their ranges, without one within half a turn or half a
// metre of the default.
std::vector<double> random_pose(const KinematicTree& tree, std::mt19937_64& random) {
  std::vector<double> q = tree.default_q;
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  for (std::size_t x = 0; x < tree.unknown_v.size(); ++x) {
    const int entry = tree.q_of_v[static_cast<std::size_t>(tree.unknown_v[x])];
    if (entry < 0) continue;
    double lower = tree.lower[x], upper = tree.upper[x];
    double& value = q[static_cast<std::size_t>(entry)];
    if (!std::isfinite(lower)) lower = value - 0.5;
    if (!std::isfinite(upper)) upper = value + 0.5;
    value = lower + unit(random) * (upper - lower);
  }
  return q;
}

// What is asked for: the model, the recording's frames, or a static trial's mean.
struct Case {
  explicit Case(const Pair& pair) : model(read_osim(pair.model)), tree(compile_tree(model)) {
    MarkerFile recording = read_trc(pair.markers);
    std::optional<IkTaskSet> tasks;
    if (!pair.tasks.empty()) {
      tasks =
          pair.still ? read_scale_setup(pair.tasks).placer.task_set : read_ik_task_set(pair.tasks);
    }
    const IkTaskSet* given = tasks ? &*tasks : nullptr;
    if (pair.still) {
      MarkerPlacementOptions options;
      options.from = pair.from;
      options.to = pair.to;
      BoundPlacement bound = bind_placement(model, tree, recording, given, nullptr, options);
      tracking = std::move(bound.tracking);
      recording = std::move(bound.mean);
    } else {
      tracking = bind_recording(model, tree, recording, given, nullptr);
    }
    markers = std::move(recording.markers);
    for (int f = 0; f < markers.frame_count(); ++f) {
      if (pair.still || (markers.time[f] >= pair.from && markers.time[f] <= pair.to)) {
        frames.push_back(f);
      }
    }
  }

  // So many of the frames, evenly.
  std::vector<int> spread(int count) const {
    count = std::min(count, static_cast<int>(frames.size()));
    std::vector<int> chosen;
    for (int i = 0; i < count; ++i) {
      const std::size_t last = frames.size() - 1;
      chosen.push_back(frames[count == 1 ? 0 : i * last / static_cast<std::size_t>(count - 1)]);
    }
    return chosen;
  }

  MusculoskeletalModel model;
  KinematicTree tree;
  TrackingProblem tracking;
  MarkerTrajectories markers;
  std::vector<int> frames;
};

struct Score {
  int lowest_from_default = 0, lowest_from_random = 0, random = 0;
  double worst = 0.0, seconds = 0.0;
};

struct Tally {
  std::vector<Score> scores = std::vector<Score>(std::size(kMethods) + 1);  // the last: the search
  int frames = 0;
  double searches = 0.0, starts = 0.0;
};

// Costs that one method, or the search, ends at from every pose; infinite where a pose does not
// count.
std::vector<double> descend(const Case& asked, const IkTargets& targets, std::size_t method,
                            const std::vector<std::vector<double>>& poses, Tally& tally) {
  MinimizerOptions options;
  std::optional<Minimizer> minimizer;
  std::optional<ColdStart> cold;
  if (method < std::size(kMethods)) {
    options.method = kMethods[method];
    options.max_iterations = 500;  // or damping would creep for seconds
    minimizer.emplace(asked.tree, asked.tracking.problem, options);
  } else {
    cold.emplace(asked.tree, asked.tracking.problem, options, ColdStartOptions{});
  }
  std::vector<double> costs;
  for (const std::vector<double>& pose : poses) {
    std::vector<double> q = pose;
    const double begin = cpu_seconds();
    const Summary& summary =
        minimizer ? minimizer->minimize(targets, q) : cold->minimize(targets, q);
    tally.scores[method].seconds += cpu_seconds() - begin;
    costs.push_back(joints_are_plausible(asked.tree, q) ? summary.final_cost : INFINITY);
    if (!cold) continue;
    tally.searches += 1.0;
    tally.starts += cold->result().starts;
  }
  return costs;
}

void survey_frame(const Pair& pair, const Case& asked, int frame, int starts, Tally& tally) {
  IkTargets targets(asked.tracking.problem);
  set_targets(asked.tracking, asked.markers, frame, targets);
  std::mt19937_64 random(static_cast<std::uint64_t>(1000 + frame));
  std::vector<std::vector<double>> poses = {asked.tree.default_q};
  for (int s = 0; s < starts; ++s) poses.push_back(random_pose(asked.tree, random));
  for (auto& pose : poses) prescribe(asked.tree, asked.markers.time[frame], pose);
  std::vector<std::vector<double>> costs;
  double lowest = INFINITY;
  for (std::size_t m = 0; m < tally.scores.size(); ++m) {
    costs.push_back(descend(asked, targets, m, poses, tally));
    for (const double cost : costs.back()) lowest = std::min(lowest, cost);
  }
  const double noise = cost_noise(asked.tracking);
  for (std::size_t m = 0; m < costs.size(); ++m) {
    Score& score = tally.scores[m];
    for (std::size_t s = 0; s < poses.size(); ++s) {
      const double excess = (costs[m][s] - lowest - noise) / std::max(lowest, noise);
      const bool met = excess <= kSame;
      (s == 0 ? score.lowest_from_default : score.lowest_from_random) += met;
      score.random += s > 0;
      score.worst = std::max(score.worst, excess);
      if (m == std::size(kMethods) && !met) {
        fmt::print(stderr, "{}, frame {}, {}: the search ends at {:.9e}, {:.9e} was found\n",
                   pair.name, frame, s == 0 ? "default pose" : fmt::format("random pose {}", s),
                   costs[m][s], lowest);
      }
    }
  }
  ++tally.frames;
}

void print_row(const Pair& pair, const Case& asked, const Tally& tally) {
  fmt::print("| {} | {} | {} |", pair.name, asked.tree.unknown_count(), tally.frames);
  for (const Score& s : tally.scores) {
    fmt::print(" {}/{}, {:.0f} % |", s.lowest_from_default, tally.frames,
               s.random ? 100.0 * s.lowest_from_random / s.random : 100.0);
  }
  fmt::print(" {:.1e} | {:.1f} | {:.2f} | {:.2f} |\n", tally.scores.back().worst,
             tally.starts / tally.searches, 1e3 * tally.scores.back().seconds / tally.searches,
             1e3 * tally.scores.front().seconds / tally.searches);
  std::fflush(stdout);
}

void survey(const std::string& list, int starts, int frames) {
  fmt::print("| pair | unknowns | frames |");
  for (const Method m : kMethods) fmt::print(" {} |", to_string(m));
  fmt::print(" search | search: worst excess | starts | ms a search | ms {} |\n",
             to_string(Method::kGaussNewton));
  fmt::print("|---|---:|---:|{}---:|---:|---:|---:|---:|\n", "---:|---:|---:|---:|---:|");
  for (const Pair& pair : read_list(list)) {
    const Case asked(pair);
    Tally tally;
    const double begin = cpu_seconds();
    for (const int frame : asked.spread(frames)) {
      survey_frame(pair, asked, frame, starts, tally);
      if (cpu_seconds() - begin > kMostSeconds) break;
    }
    print_row(pair, asked, tally);
  }
}

}  // namespace
}  // namespace sinew

int main(int argc, char** argv) {
  try {
    if (argc < 2) {
      fmt::print(stderr, "usage: survey LIST [STARTS] [FRAMES]\n");
      return 2;
    }
    sinew::survey(argv[1], argc > 2 ? std::stoi(argv[2]) : 16, argc > 3 ? std::stoi(argv[3]) : 5);
  } catch (const std::exception& error) {
    fmt::print(stderr, "survey: {}\n", error.what());
    return 1;
  }
  return 0;
}
