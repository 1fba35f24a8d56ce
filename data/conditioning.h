#pragma once

#include <string>
#include <vector>

#include "data/marker_trajectories.h"

namespace sinew {

/// Frames or rows `first` … `end` − 1, times and frame numbers as they are.
MarkerTrajectories slice(const MarkerTrajectories& markers, int first, int end);
TimeTable slice(const TimeTable& table, int first, int end);

/// Zero-lag low-pass of every marker by the filter that coordinates get (data/butterworth.h), each
/// measured stretch by itself with half of it reflected to its ends; gaps stay gaps. Frames are
/// taken to lie at equal steps of the rate. Stretches of fewer than 6 frames stay as they are;
/// returned is how many samples that concerns.
/// cutoff [Hz]. Throws std::invalid_argument unless 0 < cutoff < rate/2.
int lowpass(MarkerTrajectories& markers, double cutoff);

/// The same for tables, whose steps must agree to 1 %.
/// Throws std::invalid_argument for these, fewer than 6 rows, NaN and the cutoff.
void lowpass(TimeTable& table, double cutoff);

/// The recording at another rate [Hz], from its first time on, by the cubic natural spline through
/// each measured stretch; between stretches there is nothing. Frames are numbered from 1. Nothing
/// is filtered: low-pass below half of the new rate first.
/// Throws std::invalid_argument unless rate > 0.
MarkerTrajectories resample(const MarkerTrajectories& markers, double rate);
TimeTable resample(const TimeTable& table, double rate);

/// The table's values at other times by the same splines; NaN outside of its stretches.
RowMatrix values_at(const Eigen::VectorXd& time, const RowMatrix& values,
                    const Eigen::VectorXd& new_time, int columns_that_belong_together = 1);

/// Rows per second of a table whose steps agree to 1 %; throws std::invalid_argument naming the
/// first step that does not.
double uniform_rate(const TimeTable& table);

}  // namespace sinew
