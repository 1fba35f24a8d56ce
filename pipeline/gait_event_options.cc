#include "pipeline/gait_event_options.h"

#include <algorithm>
#include <iterator>

#include "pipeline/laboratory.h"

namespace sinew {
namespace {

// A filter at 7 Hz needs more than twice as many frames a second.
std::vector<GaitEvent> by_kinematics(const MarkerTrajectories& markers, const Eigen::Vector3d& up) {
  KinematicEventOptions options;
  if (markers.rate <= 2.0 * options.cutoff) return {};
  return events_from_kinematics(markers, up, options);
}

}  // namespace

std::vector<GaitEvent> find_gait_events(const C3dFile& file,
                                        const std::vector<ForcePlatformRecording>& plates,
                                        const std::string& sources) {
  const LaboratoryAxes axes = find_axes(axis_evidence(file.markers, file.screen, plates));
  std::vector<GaitEvent> forces, own, kinematics;
  if (sources != "kinematics" && axes.up.known()) {
    forces = events_from_forces(force_signals(plates), &file.markers, axes.up.axis);
  }
  if (sources != "forces" && axes.up.known()) {
    kinematics = by_kinematics(file.markers, axes.up.axis);
  }
  if (sources == "all") own = events_from_file(file.events);
  return merge_events(forces, own, kinematics);
}

std::vector<GaitEvent> find_gait_events(const MarkerTrajectories& markers) {
  const LaboratoryAxes axes = find_axes(axis_evidence(markers, std::nullopt, {}));
  return axes.up.known() ? by_kinematics(markers, axes.up.axis) : std::vector<GaitEvent>();
}

void replace_gait_events(C3dFile& file, const std::vector<GaitEvent>& events) {
  std::erase_if(file.events,
                [](const C3dEvent& event) { return !events_from_file({event}).empty(); });
  std::vector<C3dEvent> stored = c3d_events(events);
  std::move(stored.begin(), stored.end(), std::back_inserter(file.events));
}

}  // namespace sinew
