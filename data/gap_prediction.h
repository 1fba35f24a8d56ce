#pragma once

#include <optional>
#include <vector>

#include "data/gap_filling.h"

namespace sinew {

/// Where a marker is guessed to have been in the frames of a gap.
struct GapPrediction {
  Eigen::MatrixX3d p_WM;  // frames of the gap × 3 [m]
  double misfit = 0.0;    // rigid: RMS by which its helpers moved among each other [m]
  std::vector<int> from;  // rigid: these helpers
};

/// Predicts markers where they are not measured, and, to know how well, where they are: the frames
/// of a `gap` are never looked at. The recording and the options must outlive it.
class GapPredictor {
 public:
  /// `measured`: the recording as it was, nothing filled.
  GapPredictor(const MarkerTrajectories& measured, const GapFillOptions& options);

  /// By the cubic natural spline through up to ten frames on each side, which end at a frame that
  /// is not measured; nothing where there are fewer than two on a side. At the record's ends, for a
  /// fiftieth of a second at most, by the parabola of least squares through the six frames beside
  /// it: nothing where there are fewer, and nothing farther on.
  std::optional<GapPrediction> by_spline(const MarkerGap& gap) const;

  /// From markers of the same segment, best first, seven at most; see fill_gaps(). Nothing where
  /// fewer than three of them, or three in one line, are measured along or misfit too much, and of
  /// a marker that is measured in fewer than ten frames.
  std::optional<GapPrediction> rigidly(const MarkerGap& gap);

  /// RMS distance of the same prediction, in gaps as long (a rigid one's of a second at most, and
  /// shorter ones, down to a quarter, where none is measured for so long), from what was measured:
  /// up to four such gaps before `gap` and four behind it, the nearest that the marker was measured
  /// in. NaN where there is none [m].
  double spline_error(const MarkerGap& gap) const;
  double rigid_error(const MarkerGap& gap, const std::vector<int>& helpers) const;

 private:
  // Which of the frames beside a gap are measured.
  struct Sides {
    bool before, behind;
  };

  bool is_measured(int frame, int marker) const;
  std::vector<int> neighbours(const MarkerGap& gap, Sides sides) const;
  std::optional<GapPrediction> spline(const MarkerGap& gap, Sides sides) const;
  std::optional<GapPrediction> parabola(const MarkerGap& gap, const std::vector<int>& frames) const;
  double distance_deviation(int a, int b) const;
  bool same_segment(int a, int b) const;
  const std::vector<int>& helpers(int marker);
  std::vector<MarkerGap> measured_alike(const MarkerGap& gap, int count) const;
  Sides sides_of(const MarkerGap& gap) const;
  int measured_count(int marker) const;
  double rigid_error_of_cuts(const MarkerGap& gap, const std::vector<int>& helpers,
                             int count) const;
  std::optional<GapPrediction> carried(const MarkerGap& gap, Sides sides,
                                       const std::vector<int>& helpers, int step = 1) const;

  const MarkerTrajectories& measured_;
  const GapFillOptions& options_;
  std::vector<std::optional<std::vector<int>>> helpers_;
};

}  // namespace sinew
