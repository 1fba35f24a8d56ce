#include "data/load_coverage.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "data/foot_motion.h"

namespace sinew {
namespace {

using State = PlateContact::State;

bool carries(const ForcePlatformRecording& plate, double time) {
  const auto sample = static_cast<Eigen::Index>(std::lround(time * plate.rate));
  return sample >= 0 && sample < plate.center.rows() && !std::isnan(plate.center(sample, 0));
}

bool above(const ForcePlatform& platform, const std::vector<Eigen::Vector3d>& foot) {
  return std::any_of(foot.begin(), foot.end(),
                     [&](const auto& p) { return distance_outside(platform, p) < 0.0; });
}

bool wholly_above(const ForcePlatform& platform, const std::vector<Eigen::Vector3d>& foot) {
  return std::all_of(foot.begin(), foot.end(),
                     [&](const auto& p) { return distance_outside(platform, p) < 0.0; });
}

// A foot passes over a platform, or comes down on it and leaves it, within this time [s]; what
// rests there longer and as low as it ever does [m] stands, and a platform that says otherwise is
// dead or is not where the file has it.
constexpr double kRestingTime = 0.2, kRestingHeight = 0.03;

FootLoad load_of(int foot, const std::vector<Eigen::Vector3d>& markers, bool stands, double time,
                 const FootAssignment& assignment,
                 const std::vector<ForcePlatformRecording>& plates) {
  bool unusable = false;
  for (const PlateContact& contact : assignment.contacts) {
    const ForcePlatformRecording& plate = plates[static_cast<std::size_t>(contact.plate)];
    if (time < contact.from || time > contact.to) continue;
    if (contact.state == State::kAssigned && contact.foot == foot) return FootLoad::kMeasured;
    // Somebody else's, or nobody's by the user's word.
    if (contact.state != State::kUnusable) continue;
    unusable |= contact.foot == foot || (stands && above(plate.platform, markers));
  }
  if (unusable) return FootLoad::kUnusable;
  if (markers.empty()) return FootLoad::kUnknown;
  if (!stands) return FootLoad::kNone;
  for (const ForcePlatformRecording& plate : plates) {
    const bool measures = plate.platform.usable() && plate.platform.has_moments;
    if (measures && !carries(plate, time) && wholly_above(plate.platform, markers)) {
      return FootLoad::kNone;
    }
  }
  return FootLoad::kUnmeasured;
}

double lowest(const std::vector<Eigen::Vector3d>& markers) {
  double height = std::numeric_limits<double>::infinity();
  for (const Eigen::Vector3d& p : markers) height = std::min(height, p.y());
  return height;
}

// Takes back that no load acts on a foot which rests on a platform without a force.
void doubt_dead_platforms(const FootMotion& motion, const Eigen::VectorXd& time, std::size_t foot,
                          std::vector<std::vector<FootLoad>>& loads) {
  double floor = std::numeric_limits<double>::infinity();
  for (const auto& markers : motion.markers) floor = std::min(floor, lowest(markers));
  const auto rests = [&](std::size_t f) {
    return motion.stands[f] && loads[f][foot] == FootLoad::kNone &&
           lowest(motion.markers[f]) < floor + kRestingHeight;
  };
  for (std::size_t first = 0, end = 0; first < loads.size(); first = end) {
    end = first + 1;
    if (!rests(first)) continue;
    while (end < loads.size() && rests(end)) ++end;
    const auto at = [&](std::size_t f) { return time[static_cast<Eigen::Index>(f)]; };
    if (at(end - 1) - at(first) < kRestingTime) continue;
    for (std::size_t f = first; f < end; ++f) loads[f][foot] = FootLoad::kUnmeasured;
  }
}

}  // namespace

const char* to_string(FootLoad load) {
  switch (load) {
    case FootLoad::kMeasured:
      return "measured";
    case FootLoad::kNone:
      return "none";
    case FootLoad::kUnmeasured:
      return "stands where no platform measures";
    case FootLoad::kUnusable:
      return "stands on a platform that cannot be used";
    default:
      return "foot not measured";
  }
}

bool LoadCoverage::complete(std::size_t frame) const {
  return std::all_of(loads[frame].begin(), loads[frame].end(), is_complete);
}

int LoadCoverage::complete_frames(std::size_t foot) const {
  return static_cast<int>(std::count_if(
      loads.begin(), loads.end(), [&](const auto& frame) { return is_complete(frame[foot]); }));
}

LoadCoverage load_coverage(const MarkerTrajectories& markers, const FootAssignment& assignment,
                           const std::vector<ForcePlatformRecording>& plates) {
  LoadCoverage coverage;
  coverage.loads.resize(static_cast<std::size_t>(markers.frame_count()));
  for (std::size_t foot = 0; foot < assignment.feet.size(); ++foot) {
    coverage.feet.push_back(assignment.feet[foot].name);
    const FootMotion motion = foot_motion(markers, assignment.feet[foot]);
    for (std::size_t frame = 0; frame < coverage.loads.size(); ++frame) {
      coverage.loads[frame].push_back(
          load_of(static_cast<int>(foot), motion.markers[frame], motion.stands[frame],
                  markers.time[static_cast<Eigen::Index>(frame)], assignment, plates));
    }
    doubt_dead_platforms(motion, markers.time, foot, coverage.loads);
  }
  return coverage;
}

std::string complete_times(const LoadCoverage& coverage, std::size_t foot,
                           const Eigen::VectorXd& time) {
  std::string text;
  const std::size_t frames = coverage.loads.size();
  for (std::size_t f = 0; f < frames; ++f) {
    if (!is_complete(coverage.loads[f][foot])) continue;
    const std::size_t first = f;
    while (f + 1 < frames && is_complete(coverage.loads[f + 1][foot])) ++f;
    text += fmt::format("{}{:.2f} s to {:.2f} s", text.empty() ? "" : ", ",
                        time[static_cast<Eigen::Index>(first)], time[static_cast<Eigen::Index>(f)]);
  }
  return text.empty() ? "none" : text;
}

}  // namespace sinew
