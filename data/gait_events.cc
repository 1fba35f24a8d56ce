#include "data/gait_events.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "data/conditioning.h"
#include "data/numbers.h"
#include "data/text.h"

namespace sinew {
namespace {

using Eigen::Vector3d;
using Kind = GaitEvent::Kind;

// Half a foot's length and what markers and corners are off.
constexpr double kNear = 0.25;  // [m]
// Of the nearer foot's distance; beyond it both are as near.
constexpr double kClearlyNearer = 0.7;
// A foot's contacts with two platforms overlap, or nearly.
constexpr double kSameContact = 0.03;  // [s]

void sort_by_time(std::vector<GaitEvent>& events) {
  std::stable_sort(events.begin(), events.end(),
                   [](const GaitEvent& a, const GaitEvent& b) { return a.time < b.time; });
}

// Mean distance of a contact's centre of pressure from a foot's nearest marker, seen from above.
double distance_of(const MarkerTrajectories& markers, const std::vector<int>& foot,
                   const ForceSignal& signal, const ForceContact& contact, const Vector3d& up) {
  double sum = 0.0;
  int count = 0;
  // The middle half, in which the foot stands whole on it.
  const double quarter = 0.25 * (contact.to - contact.from);
  for (int f = 0; f < markers.frame_count(); ++f) {
    const double t = markers.time[f];
    if (t < contact.from + quarter || t > contact.to - quarter) continue;
    const auto sample = static_cast<Eigen::Index>(std::lround((t - signal.start) * signal.rate));
    if (sample < 0 || sample >= signal.center.rows()) continue;
    double nearest = kNaN;
    for (const int marker : foot) {
      Vector3d d = markers.position(f, marker) - signal.center.row(sample).transpose();
      d -= up * up.dot(d);
      nearest = std::fmin(nearest, d.norm());
    }
    if (std::isnan(nearest)) continue;
    sum += nearest;
    ++count;
  }
  return count > 0 ? sum / count : kNaN;
}

struct SidedContact {
  ForceContact contact;
  Side side = Side::kNone;
  int plate = 0;
};

Side side_of(const MarkerTrajectories& markers, const FeetMarkers& feet, const ForceSignal& signal,
             const ForceContact& contact, const Vector3d& up) {
  const double left = distance_of(markers, feet.left.all, signal, contact, up);
  const double right = distance_of(markers, feet.right.all, signal, contact, up);
  if (!(std::fmin(left, right) < kNear)) return Side::kNone;
  if (std::isnan(left)) return Side::kRight;
  if (std::isnan(right)) return Side::kLeft;
  if (std::min(left, right) > kClearlyNearer * std::max(left, right)) return Side::kNone;
  return left < right ? Side::kLeft : Side::kRight;
}

// Joins contacts of one foot that overlap.
std::vector<SidedContact> joined(std::vector<SidedContact> contacts) {
  std::stable_sort(contacts.begin(), contacts.end(),
                   [](const auto& a, const auto& b) { return a.contact.from < b.contact.from; });
  std::vector<SidedContact> result;
  for (const SidedContact& next : contacts) {
    const auto same = std::find_if(result.rbegin(), result.rend(), [&](const SidedContact& c) {
      return c.side == next.side && c.side != Side::kNone && c.plate != next.plate &&
             next.contact.from <= c.contact.to + kSameContact;
    });
    if (same == result.rend()) {
      result.push_back(next);
    } else if (next.contact.to > same->contact.to) {
      same->contact.to = next.contact.to;
      same->contact.ends = next.contact.ends;
    }
  }
  return result;
}

// Both turns of a curve, NaN where it is not known.
class TurningPoints {
 public:
  TurningPoints(const Eigen::VectorXd& time, const std::vector<double>& curve, double least_range,
                const KinematicEventOptions& options)
      : time_(time), curve_(curve), options_(options), least_range_(least_range) {
    for (const double v : curve) {
      low_ = std::fmin(low_, v);
      high_ = std::fmax(high_, v);
    }
    least_ = options.prominence * (high_ - low_);
  }

  /// Times of maxima (sign 1) or minima (sign −1) that `counts` accepts.
  template <typename Counts>
  std::vector<double> find(double sign, const Counts& counts) const {
    std::vector<double> times;
    if (!(high_ - low_ >= least_range_)) return times;
    const auto n = curve_.size();
    for (std::size_t i = 1; i + 1 < n; ++i) {
      const double y = sign * curve_[i], before = sign * curve_[i - 1],
                   behind = sign * curve_[i + 1];
      if (!(y > before && y >= behind) || !is_high(i, sign) || !counts(i)) continue;
      if (!turns(i, sign, -1) || !turns(i, sign, 1)) continue;
      const double curvature = before - 2.0 * y + behind;
      const double s =
          curvature < 0.0 ? std::clamp(0.5 * (before - behind) / curvature, -0.5, 0.5) : 0.0;
      const auto at = static_cast<Eigen::Index>(i);
      const double step = 0.5 * (time_[at + 1] - time_[at - 1]);
      const double t = time_[at] + s * step;
      if (!times.empty() && t - times.back() < options_.least_stride) continue;
      times.push_back(t);
    }
    return times;
  }

 private:
  bool is_high(std::size_t i, double sign) const {
    const double from_top = sign > 0.0 ? high_ - curve_[i] : curve_[i] - low_;
    return from_top <= options_.height * (high_ - low_);
  }

  // Whether the curve falls far enough on one side before it rises above the point again.
  bool turns(std::size_t i, double sign, int direction) const {
    const double top = sign * curve_[i];
    for (auto k = static_cast<std::ptrdiff_t>(i) + direction;
         k >= 0 && k < static_cast<std::ptrdiff_t>(curve_.size()); k += direction) {
      const double y = sign * curve_[static_cast<std::size_t>(k)];
      if (std::isnan(y) || y > top) return false;
      if (top - y >= least_) return true;
    }
    return false;
  }

  const Eigen::VectorXd& time_;
  const std::vector<double>& curve_;
  const KinematicEventOptions& options_;
  const double least_range_;
  double low_ = kNaN, high_ = kNaN, least_ = 0.0;
};

void add_events(const std::vector<double>& times, Kind kind, Side side,
                std::vector<GaitEvent>& events) {
  for (const double t : times) {
    GaitEvent event;
    event.kind = kind;
    event.side = side;
    event.time = event.by_kinematics = t;
    events.push_back(event);
  }
}

void add_by_coordinates(const MarkerTrajectories& markers, const FootMarkers& foot, Side side,
                        const std::vector<int>& pelvis, const Vector3d& forward,
                        const KinematicEventOptions& options, std::vector<GaitEvent>& events) {
  std::vector<double> heel, toe;
  for (int f = 0; f < markers.frame_count(); ++f) {
    const Vector3d p = mean_position(markers, f, pelvis);
    heel.push_back((mean_position(markers, f, foot.heel) - p).dot(forward));
    toe.push_back((mean_position(markers, f, foot.toe) - p).dot(forward));
  }
  const auto any = [](std::size_t) { return true; };
  add_events(TurningPoints(markers.time, heel, options.least_way, options).find(1.0, any),
             Kind::kHeelStrike, side, events);
  add_events(TurningPoints(markers.time, toe, options.least_way, options).find(-1.0, any),
             Kind::kToeOff, side, events);
}

void add_by_velocity(const MarkerTrajectories& markers, const FootMarkers& foot, Side side,
                     const Vector3d& up, const KinematicEventOptions& options,
                     std::vector<GaitEvent>& events) {
  const int frames = markers.frame_count();
  std::vector<double> height, heel, velocity;
  double low = kNaN, high = kNaN;
  for (int f = 0; f < frames; ++f) {
    const Vector3d p_heel = mean_position(markers, f, foot.heel);
    height.push_back(0.5 * (p_heel + mean_position(markers, f, foot.toe)).dot(up));
    heel.push_back(p_heel.dot(up));
    low = std::fmin(low, heel.back());
    high = std::fmax(high, heel.back());
  }
  velocity.assign(height.size(), kNaN);
  for (std::size_t f = 1; f + 1 < height.size(); ++f) {
    const auto at = static_cast<Eigen::Index>(f);
    velocity[f] = (height[f + 1] - height[f - 1]) / (markers.time[at + 1] - markers.time[at - 1]);
  }
  const double limit = low + options.heel_height * (high - low);
  const TurningPoints turns(markers.time, velocity, options.least_velocity, options);
  add_events(turns.find(-1.0, [&](std::size_t i) { return heel[i] < limit; }), Kind::kHeelStrike,
             side, events);
  add_events(turns.find(1.0, [](std::size_t) { return true; }), Kind::kToeOff, side, events);
}

Vector3d forward_of(const MarkerTrajectories& markers, const FeetMarkers& feet,
                    const Vector3d& up) {
  const Vector3d way = way_travelled(markers, up);
  // Half a metre is less than a stride and more than anyone sways.
  if (way.norm() > 0.5) return way.normalized();
  const Vector3d facing = mean_facing(markers, feet, up);
  return facing.isZero() ? facing : Vector3d(facing.normalized());
}

bool contains_one(const std::string& text, std::initializer_list<const char*> words) {
  return std::any_of(words.begin(), words.end(),
                     [&](const char* word) { return text.find(word) != text.npos; });
}

// RHS, LTO, HS: two letters, with or without a side before them.
bool is_short(const std::string& label, std::initializer_list<const char*> words) {
  return std::any_of(words.begin(), words.end(), [&](const std::string& word) {
    return label == word || label == "r" + word || label == "l" + word;
  });
}

bool is_same(const GaitEvent& a, const GaitEvent& b, double tolerance) {
  const bool sides = a.side == b.side || a.side == Side::kNone || b.side == Side::kNone;
  return a.kind == b.kind && sides && std::abs(a.time - b.time) <= tolerance;
}

void merge_into(std::vector<GaitEvent>& all, const std::vector<GaitEvent>& more, double tolerance) {
  const std::size_t count = all.size();
  std::vector<bool> taken(count, false);
  for (const GaitEvent& event : more) {
    std::size_t best = count;
    for (std::size_t i = 0; i < count; ++i) {
      if (taken[i] || !is_same(all[i], event, tolerance)) continue;
      if (best == count ||
          std::abs(all[i].time - event.time) < std::abs(all[best].time - event.time)) {
        best = i;
      }
    }
    if (best == count) {
      all.push_back(event);
      continue;
    }
    taken[best] = true;
    GaitEvent& same = all[best];
    if (same.side == Side::kNone) same.side = event.side;
    if (std::isnan(same.by_file)) same.by_file = event.by_file;
    if (std::isnan(same.by_kinematics)) same.by_kinematics = event.by_kinematics;
  }
}

}  // namespace

const char* to_string(Kind kind) { return kind == Kind::kHeelStrike ? "heel strike" : "toe off"; }

const char* to_string(Side side) {
  return side == Side::kLeft ? "left" : side == Side::kRight ? "right" : "";
}

void KinematicEventOptions::validate() const {
  const auto require = [](const char* name, double value, bool fine, const char* bound) {
    if (fine) return;
    throw std::invalid_argument(
        fmt::format("KinematicEventOptions::{} is {}; it must be {}", name, value, bound));
  };
  require("cutoff", cutoff, cutoff > 0.0, "above 0 Hz");
  require("height", height, height > 0.0 && height <= 1.0, "above 0 and at most 1");
  require("least_way", least_way, least_way >= 0.0, "at least 0 m");
  require("least_velocity", least_velocity, least_velocity >= 0.0, "at least 0 m/s");
  require("prominence", prominence, prominence > 0.0 && prominence < 1.0, "between 0 and 1");
  require("least_stride", least_stride, least_stride >= 0.0, "at least 0 s");
  require("heel_height", heel_height, heel_height > 0.0 && heel_height <= 1.0,
          "above 0 and at most 1");
}

std::vector<GaitEvent> events_from_forces(const std::vector<ForceSignal>& signals,
                                          const MarkerTrajectories* markers, const Vector3d& up,
                                          const ForceContactOptions& options) {
  const FeetMarkers feet = markers ? find_foot_markers(*markers) : FeetMarkers();
  std::vector<SidedContact> contacts;
  for (const ForceContact& contact : find_contacts(signals, up, options)) {
    const ForceSignal& signal = signals[static_cast<std::size_t>(contact.signal)];
    const Side side = markers ? side_of(*markers, feet, signal, contact, up) : Side::kNone;
    contacts.push_back({contact, side, signal.plate > 0 ? signal.plate : -1 - contact.signal});
  }
  std::vector<GaitEvent> events;
  for (const SidedContact& c : joined(std::move(contacts))) {
    GaitEvent event;
    event.side = c.side;
    event.plate = std::max(c.plate, 0);
    if (c.contact.begins) {
      event.kind = Kind::kHeelStrike;
      event.time = event.by_forces = c.contact.from;
      events.push_back(event);
    }
    if (c.contact.ends) {
      event.kind = Kind::kToeOff;
      event.time = event.by_forces = c.contact.to;
      events.push_back(event);
    }
  }
  sort_by_time(events);
  return events;
}

std::vector<GaitEvent> events_from_kinematics(const MarkerTrajectories& markers, const Vector3d& up,
                                              const KinematicEventOptions& options) {
  options.validate();
  std::vector<GaitEvent> events;
  // The filter's shortest stretch.
  if (markers.frame_count() < 6) return events;
  const FeetMarkers feet = find_foot_markers(markers);
  if (!feet.left.has_ends() && !feet.right.has_ends()) return events;
  MarkerTrajectories smoothed = markers;
  lowpass(smoothed, options.cutoff);
  const std::vector<int> pelvis = find_pelvis_markers(markers);
  const Vector3d forward = forward_of(markers, feet, up);
  using Method = KinematicEventOptions::Method;
  Method method = options.method;
  if (method == Method::kAuto) {
    method = pelvis.empty() ? Method::kFootVelocity : Method::kCoordinates;
  }
  for (const Side side : {Side::kLeft, Side::kRight}) {
    if (!feet.of(side).has_ends()) continue;
    if (method == Method::kCoordinates) {
      add_by_coordinates(smoothed, feet.of(side), side, pelvis, forward, options, events);
    } else {
      add_by_velocity(smoothed, feet.of(side), side, up, options, events);
    }
  }
  sort_by_time(events);
  return events;
}

std::vector<GaitEvent> events_from_file(const std::vector<C3dEvent>& events) {
  std::vector<GaitEvent> found;
  for (const C3dEvent& event : events) {
    const std::string label = text::lower(text::trim(event.label)),
                      context = text::lower(event.context);
    GaitEvent gait;
    if (contains_one(label, {"strike", "contact"}) || is_short(label, {"hs", "ic", "fs", "hc"})) {
      gait.kind = Kind::kHeelStrike;
    } else if (label.find("off") != label.npos || is_short(label, {"to", "fo"})) {
      gait.kind = Kind::kToeOff;
    } else {
      continue;
    }
    const auto has = [&](const char* word, char letter) {
      // RHS, LTO, RIC: three letters that begin with the side.
      return context.starts_with(word) || label.find(word) != label.npos ||
             (label.size() <= 3 && label.starts_with(letter));
    };
    if (has("left", 'l')) gait.side = Side::kLeft;
    if (has("right", 'r')) gait.side = Side::kRight;
    gait.time = gait.by_file = event.time;
    found.push_back(gait);
  }
  sort_by_time(found);
  return found;
}

std::vector<GaitEvent> merge_events(const std::vector<GaitEvent>& by_forces,
                                    const std::vector<GaitEvent>& by_file,
                                    const std::vector<GaitEvent>& by_kinematics, double tolerance) {
  std::vector<GaitEvent> all = by_forces;
  merge_into(all, by_file, tolerance);
  merge_into(all, by_kinematics, tolerance);
  sort_by_time(all);
  return all;
}

std::vector<C3dEvent> c3d_events(const std::vector<GaitEvent>& events) {
  std::vector<C3dEvent> result;
  for (const GaitEvent& event : events) {
    C3dEvent stored;
    stored.time = event.time;
    stored.label = event.kind == Kind::kHeelStrike ? "Foot Strike" : "Foot Off";
    stored.context = event.side == Side::kLeft    ? "Left"
                     : event.side == Side::kRight ? "Right"
                                                  : "General";
    result.push_back(std::move(stored));
  }
  return result;
}

std::string events_csv(const std::vector<GaitEvent>& events, const MarkerTrajectories& markers) {
  std::string out = "time,frame,side,event,platform,by_forces,by_file,by_kinematics\n";
  const auto number = [](double value) {
    return std::isnan(value) ? std::string() : fmt::format("{:.6f}", value);
  };
  for (const GaitEvent& event : events) {
    std::string frame;
    if (markers.frame_count() > 0) {
      const auto nearest = std::lround((event.time - markers.time[0]) * markers.rate);
      frame = std::to_string(markers.frame_numbers.front() + nearest);
    }
    out += fmt::format("{:.6f},{},{},{},{},{},{},{}\n", event.time, frame, to_string(event.side),
                       to_string(event.kind),
                       event.plate > 0 ? std::to_string(event.plate) : std::string(),
                       number(event.by_forces), number(event.by_file), number(event.by_kinematics));
  }
  return out;
}

}  // namespace sinew
