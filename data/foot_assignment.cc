#include "data/foot_assignment.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "data/foot_motion.h"
#include "data/numbers.h"

namespace sinew {
namespace {

using Eigen::Vector3d;

// Someone's heel or toe rebounds for less; a step of a run lasts 150 ms and more.
constexpr double kLongestBreak = 0.03, kShortestContact = 0.05;  // [s]
// Half a foot's width and what markers, corners and centres of pressure are off.
constexpr double kNear = 0.1;  // [m]
// The length of a foot: the pressure may be at its other end where only heel or toe is measured.
constexpr double kNearLoneMarker = 0.25;  // [m]
// Heel and toe markers stick out of a foot by 1 to 2 cm, corners are measured to one.
constexpr double kOverEdge = 0.05;  // [m]
constexpr double kLeastShare = 0.5;
// Of the share of the foot that fits better; beyond it both fit alike.
constexpr double kRivalShare = 0.8;
constexpr double kTwoFeetTime = 0.05;  // [s]

// How a foot goes with one contact.
struct Fit {
  int frames = 0, fitting = 0;  // with a centre of pressure and a measured foot
  int standing_on = 0;          // frames in which it stands within the platform's edges
  std::vector<double> outside;  // of the platform, by frames in which it fits
};

class Assigner {
 public:
  Assigner(const MarkerTrajectories& markers, std::vector<Foot> feet,
           const std::vector<ForcePlatformRecording>& plates, double threshold)
      : markers_(markers), plates_(plates), threshold_(threshold) {
    for (const Foot& foot : feet) motions_.push_back(foot_motion(markers, foot));
    result_.feet = std::move(feet);
  }

  FootAssignment assign(const std::vector<AssignmentOverride>& overrides) {
    check(overrides);
    for (std::size_t i = 0; i < plates_.size(); ++i) find_contacts(static_cast<int>(i));
    for (PlateContact& contact : result_.contacts) judge(contact);
    for (PlateContact& contact : result_.contacts) judge_edge(contact);
    for (PlateContact& contact : result_.contacts) apply(overrides, contact);
    return std::move(result_);
  }

 private:
  const ForcePlatformRecording& plate_of(const PlateContact& contact) const {
    return plates_[static_cast<std::size_t>(contact.plate)];
  }

  void check(const std::vector<AssignmentOverride>& overrides) const {
    for (const AssignmentOverride& o : overrides) {
      const bool plate = std::any_of(plates_.begin(), plates_.end(),
                                     [&](const auto& p) { return p.platform.number == o.plate; });
      if (!plate) {
        throw std::invalid_argument(
            fmt::format("--assign names platform {}; the file has {}", o.plate, plates_.size()));
      }
      if (o.foot != "none" && foot_named(o.foot) < 0) {
        throw std::invalid_argument(
            fmt::format("--assign names '{}', which is no foot of the recording: name right, left "
                        "or none",
                        o.foot));
      }
    }
  }

  int foot_named(const std::string& name) const {
    for (std::size_t i = 0; i < result_.feet.size(); ++i) {
      if (result_.feet[i].name == name) return static_cast<int>(i);
    }
    return -1;
  }

  void find_contacts(int index) {
    const ForcePlatformRecording& plate = plates_[static_cast<std::size_t>(index)];
    if (!plate.platform.usable() || !plate.platform.has_moments) return;
    const auto longest_break = static_cast<Eigen::Index>(kLongestBreak * plate.rate);
    Eigen::Index first = -1, last = -1;
    const auto close = [&] {
      if (first >= 0 && static_cast<double>(last - first + 1) / plate.rate >= kShortestContact) {
        add_contact(index, first, last);
      }
      first = -1;
    };
    for (Eigen::Index i = 0; i < plate.force.rows(); ++i) {
      if (std::isnan(plate.center(i, 0))) continue;
      if (first >= 0 && i - last > longest_break) close();
      if (first < 0) first = i;
      last = i;
    }
    close();
  }

  void add_contact(int index, Eigen::Index first, Eigen::Index last) {
    const ForcePlatformRecording& plate = plates_[static_cast<std::size_t>(index)];
    PlateContact contact;
    contact.plate = index;
    contact.from = static_cast<double>(first) / plate.rate;
    contact.to = static_cast<double>(last) / plate.rate;
    for (Eigen::Index i = first; i <= last; ++i) {
      contact.peak =
          std::max(contact.peak, std::abs(plate.force.row(i).dot(plate.platform.R_WP.col(2))));
    }
    // Noise above the threshold is no step.
    if (contact.peak >= 2.0 * threshold_) result_.contacts.push_back(contact);
  }

  Fit fit(const PlateContact& contact, const FootMotion& motion) const {
    const ForcePlatformRecording& plate = plate_of(contact);
    Fit fit;
    for (int f = 0; f < markers_.frame_count(); ++f) {
      const double t = markers_.time[f];
      const auto sample = static_cast<Eigen::Index>(std::lround(t * plate.rate));
      const auto& foot = motion.markers[static_cast<std::size_t>(f)];
      if (t < contact.from || t > contact.to || sample >= plate.center.rows() || foot.empty() ||
          std::isnan(plate.center(sample, 0))) {
        continue;
      }
      ++fit.frames;
      if (!motion.stands[static_cast<std::size_t>(f)]) continue;
      double farthest = -1.0, nearest = 1e9;
      for (const Vector3d& p : foot) {
        farthest = std::max(farthest, distance_outside(plate.platform, p));
        nearest = std::min(nearest, distance_outside(plate.platform, p));
      }
      if (nearest < 0.0) ++fit.standing_on;
      const double near = foot.size() == 1 ? kNearLoneMarker : kNear;
      if (distance_to_foot(foot, plate.center.row(sample).transpose()) > near) continue;
      ++fit.fitting;
      fit.outside.push_back(farthest);
    }
    return fit;
  }

  void judge(PlateContact& contact) {
    std::vector<Fit> fits;
    for (const FootMotion& motion : motions_) fits.push_back(fit(contact, motion));
    const auto share = [&](std::size_t i) {
      return fits[i].frames > 0 ? static_cast<double>(fits[i].fitting) / fits[i].frames : kNaN;
    };
    std::size_t best = fits.size();
    for (std::size_t i = 0; i < fits.size(); ++i) {
      if (std::isnan(share(i))) continue;
      if (best == fits.size() || share(i) > share(best)) best = i;
    }
    contact.share = best < fits.size() ? share(best) : kNaN;
    if (best == fits.size()) {
      contact.reason = "no foot is measured meanwhile";
      return;
    }
    if (contact.share < kLeastShare) {
      contact.reason = fmt::format(
          "the centre of pressure lies outside of either standing foot in {:.0f} % of the frames",
          100.0 * (1.0 - contact.share));
      return;
    }
    double rival = 0.0;
    int others_standing = 0;
    for (std::size_t i = 0; i < fits.size(); ++i) {
      if (i == best || fits[i].frames == 0) continue;
      rival = std::max(rival, share(i));
      others_standing = std::max(others_standing, fits[i].standing_on);
    }
    contact.foot = static_cast<int>(best);
    contact.confidence = contact.share * (1.0 - rival / (contact.share + rival));
    contact.outside = middle(fits[best].outside);
    const double together = others_standing / markers_.rate;
    if (together > kTwoFeetTime) {
      contact.reason = fmt::format("both feet stand on it for {:.2f} s", together);
      contact.confidence *= 0.5;
      return;
    }
    if (rival > kRivalShare * contact.share) {
      contact.reason =
          fmt::format("both feet fit: {} in {:.0f} % of the frames, the other in {:.0f} %",
                      result_.feet[best].name, 100.0 * contact.share, 100.0 * rival);
      return;
    }
    contact.state = PlateContact::State::kAssigned;
  }

  static double middle(std::vector<double> values) {
    if (values.empty()) return 0.0;
    const auto at = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), at, values.end());
    return std::max(*at, 0.0);
  }

  // Over the edge is well where another platform carries the rest of the same foot.
  void judge_edge(PlateContact& contact) const {
    if (contact.state != PlateContact::State::kAssigned) return;
    for (const PlateContact& other : result_.contacts) {
      const bool shared = other.plate != contact.plate && other.foot == contact.foot &&
                          other.state == PlateContact::State::kAssigned &&
                          other.from < contact.to && other.to > contact.from;
      if (!shared) continue;
      contact.reason = fmt::format("the foot crosses to platform {}; both are summed",
                                   plate_of(other).platform.number);
      return;
    }
    if (contact.outside <= kOverEdge) return;
    contact.state = PlateContact::State::kUnusable;
    contact.confidence *= 0.5;
    contact.reason =
        fmt::format("the foot reaches {:.0f} cm over its edge, where nothing measures the force",
                    100.0 * contact.outside);
  }

  void apply(const std::vector<AssignmentOverride>& overrides, PlateContact& contact) const {
    const double time = 0.5 * (contact.from + contact.to);
    for (const AssignmentOverride& o : overrides) {
      const bool meant = o.plate == plate_of(contact).platform.number &&
                         time >= o.from.value_or(time) && time <= o.to.value_or(time);
      if (!meant) continue;
      contact.overridden = true;
      contact.confidence = 1.0;
      contact.foot = o.foot == "none" ? -1 : foot_named(o.foot);
      contact.state =
          contact.foot < 0 ? PlateContact::State::kNobody : PlateContact::State::kAssigned;
      contact.reason = contact.reason.empty() ? "said by --assign"
                                              : "said by --assign, though " + contact.reason;
    }
  }

  const MarkerTrajectories& markers_;
  const std::vector<ForcePlatformRecording>& plates_;
  const double threshold_;
  std::vector<FootMotion> motions_;
  FootAssignment result_;
};

}  // namespace

FootAssignment assign_feet(const MarkerTrajectories& markers, std::vector<Foot> feet,
                           const std::vector<ForcePlatformRecording>& plates, double threshold,
                           const std::vector<AssignmentOverride>& overrides) {
  return Assigner(markers, std::move(feet), plates, threshold).assign(overrides);
}

}  // namespace sinew
