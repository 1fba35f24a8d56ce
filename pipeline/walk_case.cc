#include "pipeline/walk_case.h"

#include <algorithm>
#include <cmath>

#include "data/reference_walk.h"
#include "dynamics/reference_recording.h"
#include "pipeline/walk_tasks.h"

namespace sinew {

WalkCase make_walk_case(WholeBodyOptions::Level level, const MarkerArtifacts& artifacts) {
  WalkCase walk;
  walk.model = whole_body({.level = level});
  walk.tree = compile_tree(walk.model);
  ReferenceRecordingOptions options;
  options.artifacts = artifacts;
  walk.recording = {
      "walk", make_reference_recording(walk.model, reference_walk(), options).markers, {}};
  const IkTaskSet tasks = walk_tasks(walk.model);
  BindingOptions binding;
  binding.wires.use = WireOptions::Use::kAll;  // in the simplified body too, as in the paper
  walk.tracking = bind_recording(walk.model, walk.tree, walk.recording, &tasks, nullptr, binding);
  return walk;
}

std::vector<int> paper_frames(const WalkCase& walk) {
  constexpr double kInterval = 0.2;  // [s]
  constexpr int kSamples = 10;
  const MarkerTrajectories& markers = walk.recording.markers;
  std::vector<int> frames;
  for (int i = 0; i < kSamples; ++i) {
    const int frame = static_cast<int>(std::lround(kInterval * markers.rate * i));
    if (frame < markers.frame_count()) frames.push_back(frame);
  }
  return frames;
}

}  // namespace sinew
