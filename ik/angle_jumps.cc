#include "ik/angle_jumps.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "model/limb_paths.h"

namespace sinew {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr double kLargestStep = 30.0 * kDegree;
constexpr double kLargestSpeed = 1000.0 * kDegree;  // [rad/s]

struct Jumps {
  int count = 0;
  double largest = 0.0;         // [rad]
  Eigen::Index largest_at = 0;  // the frame before it
};

Jumps find_jumps(const Eigen::VectorXd& time, const RowMatrix& coordinates, Eigen::Index c) {
  Jumps jumps;
  for (Eigen::Index frame = 0; frame + 1 < coordinates.rows(); ++frame) {
    const double step = std::abs(coordinates(frame + 1, c) - coordinates(frame, c));
    if (!(step > jump_limit(time[frame + 1] - time[frame]))) continue;
    ++jumps.count;
    if (step <= jumps.largest) continue;
    jumps.largest = step;
    jumps.largest_at = frame;
  }
  return jumps;
}

VerdictReason make_reason(const MusculoskeletalModel& model, const Eigen::VectorXd& time,
                          std::size_t c, const Jumps& jumps) {
  const Coordinate& coordinate = model.coordinates[c];
  const Joint& joint = model.joints[static_cast<std::size_t>(coordinate.joint)];
  const double from = time[jumps.largest_at], to = time[jumps.largest_at + 1];
  VerdictReason reason;
  reason.code = "jump";
  reason.weight =
      joint.parent == 0 ? VerdictReason::Weight::kUnusable : VerdictReason::Weight::kRemark;
  reason.text = fmt::format("{} steps by {:.0f}° between {:.6g} s and {:.6g} s", coordinate.name,
                            jumps.largest / kDegree, from, to);
  if (jumps.count > 1) {
    reason.text += fmt::format(", the largest of {} such steps", jumps.count);
  }
  reason.figure = jumps.largest / kDegree;
  reason.limit = jump_limit(to - from) / kDegree;
  reason.unit = "°";
  reason.source = "Sinew";
  reason.remedy =
      "look at the markers there (marker_errors.csv of `sinew run`); a joint turned by 90° about "
      "its "
      "second axis steps too, and its other angles are to be read with care";
  reason.angles = {coordinate.name};
  for (const int each : torques_with(model, joint.child)) {
    reason.torques.push_back(model.coordinates[static_cast<std::size_t>(each)].name);
  }
  return reason;
}

}  // namespace

double jump_limit(double seconds_between_frames) {
  return std::clamp(kLargestSpeed * seconds_between_frames, kLargestStep, std::numbers::pi);
}

std::vector<VerdictReason> angle_jumps(const MusculoskeletalModel& model,
                                       const Eigen::VectorXd& time, const RowMatrix& coordinates) {
  std::vector<VerdictReason> reasons;
  for (std::size_t c = 0; c < model.coordinates.size(); ++c) {
    if (model.coordinates[c].motion != Coordinate::Motion::kRotational) continue;
    const Jumps jumps = find_jumps(time, coordinates, static_cast<Eigen::Index>(c));
    if (jumps.count > 0) reasons.push_back(make_reason(model, time, c, jumps));
  }
  return reasons;
}

std::vector<VerdictReason> angle_jumps(const MusculoskeletalModel& model,
                                       const TrackingResult& result) {
  return angle_jumps(model, result.time, result.coordinates);
}

}  // namespace sinew
