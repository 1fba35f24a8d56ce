#include "ik/size_limits.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace sinew {
namespace {

constexpr const char* kAxes[] = {"depth", "length", "breadth"};  // x, y, z of models that stand

constexpr const char* kSizesFrom = "Drillis & Contini 1966; ANSUR II 2014";
constexpr const char* kMarkersFrom = "Della Croce et al. 2005; Leardini et al. 2005";

double middle(std::vector<double> values) {
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

bool beyond(double value, double lower, double upper) { return value < lower || value > upper; }

}  // namespace

void SizeLimits::validate() const {
  const auto require = [](bool good, const char* field, double value, const char* bound) {
    if (good) return;
    throw std::invalid_argument(
        fmt::format("SizeLimits.{} is {}; expected {}", field, value, bound));
  };
  const auto below = [&](const char* field, double value) {
    require(value > 0.0 && value < 1.0, field, value, "a number between 0 and 1");
  };
  const auto above = [&](const char* field, double value, double bound, const char* text) {
    require(value > bound && std::isfinite(value), field, value, text);
  };
  below("smallest_size", smallest_size);
  below("smallest_ratio", smallest_ratio);
  above("largest_size", largest_size, 1.0, "a finite number above 1");
  above("largest_ratio", largest_ratio, 1.0, "a finite number above 1");
  above("marker_offset", marker_offset, 0.0, "a finite number above 0");
  above("technical_marker_offset", technical_marker_offset, 0.0, "a finite number above 0");
}

VerdictReason whole_size_reason(double size, const SizeLimits& limits) {
  VerdictReason reason;
  reason.weight = VerdictReason::Weight::kUnusable;
  reason.code = "size-limit";
  reason.figure = 100.0 * size;
  reason.limit = 100.0 * (size < 1.0 ? limits.smallest_size : limits.largest_size);
  reason.unit = "%";
  reason.text = fmt::format("the whole body is {:.0f} % of the model's size, {} than people are",
                            reason.figure, size < 1.0 ? "smaller" : "larger");
  reason.source = "WHO Child Growth Standards 2006";
  reason.remedy = "look at the recording's unit (--unit) and at which marker is which (--map)";
  return reason;
}

VerdictReason segment_size_reason(const std::string& body, int axis, double ratio,
                                  const SizeLimits& limits) {
  VerdictReason reason;
  reason.code = "size-limit";
  reason.figure = 100.0 * ratio;
  reason.limit = 100.0 * (ratio < 1.0 ? limits.smallest_ratio : limits.largest_ratio);
  reason.unit = "%";
  reason.text = fmt::format("the {} of {} is {:.0f} % of what the body's size lets expect",
                            axis < 0 ? "size" : kAxes[axis], body, reason.figure);
  reason.source = kSizesFrom;
  reason.remedy = "look at the markers on it and next to it: which is which (--map), and where";
  return reason;
}

VerdictReason moved_marker_reason(const std::string& marker, double moved,
                                  const std::vector<std::string>& technical,
                                  const SizeLimits& limits) {
  const bool anywhere = std::find(technical.begin(), technical.end(), marker) != technical.end();
  VerdictReason reason;
  reason.code = "moved-marker";
  reason.figure = 1e3 * std::abs(moved);
  reason.limit = 1e3 * (anywhere ? limits.technical_marker_offset : limits.marker_offset);
  reason.unit = "mm";
  reason.text =
      fmt::format("{} sits {:.0f} mm or more from where the model has it", marker, reason.figure);
  reason.source = anywhere ? "Sinew" : kMarkersFrom;
  reason.remedy = "look at what it is (--map)";
  // The option says all of them.
  if (!anywhere) {
    reason.remedy += fmt::format("; --technical {}{}{} if it marks no landmark",
                                 fmt::join(technical, ","), technical.empty() ? "" : ",", marker);
  }
  return reason;
}

std::vector<VerdictReason> size_reasons(const MusculoskeletalModel& model,
                                        const ScaleFactors& factors, const SizeLimits& limits) {
  std::vector<VerdictReason> reasons;
  std::vector<double> all;
  for (std::size_t b = 1; b < factors.of_body.size(); ++b) {
    if (model.bodies[b].virtual_link) continue;
    for (const double f : factors.of_body[b]) all.push_back(f);
  }
  if (all.empty()) return reasons;
  const double size = middle(all);
  if (beyond(size, limits.smallest_size, limits.largest_size)) {
    reasons.push_back(whole_size_reason(size, limits));
  }
  for (std::size_t b = 1; b < factors.of_body.size(); ++b) {
    if (model.bodies[b].virtual_link) continue;
    const Eigen::Vector3d ratio = factors.of_body[b] / size;
    const bool uniform = (ratio.array() - ratio[0]).abs().maxCoeff() == 0.0;
    for (int axis = 0; axis < (uniform ? 1 : 3); ++axis) {
      if (!beyond(ratio[axis], limits.smallest_ratio, limits.largest_ratio)) continue;
      reasons.push_back(
          segment_size_reason(model.bodies[b].name, uniform ? -1 : axis, ratio[axis], limits));
    }
  }
  return reasons;
}

}  // namespace sinew
