#include "data/preflight_units.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "data/foot_markers.h"
#include "data/marker_names.h"
#include "data/statistics.h"

namespace sinew {
namespace {

using Eigen::Vector3d;

// Enough for a middle that no single frame moves.
constexpr int kFrames = 200;

struct Unit {
  const char* name;
  double metres;
};
// In the order in which laboratories use them.
constexpr std::array<Unit, 5> kUnits = {
    {{"mm", 1e-3}, {"m", 1.0}, {"cm", 1e-2}, {"in", 0.0254}, {"ft", 0.3048}}};

double scatter(const MarkerTrajectories& markers, int frame) {
  std::array<std::vector<double>, 3> coordinates;
  for (int i = 0; i < markers.marker_count(); ++i) {
    const Vector3d p = markers.position(frame, i);
    if (!p.allFinite()) continue;
    for (std::size_t k = 0; k < 3; ++k) coordinates[k].push_back(p[static_cast<int>(k)]);
  }
  if (coordinates[0].size() < 2) return std::nan("");
  const Vector3d center(median(coordinates[0]), median(coordinates[1]), median(coordinates[2]));
  std::vector<double> distances;
  for (int i = 0; i < markers.marker_count(); ++i) {
    const double d = (markers.position(frame, i) - center).norm();
    if (std::isfinite(d)) distances.push_back(d);
  }
  return 2.0 * median(distances);
}

}  // namespace

void UnitCheckOptions::validate() const {
  for (const auto& [name, least, largest] : {std::tuple{"height", least_height, largest_height},
                                             std::tuple{"size", least_size, largest_size}}) {
    if (least > 0.0 && least < largest) continue;
    throw std::invalid_argument(
        fmt::format("UnitCheckOptions::least_{0} is {1} and largest_{0} {2}; they must be above 0 "
                    "and rise",
                    name, least, largest));
  }
}

BodySize body_size(const MarkerTrajectories& markers) {
  const auto [low, high] = low_and_high_markers(markers.names);
  std::vector<double> heights, sizes;
  const int step = std::max(1, markers.frame_count() / kFrames);
  for (int frame = 0; frame < markers.frame_count(); frame += step) {
    const double height =
        (mean_position(markers, frame, high) - mean_position(markers, frame, low)).norm();
    if (std::isfinite(height)) heights.push_back(height);
    const double size = scatter(markers, frame);
    if (std::isfinite(size)) sizes.push_back(size);
  }
  if (!heights.empty()) return {median(heights), true};
  return {median(sizes), false};
}

std::vector<Finding> find_unit_faults(const MarkerTrajectories& markers, double metres_per_unit,
                                      const UnitCheckOptions& options) {
  options.validate();
  const BodySize size = body_size(markers);
  const double least = size.by_names ? options.least_height : options.least_size;
  const double largest = size.by_names ? options.largest_height : options.largest_size;
  if (!(size.value > 0.0) || (size.value >= least && size.value <= largest)) return {};
  Finding finding;
  finding.severity = Finding::Severity::kError;
  finding.kind = "unit";
  finding.text =
      size.by_names
          ? fmt::format("the markers of pelvis, trunk and head are {:.4g} m from those of the feet",
                        size.value)
          : fmt::format("markers scatter over {:.4g} m", size.value);
  finding.advice = "no unit of length makes a person of it: look at the markers";
  finding.confidence = size.by_names ? 0.98 : 0.85;
  // What a scatter of a whole or half body is; a narrower range than what is accepted, for here the
  // unit is in doubt.
  const double low = size.by_names ? least : 0.15, high = size.by_names ? largest : 2.0;
  for (const Unit& unit : kUnits) {
    const double in_unit = size.value / metres_per_unit * unit.metres;
    if (!(in_unit >= low && in_unit <= high)) continue;
    finding.text += fmt::format("; in {} it would be {:.3g} m", unit.name, in_unit);
    finding.flags = {"--unit", unit.name};
    finding.advice.clear();
    break;
  }
  return {finding};
}

}  // namespace sinew
