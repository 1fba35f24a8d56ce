// Starts every pair of a list from many poses with every method and tells how often each ends at
// the lowest minimum that any found. Usage: survey LIST [STARTS] [FRAMES]; a line of LIST is
// `name|model|markers|tasks|from|to|walk or static`; tasks, which may be empty, are an IK setup or
// task set, or of a static trial a ScaleTool setup.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <numeric>
#include <random>
#include <sstream>

#include "data/scale_setup.h"
#include "data/tool_setup.h"
#include "data/trc_file.h"
#include "ik/cold_start.h"
#include "ik/marker_placement.h"
#include "ik/tracking.h"
#include "model/osim_file.h"
#include "tests/bench/stopwatch.h"

namespace sinew {
namespace {

constexpr Method kMethods[] = {Method::kGaussNewton, Method::kBfgs, Method::kLbfgs,
                               Method::kLevenbergMarquardt, Method::kArticulated};
constexpr double kSame = 1e-6;

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
    if (cells.size() != 7)
      throw std::runtime_error("a line of the list has not seven cells: " + line);
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

struct Score {
  int lowest_from_default = 0, lowest_from_random = 0, random = 0;
  double worst = 0.0, seconds = 0.0;
};

}  // namespace

int main_of_survey(const std::string& list, int starts, int frames) {
  fmt::print("| pair | unknowns | frames |");
  for (const Method m : kMethods) fmt::print(" {} |", to_string(m));
  fmt::print(" search | search: worst excess | starts | ms a search | ms {} |\n",
             to_string(Method::kGaussNewton));
  fmt::print("|---|---:|---:|{}---:|---:|---:|---:|---:|\n", "---:|---:|---:|---:|---:|");
  for (const Pair& pair : read_list(list)) {
    const MusculoskeletalModel model = read_osim(pair.model);
    const KinematicTree tree = compile_tree(model);
    MarkerFile recording = read_trc(pair.markers);
    std::optional<IkTaskSet> tasks;
    if (!pair.tasks.empty()) {
      tasks =
          pair.still ? read_scale_setup(pair.tasks).placer.task_set : read_ik_task_set(pair.tasks);
    }
    TrackingProblem tracking;
    if (pair.still) {
      MarkerPlacementOptions options;
      options.from = pair.from;
      options.to = pair.to;
      BoundPlacement bound =
          bind_placement(model, tree, recording, tasks ? &*tasks : nullptr, nullptr, options);
      tracking = std::move(bound.tracking);
      recording = std::move(bound.mean);
    } else {
      tracking = bind_recording(model, tree, recording, tasks ? &*tasks : nullptr, nullptr);
    }
    const Eigen::VectorXd& time = recording.markers.time;
    std::vector<int> inside;
    for (int f = 0; f < time.size(); ++f) {
      if (pair.still || (time[f] >= pair.from && time[f] <= pair.to)) inside.push_back(f);
    }
    std::vector<int> chosen;
    const int count = std::min<int>(frames, static_cast<int>(inside.size()));
    for (int i = 0; i < count; ++i) {
      chosen.push_back(
          inside[count == 1 ? 0 : i * (inside.size() - 1) / static_cast<std::size_t>(count - 1)]);
    }
    std::vector<Score> scores(std::size(kMethods) + 1);
    double searches = 0.0, search_starts = 0.0;
    const double noise = cost_noise(tracking);
    for (const int frame : chosen) {
      IkTargets targets(tracking.problem);
      set_targets(tracking, recording.markers, frame, targets);
      std::vector<std::vector<double>> costs(scores.size());
      std::vector<std::string> notes;
      double lowest_pose_cost = INFINITY;
      std::vector<double> lowest_pose;
      std::mt19937_64 random(static_cast<std::uint64_t>(1000 + frame));
      std::vector<std::vector<double>> poses = {tree.default_q};
      for (int s = 0; s < starts; ++s) poses.push_back(random_pose(tree, random));
      for (auto& pose : poses) prescribe(tree, time[frame], pose);
      for (std::size_t m = 0; m < scores.size(); ++m) {
        MinimizerOptions options;
        std::optional<Minimizer> minimizer;
        std::optional<ColdStart> cold;
        if (m < std::size(kMethods)) {
          options.method = kMethods[m];
          options.max_iterations = 500;  // or damping would creep for seconds
          minimizer.emplace(tree, tracking.problem, options);
        } else {
          cold.emplace(tree, tracking.problem, options, ColdStartOptions{});
        }
        for (const auto& pose : poses) {
          std::vector<double> q = pose;
          const double begin = cpu_seconds();
          const double cost = minimizer ? minimizer->minimize(targets, q).final_cost
                                        : cold->minimize(targets, q).final_cost;
          scores[m].seconds += cpu_seconds() - begin;
          if (cold) {
            searches += 1.0;
            search_starts += cold->result().starts;
          }
          costs[m].push_back(joints_are_plausible(tree, q) ? cost : INFINITY);
          if (getenv("SV_POSE") && cost < lowest_pose_cost) {
            lowest_pose_cost = cost;
            lowest_pose = q;
          }
          if (cold)
            notes.push_back(fmt::format("starts {} agreeing {} agreed {} push/cost {:.3g}",
                                        cold->result().starts, cold->result().agreeing,
                                        cold->result().agreed, cold->summary().bound_push / cost));
        }
      }
      if (getenv("SV_POSE"))
        for (std::size_t c = 0; c < model.coordinates.size(); ++c)
          fmt::print(stderr, "    {} {:.3f} [{:.2f} {:.2f}] {}\n", model.coordinates[c].name,
                     lowest_pose[tree.q_of_coordinate[c]], model.coordinates[c].range_min,
                     model.coordinates[c].range_max, model.coordinates[c].clamped);
      double lowest = INFINITY;
      for (const auto& of_method : costs) {
        for (const double cost : of_method) lowest = std::min(lowest, cost);
      }
      for (std::size_t m = 0; m < scores.size(); ++m) {
        for (std::size_t s = 0; s < costs[m].size(); ++s) {
          const double excess = (costs[m][s] - lowest - noise) / std::max(lowest, noise);
          const bool met = excess <= kSame;
          (s == 0 ? scores[m].lowest_from_default : scores[m].lowest_from_random) += met;
          scores[m].random += s > 0;
          scores[m].worst = std::max(scores[m].worst, excess);
          if (m == std::size(kMethods) && !met) {
            fmt::print(stderr, "  {} frame {} start {}: {:.9e} above {:.9e}, {}\n", pair.name,
                       frame, s, costs[m][s], lowest, notes[s]);
          }
        }
      }
    }
    fmt::print("| {} | {} | {} |", pair.name, tree.unknown_count(), chosen.size());
    for (const Score& s : scores) {
      fmt::print(" {}/{}, {:.0f} % |", s.lowest_from_default, chosen.size(),
                 s.random ? 100.0 * s.lowest_from_random / s.random : 100.0);
    }
    fmt::print(" {:.1e} | {:.1f} | {:.2f} | {:.2f} |\n", scores.back().worst,
               search_starts / searches, 1e3 * scores.back().seconds / searches,
               1e3 * scores.front().seconds / searches);
    std::fflush(stdout);
  }
  return 0;
}

}  // namespace sinew

int main(int argc, char** argv) {
  try {
    if (argc < 2) {
      fmt::print(stderr, "usage: survey LIST [STARTS] [FRAMES]\n");
      return 2;
    }
    return sinew::main_of_survey(argv[1], argc > 2 ? std::stoi(argv[2]) : 16,
                                 argc > 3 ? std::stoi(argv[3]) : 5);
  } catch (const std::exception& error) {
    fmt::print(stderr, "survey: {}\n", error.what());
    return 1;
  }
}
