// The processor's time that inverse kinematics takes for a frame of one trial, for speed.sh: it
// needs nothing that has changed since commit 7b5bbbc, and is built with either side's libraries.

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <exception>
#include <limits>
#include <optional>
#include <string>

#include "data/tool_setup.h"
#include "data/trc_file.h"
#include "ik/tracking.h"
#include "model/osim_file.h"
#include "tests/bench/stopwatch.h"

namespace sinew {
namespace {

// Prints: frames, the least of `rounds` times [us a frame], iterations a frame, mean cost.
void measure_frames(const char* model_path, const char* markers, const std::string& tasks_path,
                    int rounds) {
  const MusculoskeletalModel model = read_osim(model_path);
  const KinematicTree tree = compile_tree(model);
  const MarkerFile recording = read_trc(markers);
  std::optional<IkTaskSet> tasks;
  if (tasks_path != "-") tasks = read_ik_task_set(tasks_path);
  const TrackingProblem tracking =
      bind_recording(model, tree, recording, tasks ? &*tasks : nullptr, nullptr);
  TrackingOptions options;
  options.threads = 1;
  TrackingResult result;
  double seconds = std::numeric_limits<double>::infinity();
  for (int round = 0; round < rounds; ++round) {
    const double start = cpu_seconds();
    result = track(model, tree, tracking, recording.markers, options);
    seconds = std::min(seconds, cpu_seconds() - start);
  }
  const auto frames = static_cast<double>(result.frames.size());
  double iterations = 0.0, cost = 0.0;
  for (const FrameResult& frame : result.frames) {
    iterations += frame.iterations / frames;
    cost += frame.cost / frames;
  }
  fmt::print("{} {:.3f} {:.2f} {:.9g}\n", frames, 1e6 * seconds / frames, iterations, cost);
}

}  // namespace
}  // namespace sinew

int main(int argc, char** argv) {
  if (argc != 5) {
    fmt::print(stderr, "usage: frame_speed MODEL.osim MARKERS.trc TASKS.xml|- ROUNDS\n");
    return 2;
  }
  try {
    sinew::measure_frames(argv[1], argv[2], argv[3], std::max(1, std::atoi(argv[4])));
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}\n", error.what());
    return 1;
  }
  return 0;
}
