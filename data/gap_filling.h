#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "data/marker_trajectories.h"

namespace sinew {

/// Frames first … first + count − 1 in which a marker is not measured.
struct MarkerGap {
  int marker = 0, first = 0, count = 0;

  bool operator==(const MarkerGap&) const = default;
};

/// All gaps, marker by marker; those at the ends of the record too.
std::vector<MarkerGap> find_gaps(const MarkerTrajectories& markers);

struct GapFillOptions {
  double max_gap = 0.0;      // longest that a spline fills [s]; 0 = none
  bool rigid = false;        // fill from other markers of the same segment, gaps of any length
  double max_misfit = 0.01;  // RMS by which these may have moved among each other [m]
  // Markers of each segment, as indices. Where empty, those that keep their distances to the
  // marker are found in the recording itself.
  std::vector<std::vector<int>> segments = {};

  /// Throws std::invalid_argument naming field, value and bound.
  void validate() const;
};

struct FilledGap {
  enum class Method { kSpline, kRigid, kNone };

  MarkerGap gap;
  Method method = Method::kSpline;
  // How far such a fill is off: RMS distance of the same prediction from what was measured, in up
  // to eight stretches as long of the same marker, the nearest ones that are measured (leave-out);
  // not less than a rigid one's misfit. NaN where none is long enough [m].
  double error = 0.0;
  std::vector<int> from;  // rigid: the markers it was taken from

  bool operator==(const FilledGap&) const = default;
};

struct GapFillResult {
  std::vector<FilledGap> filled;
  std::vector<MarkerGap> left;
};

/// Fills gaps in place, and says of every one how and how well, or that it was left.
///
/// Rigid: three or more other markers of the segment, not in one line, are measured in the gap and
/// in the last frame before or the first behind it. The motion that carries them best from there
/// (least squares; Kabsch 1976) carries the marker; with both ends, the two are blended linearly
/// in time, so that the ends join. Left where the misfit exceeds max_misfit, and where the marker
/// is measured in fewer than ten frames of the record.
/// Spline: the cubic natural spline through up to ten measured frames on each side, at least two.
/// Beyond what is measured, at the record's ends, a parabola goes on for 0.02 s at most; longer
/// ones are never guessed from the marker itself. Where both can be had, the one with the smaller
/// estimated error is taken, a known one before an unknown, and rigid where neither is known. Only
/// measured samples are ever used, never filled ones. O(gaps · (length + frames)). Throws
/// std::invalid_argument for options out of bounds.
GapFillResult fill_gaps(MarkerTrajectories& markers, const GapFillOptions& options);

/// A row a gap: marker, first and last frame, times [s], method, `none` where it stays, estimated
/// error [m], and the markers it was taken from.
std::string filled_gaps_csv(const MarkerTrajectories& markers, const GapFillResult& result);

/// Reads such a list for the recording that was filled. Throws InputError naming the line for other
/// files and for markers, frames, methods and errors that it cannot have.
std::vector<FilledGap> read_filled_gaps(const std::filesystem::path& path,
                                        const MarkerTrajectories& markers);

}  // namespace sinew
