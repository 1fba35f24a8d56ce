#include "data/preflight_timing.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <stdexcept>

#include "data/statistics.h"

namespace sinew {
namespace {

using Eigen::Vector3d;

// How a foot rests, frame by frame: 1 at rest, 0 in swing, NaN where it is not measured.
std::vector<double> rest_of(const MarkerTrajectories& markers, const std::vector<int>& foot,
                            double resting_speed) {
  std::vector<double> rest;
  const int frames = markers.frame_count();
  for (int f = 0; f < frames; ++f) {
    const int before = std::max(f - 1, 0), behind = std::min(f + 1, frames - 1);
    const double dt = markers.time[behind] - markers.time[before];
    double slowest = std::numeric_limits<double>::infinity();
    for (const int marker : foot) {
      const Vector3d d = markers.position(behind, marker) - markers.position(before, marker);
      if (d.allFinite() && dt > 0.0) slowest = std::min(slowest, d.norm() / dt);
    }
    rest.push_back(std::isfinite(slowest) ? std::exp(-std::pow(slowest / resting_speed, 2))
                                          : std::nan(""));
  }
  return rest;
}

// Times one contact against both feet.
class Timer {
 public:
  Timer(const MarkerTrajectories& markers, const Vector3d& up, const TimingCheckOptions& options)
      : markers_(markers), up_(up), options_(options), feet_(find_foot_markers(markers)) {
    for (const Side side : {Side::kLeft, Side::kRight}) {
      rest_[index(side)] = rest_of(markers, feet_.of(side).all, options.resting_speed);
    }
  }

  std::optional<ContactTiming> time(const ForceContact& contact) const {
    if (!contact.begins || !contact.ends || !contact.center.allFinite()) return std::nullopt;
    std::optional<ContactTiming> best;
    for (const Side side : {Side::kLeft, Side::kRight}) {
      const double distance = distance_at_rest(contact, side);
      if (std::isnan(distance) || (best && best->distance <= distance)) continue;
      if (!seen_about(side, contact.from) || !seen_about(side, contact.to)) continue;
      best = ContactTiming{0, side, distance, 0.0, 0.0};
    }
    if (best) correlate(contact, *best);
    return best;
  }

 private:
  static std::size_t index(Side side) { return side == Side::kLeft ? 0 : 1; }

  // Frames that a contact may have anything to do with.
  std::pair<int, int> frames_about(const ForceContact& contact, double margin) const {
    int first = 0, end = markers_.frame_count();
    while (first < end && markers_.time[first] < contact.from - margin) ++first;
    while (end > first && markers_.time[end - 1] > contact.to + margin) --end;
    return {first, end};
  }

  // Whether gaps leave when the foot comes to rest or leaves it, if that is at `time`.
  bool seen_about(Side side, double time) const {
    constexpr double kNear = 0.15;  // [s]
    const auto& rest = rest_[index(side)];
    for (int f = 0; f < markers_.frame_count(); ++f) {
      if (std::abs(markers_.time[f] - time) > kNear) continue;
      if (std::isnan(rest[static_cast<std::size_t>(f)])) return false;
    }
    return true;
  }

  // Mean distance, seen from above, of the centre of pressure from the nearest of the foot's
  // markers while it rests about the time of the contact, weighted by how much it rests, of the
  // stretch of rest that is nearest: a foot rests again a metre farther on.
  double distance_at_rest(const ForceContact& contact, Side side) const {
    const auto [first, end] = frames_about(contact, options_.largest_shift);
    const auto& rest = rest_[index(side)];
    double sum = 0.0, weight = 0.0, best = std::nan("");
    const auto close = [&] {
      // A tenth of a second of rest; less is a marker that stops in mid-air.
      if (weight > 0.1 * markers_.rate) best = std::fmin(best, sum / weight);
      sum = weight = 0.0;
    };
    for (int f = first; f < end; ++f) {
      const double r = rest[static_cast<std::size_t>(f)];
      if (!(r > 0.5)) {
        close();
        continue;
      }
      const double distance = distance_to(contact.center, f, side);
      if (std::isnan(distance)) continue;
      sum += r * distance;
      weight += r;
    }
    close();
    return best;
  }

  double distance_to(const Vector3d& center, int frame, Side side) const {
    double nearest = std::nan("");
    for (const int marker : feet_.of(side).all) {
      Vector3d d = markers_.position(frame, marker) - center;
      d -= up_ * up_.dot(d);
      nearest = std::fmin(nearest, d.norm());
    }
    return nearest;
  }

  // The part of the frame's time, half a frame to both sides, in which the contact, moved by
  // `shift`, is loaded.
  double loaded(const ForceContact& contact, int frame, double shift) const {
    const double half = 0.5 / markers_.rate, t = markers_.time[frame];
    const double from = std::max(contact.from + shift, t - half);
    const double to = std::min(contact.to + shift, t + half);
    return std::clamp((to - from) / (2.0 * half), 0.0, 1.0);
  }

  // Pearson's correlation of rest and load within `frames`.
  double correlation(const ForceContact& contact, Side side, std::pair<int, int> frames,
                     double shift) const {
    const auto& rest = rest_[index(side)];
    double n = 0.0, x = 0.0, y = 0.0, xx = 0.0, yy = 0.0, xy = 0.0;
    for (int f = frames.first; f < frames.second; ++f) {
      const double r = rest[static_cast<std::size_t>(f)];
      if (std::isnan(r)) continue;
      const double l = loaded(contact, f, shift);
      n += 1.0;
      x += r;
      y += l;
      xx += r * r;
      yy += l * l;
      xy += r * l;
    }
    const double spread = (n * xx - x * x) * (n * yy - y * y);
    return spread > 0.0 ? (n * xy - x * y) / std::sqrt(spread) : 0.0;
  }

  void correlate(const ForceContact& contact, ContactTiming& timing) const {
    // A swing lasts 0.4 s: within it and the stance the foot rests once.
    const double margin = options_.largest_shift;
    const std::pair<int, int> frames = frames_about(contact, margin);
    // A quarter of a frame: finer steps only follow noise.
    const double step = 0.25 / markers_.rate;
    const int most = static_cast<int>(std::lround(margin / step));
    double best = -2.0;
    int at = 0;
    const auto value = [&](int k) { return correlation(contact, timing.side, frames, k * step); };
    for (int k = -most; k <= most; ++k) {
      const double c = value(k);
      // Of equal ones that which shifts least.
      if (c > best + 1e-12 || (c > best - 1e-12 && std::abs(k) < std::abs(at))) {
        best = std::max(best, c);
        at = k;
      }
    }
    timing.correlation = best;
    // What moves the force onto the foot is the reverse of how late it comes.
    timing.shift = -at * step;
    const double before = value(at - 1), behind = value(at + 1);
    const double curvature = before - 2.0 * best + behind;
    if (curvature < 0.0) {
      timing.shift -= step * std::clamp(0.5 * (before - behind) / curvature, -0.5, 0.5);
    }
  }

  const MarkerTrajectories& markers_;
  const Vector3d up_;
  const TimingCheckOptions& options_;
  const FeetMarkers feet_;
  std::array<std::vector<double>, 2> rest_;
};

Finding place_finding(double distance, std::size_t contacts) {
  Finding finding;
  finding.kind = "place";
  finding.confidence = contacts > 1 ? 0.85 : 0.7;
  finding.text = fmt::format(
      "centres of pressure lie {:.2f} m from the markers of the nearest resting foot: platforms "
      "and "
      "markers do not have the same axes or origin",
      distance);
  finding.advice = "correct FORCE_PLATFORM:CORNERS, or the frame of the forces";
  return finding;
}

}  // namespace

void TimingCheckOptions::validate() const {
  for (const auto& [name, value] :
       {std::pair{"largest_shift", largest_shift}, std::pair{"resting_speed", resting_speed},
        std::pair{"tolerance", tolerance}, std::pair{"least_correlation", least_correlation},
        std::pair{"near", near}}) {
    if (value > 0.0 && std::isfinite(value)) continue;
    throw std::invalid_argument(
        fmt::format("TimingCheckOptions::{} is {}; it must be above 0", name, value));
  }
}

std::vector<ContactTiming> time_contacts(const MarkerTrajectories& markers,
                                         const std::vector<ForceContact>& contacts,
                                         const Vector3d& up, const TimingCheckOptions& options) {
  options.validate();
  const Timer timer(markers, up, options);
  std::vector<ContactTiming> timings;
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    std::optional<ContactTiming> timing = timer.time(contacts[i]);
    if (!timing) continue;
    timing->contact = static_cast<int>(i);
    timings.push_back(*timing);
  }
  return timings;
}

std::vector<Finding> find_clock_faults(const MarkerTrajectories& markers,
                                       const std::vector<ForceSignal>& signals, const Vector3d& up,
                                       const TimingCheckOptions& options) {
  const std::vector<ForceContact> contacts = find_contacts(signals, up);
  const std::vector<ContactTiming> timings = time_contacts(markers, contacts, up, options);
  if (timings.empty()) return {};
  std::vector<double> distances, shifts;
  double correlation = 0.0;
  for (const ContactTiming& timing : timings) {
    distances.push_back(timing.distance);
    if (timing.distance > options.near || timing.correlation < options.least_correlation) continue;
    shifts.push_back(timing.shift);
    correlation += timing.correlation;
  }
  if (const double distance = median(distances); distance > options.near) {
    return {place_finding(distance, distances.size())};
  }
  if (shifts.empty()) return {};
  correlation /= static_cast<double>(shifts.size());
  const double shift = shifts.size() == 2 ? 0.5 * (shifts[0] + shifts[1]) : median(shifts);
  if (std::abs(shift) <= options.tolerance) return {};
  std::vector<double> deviations;
  for (const double s : shifts) deviations.push_back(std::abs(s - shift));
  const double spread = median(deviations);
  // Contacts that do not agree tell of something else.
  const double agreement = std::exp(-std::pow(spread / options.tolerance, 2));
  Finding finding;
  finding.kind = "clock";
  finding.confidence = correlation * agreement * (shifts.size() > 1 ? 1.0 : 0.8);
  if (finding.confidence < 0.4) return {};
  finding.severity =
      finding.confidence >= 0.8 ? Finding::Severity::kError : Finding::Severity::kWarning;
  finding.text = fmt::format(
      "forces come {:.0f} ms {} than the feet rest, by {} contact{} that agree{} to {:.0f} ms",
      1e3 * std::abs(shift), shift > 0.0 ? "later" : "earlier", shifts.size(),
      shifts.size() == 1 ? "" : "s", shifts.size() == 1 ? "s" : "", 1e3 * spread);
  finding.flags = {"--shift-forces", time_text(-shift)};
  return {finding};
}

}  // namespace sinew
