#pragma once

#include <string>
#include <vector>

#include "data/verdict_reason.h"
#include "model/musculoskeletal_model.h"
#include "model/scaling.h"

namespace sinew {

/// What people are at most, relative to a model of an adult.
///
/// - Size, the factor of the whole body: models are 1.6 to 1.85 m tall. A child that has learnt to
///   walk is 0.71 m at least (WHO Child Growth Standards 2006, length for age at 12 months, 3rd
///   percentile); hardly anybody exceeds 2.25 m.
/// - A segment's factor along an axis over the size: lengths over stature vary by 3-6 % (standard
///   deviation; Drillis & Contini 1966, TR 1166.03), breadths and depths by as much again (ANSUR
///   II, Gordon et al. 2014, NATICK/TR-15/007), together 7 %; 3.5 of these hold 99.9 % of adults.
///   They hold children too: over the course of growth sitting height falls from 0.63 to 0.52 of
///   stature, trunks being up to 20 % longer and legs shorter than an adult's of that size.
/// - Markers on landmarks, along each axis: examiners differ by 6 to 21 mm (Della Croce et al.
/// 2005,
///   Gait Posture 21:226-237), which is 42 mm for 95 % of them at the worst of landmarks, and the
///   middle of a marker of 16 mm on a base sits 8 mm off the skin. Skin slides by 10 to 40 mm over
///   a landmark in movement (Leardini et al. 2005, Gait Posture 21:212-225), to both sides of where
///   it is on average.
/// - Markers on wands and in clusters: anywhere on a segment, the longest of which is 0.5 m.
struct SizeLimits {
  double smallest_size = 0.38, largest_size = 1.4;
  double smallest_ratio = 0.78, largest_ratio = 1.28;
  double marker_offset = 0.05;            // [m]
  double technical_marker_offset = 0.25;  // [m]

  /// Throws std::invalid_argument naming field, value and bound.
  void validate() const;
};

/// `size-limit`, of the whole body: `size` is its factor.
VerdictReason whole_size_reason(double size, const SizeLimits& limits);
/// `size-limit`, of a segment along `axis` (0, 1, 2; −1: all); `ratio` is its factor over the size.
VerdictReason segment_size_reason(const std::string& body, int axis, double ratio,
                                  const SizeLimits& limits);
/// `moved-marker`; `moved` [m] along an axis; `technical`: the names of those on wands and in
/// clusters, among which this one may be.
VerdictReason moved_marker_reason(const std::string& marker, double moved,
                                  const std::vector<std::string>& technical,
                                  const SizeLimits& limits);

/// Of factors from elsewhere, e.g. measurements of a ScaleTool setup: what lies beyond the limits.
/// The size is the middle one of all bodies' factors.
std::vector<VerdictReason> size_reasons(const MusculoskeletalModel& model,
                                        const ScaleFactors& factors, const SizeLimits& limits);

}  // namespace sinew
