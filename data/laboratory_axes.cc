#include "data/laboratory_axes.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "data/foot_markers.h"
#include "data/marker_names.h"
#include "data/statistics.h"
#include "data/text.h"

namespace sinew {
namespace {

using Eigen::Vector3d;

// Half a metre is less than a stride and more than anyone sways.
constexpr double kLeastWay = 0.5;  // [m]
// Someone upright is at least this much taller than wide or deep, arms down.
constexpr double kTallness = 1.3;

Vector3d nearest_axis(const Vector3d& direction) {
  Eigen::Index k = 0;
  direction.cwiseAbs().maxCoeff(&k);
  Vector3d axis = Vector3d::Zero();
  axis[k] = direction[k] < 0.0 ? -1.0 : 1.0;
  return axis;
}

// 1 along an axis, 0 halfway between two.
double straightness(const Vector3d& direction) {
  const double cosine = direction.normalized().cwiseAbs().maxCoeff();
  return std::clamp((cosine - std::sqrt(0.5)) / (1.0 - std::sqrt(0.5)), 0.0, 1.0);
}

AxisDecision decide(const Vector3d& direction, double confidence, std::string reason) {
  return {nearest_axis(direction), confidence * (0.5 + 0.5 * straightness(direction)),
          std::move(reason)};
}

// From the feet to head, trunk or pelvis, by names, over all frames.
Vector3d upright_by_names(const MarkerTrajectories& markers) {
  const auto [low, high] = low_and_high_markers(markers.names);
  Vector3d sum = Vector3d::Zero();
  for (int frame = 0; frame < markers.frame_count(); ++frame) {
    const Vector3d d = mean_position(markers, frame, high) - mean_position(markers, frame, low);
    if (d.allFinite()) sum += d;
  }
  return sum;
}

// The middle extents of the markers along the axes.
Vector3d middle_extents(const MarkerTrajectories& markers) {
  std::array<std::vector<double>, 3> extents;
  for (int frame = 0; frame < markers.frame_count(); ++frame) {
    Eigen::AlignedBox3d box;
    for (int i = 0; i < markers.marker_count(); ++i) {
      const Vector3d p = markers.position(frame, i);
      if (p.allFinite()) box.extend(p);
    }
    if (box.isEmpty()) continue;
    for (std::size_t k = 0; k < 3; ++k) {
      extents[k].push_back(box.sizes()[static_cast<Eigen::Index>(k)]);
    }
  }
  Vector3d middle = Vector3d::Zero();
  for (std::size_t k = 0; k < 3; ++k) {
    if (!extents[k].empty()) middle[static_cast<Eigen::Index>(k)] = median(std::move(extents[k]));
  }
  return middle;
}

AxisDecision up_by_extent(const MarkerTrajectories& markers) {
  Vector3d extents = middle_extents(markers);
  Eigen::Index tallest = 0;
  const double height = extents.maxCoeff(&tallest);
  extents[tallest] = 0.0;
  if (!(height > kTallness * extents.maxCoeff())) return {};
  return {Vector3d::Unit(tallest), 0.4, "the markers' longest extent"};
}

// From left to right, by names, over all frames.
Vector3d rightward(const MarkerTrajectories& markers) {
  Vector3d sum = Vector3d::Zero();
  for (const MarkerPair& pair : find_marker_pairs(markers.names)) {
    for (int frame = 0; frame < markers.frame_count(); ++frame) {
      const Vector3d d = markers.position(frame, pair.right) - markers.position(frame, pair.left);
      if (d.allFinite()) sum += d;
    }
  }
  return sum;
}

class Finder {
 public:
  explicit Finder(const AxisEvidence& evidence) : evidence_(evidence) {}

  LaboratoryAxes find() {
    find_up();
    if (axes_.up.known()) find_forward();
    return std::move(axes_);
  }

 private:
  bool has_markers() const {
    return evidence_.markers && evidence_.markers->frame_count() > 0 &&
           evidence_.markers->marker_count() > 0;
  }

  // The first that tells decides; the others may only disagree.
  static void consider(AxisDecision& decision, const AxisDecision& candidate, const char* what,
                       std::vector<std::string>& contradictions) {
    if (!candidate.known()) return;
    if (!decision.known()) {
      decision = candidate;
    } else if (candidate.axis != decision.axis) {
      contradictions.push_back(fmt::format("{} is {} by {}, but {} by {}", what,
                                           axis_name(decision.axis), decision.reason,
                                           axis_name(candidate.axis), candidate.reason));
      if (decision.confidence < 1.0) decision.confidence *= 0.8;
    }
  }

  void find_up() {
    std::vector<AxisDecision> candidates;
    if (evidence_.up) candidates.push_back({*evidence_.up, 1.0, "the option --up"});
    if (!evidence_.reaction.isZero()) {
      candidates.push_back(decide(evidence_.reaction, 0.98, "the forces that carry the subject"));
    }
    if (has_markers()) {
      const Vector3d upright = upright_by_names(*evidence_.markers);
      if (!upright.isZero()) {
        candidates.push_back(decide(upright, 0.95, "heads and trunks above feet"));
      }
    }
    if (evidence_.screen) {
      candidates.push_back(decide(evidence_.screen->y, 0.8, "POINT:Y_SCREEN"));
    }
    if (candidates.empty() && has_markers()) {
      candidates.push_back(up_by_extent(*evidence_.markers));
    }
    for (const AxisDecision& candidate : candidates) {
      consider(axes_.up, candidate, "up", axes_.contradictions);
    }
  }

  Vector3d horizontal(const Vector3d& v) const { return v - axes_.up.axis * axes_.up.axis.dot(v); }

  void find_forward() {
    if (evidence_.forward) {
      if (horizontal(*evidence_.forward).isZero()) {
        throw std::invalid_argument(fmt::format(
            "--forward {} is not at right angles to up, which is {} by {}: choose another axis",
            axis_name(*evidence_.forward), axis_name(axes_.up.axis), axes_.up.reason));
      }
      axes_.forward = {*evidence_.forward, 1.0, "the option --forward"};
      return;
    }
    if (has_markers()) {
      const Vector3d way = way_travelled(*evidence_.markers, axes_.up.axis);
      if (way.norm() > kLeastWay) {
        consider(axes_.forward, decide(way, 0.95, "the way that the markers go"), "forward",
                 axes_.contradictions);
      }
      const Vector3d facing = axes_.up.axis.cross(horizontal(rightward(*evidence_.markers)));
      if (!facing.isZero()) {
        consider(axes_.forward, decide(facing, 0.85, "left and right in the markers' names"),
                 "forward", axes_.contradictions);
      }
    }
    if (axes_.forward.known()) return;
    const bool x_is_up = axes_.up.axis.x() != 0.0;
    axes_.forward = {x_is_up ? Vector3d::UnitY() : Vector3d::UnitX(), 0.0,
                     "nothing tells it; kept as near as can be"};
  }

  const AxisEvidence& evidence_;
  LaboratoryAxes axes_;
};

}  // namespace

Eigen::Matrix3d LaboratoryAxes::rotation() const {
  if (!up.known() || !forward.known()) {
    throw std::logic_error("LaboratoryAxes::rotation: up or forward is not known");
  }
  Eigen::Matrix3d R_MW;
  R_MW.row(0) = forward.axis;
  R_MW.row(1) = up.axis;
  R_MW.row(2) = forward.axis.cross(up.axis);
  return R_MW;
}

LaboratoryAxes find_axes(const AxisEvidence& evidence) { return Finder(evidence).find(); }

std::optional<Vector3d> parse_axis(const std::string& text) {
  std::string_view rest = text;
  double sign = 1.0;
  if (rest.starts_with('+') || rest.starts_with('-')) {
    sign = rest.front() == '-' ? -1.0 : 1.0;
    rest.remove_prefix(1);
  }
  const std::string axis = text::lower(rest);
  if (axis.size() != 1 || axis[0] < 'x' || axis[0] > 'z') return std::nullopt;
  return Vector3d(sign * Vector3d::Unit(axis[0] - 'x'));
}

std::string axis_name(const Vector3d& axis) {
  Eigen::Index k = 0;
  axis.cwiseAbs().maxCoeff(&k);
  return std::string(axis[k] < 0.0 ? "-" : "") + static_cast<char>('x' + k);
}

void rotate_vectors(const Eigen::Matrix3d& R, RowMatrix& values) {
  for (Eigen::Index row = 0; row < values.rows(); ++row) {
    for (Eigen::Index column = 0; column + 2 < values.cols(); column += 3) {
      const Vector3d v = values.row(row).segment<3>(column);
      // 0 × NaN would spread; a rotation of whole axes keeps numbers exact.
      values.row(row).segment<3>(column) = v.allFinite() ? Vector3d(R * v) : v;
    }
  }
}

}  // namespace sinew
