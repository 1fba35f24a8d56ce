#include "data/carried_mass.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace sinew {
namespace {

constexpr double kGravity = 9.80665;    // [m/s²]
constexpr double kLeastStanding = 0.5;  // [s]
constexpr double kSway = 0.05;          // of the weight, that standing still stays within
constexpr double kLeastWeight = 50.0;   // [N]

// The vertical force of all platforms together, at the first one's rate.
std::vector<double> total_force(const std::vector<ForcePlatformRecording>& plates) {
  std::vector<double> total;
  for (const ForcePlatformRecording& plate : plates) {
    if (!plate.platform.usable()) continue;
    if (total.empty()) total.assign(static_cast<std::size_t>(plate.force.rows()), 0.0);
    const std::size_t rows = std::min(total.size(), static_cast<std::size_t>(plate.force.rows()));
    for (std::size_t i = 0; i < rows; ++i) {
      const double force = plate.force(static_cast<Eigen::Index>(i), 1);
      if (std::isfinite(force)) total[i] += force;
    }
  }
  return total;
}

constexpr double kLeastStride = 0.4, kLongestStride = 2.5;  // [s]

// Whether all that acts on the feet is known from one time to another.
bool complete_between(const LoadCoverage& coverage, const Eigen::VectorXd& time, double from,
                      double to) {
  for (Eigen::Index f = 0; f < time.size(); ++f) {
    if (time[f] < from || time[f] > to) continue;
    if (!coverage.complete(static_cast<std::size_t>(f))) return false;
  }
  return true;
}

double middle(std::vector<double> values) {
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

}  // namespace

std::optional<double> standing_mass(const std::vector<ForcePlatformRecording>& plates) {
  const std::vector<double> total = total_force(plates);
  if (total.empty()) return std::nullopt;
  const double weight = middle(total);
  if (weight < kLeastWeight) return std::nullopt;
  std::size_t first = 0, longest_first = 0, longest = 0;
  for (std::size_t i = 0; i <= total.size(); ++i) {
    const bool still = i < total.size() && std::abs(total[i] - weight) < kSway * weight;
    if (still) continue;
    if (i - first > longest) {
      longest = i - first;
      longest_first = first;
    }
    first = i + 1;
  }
  if (static_cast<double>(longest) < kLeastStanding * plates.front().rate) return std::nullopt;
  const auto begin = total.begin() + static_cast<std::ptrdiff_t>(longest_first);
  const double sum = std::accumulate(begin, begin + static_cast<std::ptrdiff_t>(longest), 0.0);
  return sum / static_cast<double>(longest) / kGravity;
}

std::optional<StrideMass> stride_mass(const FootAssignment& assignment,
                                      const LoadCoverage& coverage, const Eigen::VectorXd& time,
                                      const std::vector<ForcePlatformRecording>& plates) {
  const std::vector<double> total = total_force(plates);
  if (total.empty() || time.size() < 2) return std::nullopt;
  const double rate = plates.front().rate;
  StrideMass found;
  for (const PlateContact& strike : assignment.contacts) {
    // A contact that the record begins with has no strike.
    if (strike.state != PlateContact::State::kAssigned || strike.from <= time[1]) continue;
    double next = INFINITY;
    for (const PlateContact& other : assignment.contacts) {
      const bool follows = other.foot == strike.foot && other.from - strike.from > kLeastStride &&
                           other.state == PlateContact::State::kAssigned;
      if (follows) next = std::min(next, other.from);
    }
    if (next - strike.from > kLongestStride) continue;
    if (!complete_between(coverage, time, strike.from, next)) continue;
    const auto first = static_cast<std::ptrdiff_t>(std::lround(strike.from * rate)),
               end = static_cast<std::ptrdiff_t>(std::lround(next * rate));
    if (end > static_cast<std::ptrdiff_t>(total.size())) continue;
    const double sum = std::accumulate(total.begin() + first, total.begin() + end, 0.0);
    found.mass += sum / static_cast<double>(end - first) / kGravity;
    ++found.strides;
  }
  if (found.strides == 0) return std::nullopt;
  found.mass /= found.strides;
  return found;
}

}  // namespace sinew
