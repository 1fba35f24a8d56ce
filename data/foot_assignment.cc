#include "data/foot_assignment.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include "data/csv_file.h"
#include "data/force_table.h"
#include "data/marker_names.h"
#include "data/text.h"

namespace sinew {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
// Someone's heel or toe rebounds for less; a step of a run lasts 150 ms and more.
constexpr double kLongestBreak = 0.03, kShortestContact = 0.05;  // [s]
// A foot rolls over with 0.3 m/s at its slowest marker and swings with 2 to 5 m/s.
constexpr double kStandingSpeed = 0.7;  // [m/s]
// Half a foot's width and what markers, corners and centres of pressure are off.
constexpr double kNear = 0.1;  // [m]
// Heel and toe markers stick out of a foot by 1 to 2 cm, corners are measured to one.
constexpr double kOverEdge = 0.05;  // [m]
constexpr double kLeastShare = 0.5;
// Of the share of the foot that fits better; beyond it both fit alike.
constexpr double kRivalShare = 0.8;
constexpr double kTwoFeetTime = 0.05;  // [s]

// Seen from above: x forward, z right.
Vector2d from_above(const Vector3d& p) { return {p.x(), p.z()}; }

double distance_to_segment(const Vector2d& p, const Vector2d& a, const Vector2d& b) {
  const Vector2d ab = b - a;
  const double length = ab.squaredNorm();
  const double s = length > 0.0 ? std::clamp((p - a).dot(ab) / length, 0.0, 1.0) : 0.0;
  return (p - a - s * ab).norm();
}

// How far a point lies outside of a platform's edges; negative inside.
double outside_of(const ForcePlatform& platform, const Vector3d& p) {
  const Vector3d local = platform.R_WP.transpose() * (p - platform.p_WC);
  const auto& c = platform.corners;
  const double half_x = 0.25 * ((c[0] - c[1]).norm() + (c[3] - c[2]).norm());
  const double half_y = 0.25 * ((c[0] - c[3]).norm() + (c[1] - c[2]).norm());
  return std::max(std::abs(local.x()) - half_x, std::abs(local.y()) - half_y);
}

// What a foot does in every frame.
struct FootMotion {
  std::vector<std::vector<Vector3d>> markers;  // measured ones, by frame
  std::vector<bool> stands;                    // false where it is not measured
};

FootMotion motion_of(const Foot& foot, const MarkerTrajectories& markers) {
  FootMotion motion;
  const int frames = markers.frame_count();
  for (int f = 0; f < frames; ++f) {
    const int before = std::max(f - 1, 0), behind = std::min(f + 1, frames - 1);
    const double dt = markers.time[behind] - markers.time[before];
    double slowest = std::numeric_limits<double>::infinity();
    motion.markers.emplace_back();
    for (const int marker : foot.markers) {
      const Vector3d p = markers.position(f, marker);
      if (!p.allFinite()) continue;
      motion.markers.back().push_back(p);
      const Vector3d d = markers.position(behind, marker) - markers.position(before, marker);
      if (d.allFinite() && dt > 0.0) slowest = std::min(slowest, d.norm() / dt);
    }
    motion.stands.push_back(slowest < kStandingSpeed);
  }
  return motion;
}

double distance_to_foot(const std::vector<Vector3d>& markers, const Vector3d& center) {
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < markers.size(); ++i) {
    for (std::size_t k = i; k < markers.size(); ++k) {
      nearest = std::min(nearest, distance_to_segment(from_above(center), from_above(markers[i]),
                                                      from_above(markers[k])));
    }
  }
  return nearest;
}

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
    for (const Foot& foot : feet) motions_.push_back(motion_of(foot, markers));
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
        farthest = std::max(farthest, outside_of(plate.platform, p));
        nearest = std::min(nearest, outside_of(plate.platform, p));
      }
      if (nearest < 0.0) ++fit.standing_on;
      if (distance_to_foot(foot, plate.center.row(sample).transpose()) > kNear) continue;
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

// The loads of one foot at one sample: those that carry it, by platform.
struct Load {
  Vector3d force = Vector3d::Zero(), center = Vector3d::Constant(kNaN);
  Vector3d free_moment = Vector3d::Zero();
};

Load sum_of(const std::vector<Load>& loads) {
  if (loads.size() == 1) return loads.front();
  Load sum;
  Vector3d moment = Vector3d::Zero();
  double height = 0.0;
  for (const Load& load : loads) {
    sum.force += load.force;
    moment += load.center.cross(load.force) + load.free_moment;
    height += load.center.y() / static_cast<double>(loads.size());
  }
  const Vector3d& F = sum.force;
  sum.center = {(moment.z() + height * F.x()) / F.y(), height,
                (height * F.z() - moment.x()) / F.y()};
  sum.free_moment = moment - sum.center.cross(F);
  return sum;
}

const char* name_of(PlateContact::State state) {
  if (state == PlateContact::State::kAssigned) return "assigned";
  return state == PlateContact::State::kUnusable ? "unusable" : "nobody";
}

}  // namespace

std::vector<Foot> find_feet(const MarkerTrajectories& markers) {
  std::vector<Foot> feet = {{"right", "calcn_r", {}}, {"left", "calcn_l", {}}};
  for (int i = 0; i < markers.marker_count(); ++i) {
    const MarkerName name = parse_marker_name(markers.names[static_cast<std::size_t>(i)]);
    if (name.place != MarkerPlace::kFoot || name.side == Side::kNone) continue;
    feet[name.side == Side::kRight ? 0 : 1].markers.push_back(i);
  }
  std::erase_if(feet, [](const Foot& foot) { return foot.markers.empty(); });
  return feet;
}

std::optional<AssignmentOverride> parse_override(const std::string& text) {
  const std::size_t colon = text.find(':'), at = text.find('@');
  if (colon == text.npos) return std::nullopt;
  AssignmentOverride result;
  const auto plate = text::parse_integer(text.substr(0, colon));
  if (!plate || *plate < 1 || *plate > 255) return std::nullopt;
  result.plate = static_cast<int>(*plate);
  result.foot = text.substr(colon + 1, at == text.npos ? at : at - colon - 1);
  if (result.foot.empty()) return std::nullopt;
  if (at == text.npos) return result;
  const std::string range = text.substr(at + 1);
  const std::size_t dash = range.find('-', 1);
  if (dash == range.npos) return std::nullopt;
  result.from = text::parse_number(range.substr(0, dash));
  result.to = text::parse_number(range.substr(dash + 1));
  if (!result.from || !result.to || !(*result.from < *result.to)) return std::nullopt;
  return result;
}

FootAssignment assign_feet(const MarkerTrajectories& markers, std::vector<Foot> feet,
                           const std::vector<ForcePlatformRecording>& plates, double threshold,
                           const std::vector<AssignmentOverride>& overrides) {
  return Assigner(markers, std::move(feet), plates, threshold).assign(overrides);
}

TimeTable foot_loads(const FootAssignment& assignment,
                     const std::vector<ForcePlatformRecording>& plates) {
  TimeTable table;
  table.name = "Ground reactions";
  // `condition` leaves platforms without moments as they are; the others have the same samples.
  const auto any = std::find_if(plates.begin(), plates.end(), [](const auto& plate) {
    return plate.platform.has_moments && plate.sample_count() > 0;
  });
  if (any == plates.end()) return table;
  const Eigen::Index rows = any->force.rows();
  const double rate = any->rate;
  table.time.resize(rows);
  for (Eigen::Index i = 0; i < rows; ++i) table.time[i] = static_cast<double>(i) / rate;
  for (std::size_t foot = 0; foot < assignment.feet.size(); ++foot) {
    std::vector<std::vector<Load>> loads(static_cast<std::size_t>(rows));
    Vector3d anywhere = any->platform.p_WC;
    for (const PlateContact& contact : assignment.contacts) {
      if (contact.foot != static_cast<int>(foot) ||
          contact.state != PlateContact::State::kAssigned) {
        continue;
      }
      const ForcePlatformRecording& plate = plates[static_cast<std::size_t>(contact.plate)];
      const auto first = static_cast<Eigen::Index>(std::lround(contact.from * rate));
      const auto last = static_cast<Eigen::Index>(std::lround(contact.to * rate));
      for (Eigen::Index i = first; i <= last && i < rows; ++i) {
        if (std::isnan(plate.center(i, 0))) continue;
        loads[static_cast<std::size_t>(i)].push_back({plate.force.row(i).transpose(),
                                                      plate.center.row(i).transpose(),
                                                      plate.free_moment.row(i).transpose()});
      }
    }
    RowMatrix forces = RowMatrix::Zero(rows, 3), moments = forces,
              centers = RowMatrix::Constant(rows, 3, kNaN);
    for (Eigen::Index i = 0; i < rows; ++i) {
      const auto& at = loads[static_cast<std::size_t>(i)];
      if (at.empty()) continue;
      const Load sum = sum_of(at);
      forces.row(i) = sum.force.transpose();
      centers.row(i) = sum.center.transpose();
      moments.row(i) = sum.free_moment.transpose();
    }
    fill_centers(centers, anywhere);
    const Eigen::Index columns = table.values.cols();
    table.values.conservativeResize(rows, columns + 9);
    table.values.rightCols(9) << forces, centers, moments;
    for (const char* kind : {"force_v", "force_p", "torque_"}) {
      for (const char axis : {'x', 'y', 'z'}) {
        table.labels.push_back(fmt::format("{}_{}{}", assignment.feet[foot].name, kind, axis));
      }
    }
  }
  return table;
}

std::string contacts_csv(const FootAssignment& assignment,
                         const std::vector<ForcePlatformRecording>& plates) {
  std::string out = "platform,from_s,to_s,peak_n,foot,state,confidence,share,over_edge_m,reason\n";
  for (const PlateContact& c : assignment.contacts) {
    const std::string foot =
        c.foot < 0 ? "" : assignment.feet[static_cast<std::size_t>(c.foot)].name;
    out += fmt::format("{},{:.4f},{:.4f},{:.1f},{},{},{:.3f},{},{:.3f},{}\n",
                       plates[static_cast<std::size_t>(c.plate)].platform.number, c.from, c.to,
                       c.peak, foot, name_of(c.state), c.confidence,
                       std::isnan(c.share) ? "" : fmt::format("{:.3f}", c.share), c.outside,
                       csv_cell(c.reason));
  }
  return out;
}

std::string describe(const PlateContact& contact, const FootAssignment& assignment,
                     const std::vector<ForcePlatformRecording>& plates) {
  std::string text = fmt::format("platform {}, {:.2f} s to {:.2f} s: ",
                                 plates[static_cast<std::size_t>(contact.plate)].platform.number,
                                 contact.from, contact.to);
  if (contact.state == PlateContact::State::kAssigned) {
    text += fmt::format("{} foot ({:.0f} % sure)",
                        assignment.feet[static_cast<std::size_t>(contact.foot)].name,
                        100.0 * contact.confidence);
  } else {
    text += contact.state == PlateContact::State::kNobody ? "nobody" : "unusable";
  }
  return contact.reason.empty() ? text : text + ": " + contact.reason;
}

}  // namespace sinew
