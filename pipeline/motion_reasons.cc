#include "pipeline/motion_reasons.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "model/limb_paths.h"
#include "pipeline/verdict_reasons.h"

namespace sinew {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr double kTurns = 1e-4;          // [rad] less is a joint that nobody measured
constexpr double kTravels = 0.3;         // [m] a step and more
constexpr double kShiftedBeyond = 0.05;  // [m]
constexpr double kMostFrames = 0.5;

bool turns(const Coordinate& c) { return c.motion == Coordinate::Motion::kRotational; }

double range_of(const CoordinateTable& motion, std::size_t c) {
  const auto q = motion.q.col(static_cast<Eigen::Index>(c));
  return q.maxCoeff() - q.minCoeff();
}

}  // namespace

std::vector<VerdictReason> motion_reasons(const MusculoskeletalModel& model,
                                          const CoordinateTable& motion) {
  if (!stands_for_a_person(model) || motion.time.size() == 0) return {};
  double largest = 0.0, travel = 0.0;
  std::vector<std::string> beyond;
  int angles = 0;
  for (std::size_t c = 0; c < model.coordinates.size(); ++c) {
    const Coordinate& coordinate = model.coordinates[c];
    if (!motion.measured[c] || of_virtual_link(model, static_cast<int>(c))) continue;
    const bool root = model.joints[static_cast<std::size_t>(coordinate.joint)].parent == 0;
    const auto q = motion.q.col(static_cast<Eigen::Index>(c));
    if (turns(coordinate)) {
      largest = std::max(largest, q.cwiseAbs().maxCoeff());
      angles += !root && range_of(motion, c) > kTurns;
    } else if (root && coordinate.motion == Coordinate::Motion::kTranslational) {
      travel = std::max(travel, range_of(motion, c));
    }
    // Nobody keeps the range of a heading or of a place.
    if (root || coordinate.motion == Coordinate::Motion::kCoupled) continue;
    const double margin = turns(coordinate) ? kRangeMargin : kShiftedBeyond;
    const auto out =
        ((q.array() < coordinate.range_min - margin) || (q.array() > coordinate.range_max + margin))
            .count();
    if (static_cast<double>(out) > kMostFrames * static_cast<double>(q.size())) {
      beyond.push_back(coordinate.name);
    }
  }
  std::vector<VerdictReason> reasons;
  const double least = kLargestRadians * kDegree;
  if (angles > 3 && travel > kTravels && largest < least) {
    VerdictReason& r = reasons.emplace_back(own_reason(
        "angles-unit",
        fmt::format("the body travels by {:.1f} m and no angle is larger than this", travel),
        "the file's angles seem to be radians: write inDegrees=no into its header"));
    r.weight = VerdictReason::Weight::kUnusable;
    r.figure = largest / kDegree;
    r.limit = least / kDegree;
    r.unit = "degrees";
    for (const Coordinate& c : model.coordinates) r.torques.push_back(c.name);
  }
  if (!beyond.empty()) {
    VerdictReason& r = reasons.emplace_back(own_reason(
        "beyond-range",
        fmt::format("far beyond what the model allows in most frames: {}", some_names(beyond)),
        "was the motion made with this model? Signs, zeros and units of its angles are another's "
        "otherwise"));
    if (beyond.size() > 1) r.weight = VerdictReason::Weight::kUnusable;
    r.figure = static_cast<double>(beyond.size());
    r.limit = 0.0;
    r.torques = std::move(beyond);
  }
  return reasons;
}

}  // namespace sinew
