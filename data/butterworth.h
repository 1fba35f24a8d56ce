#pragma once

#include <Eigen/Core>

#include "data/time_table.h"

namespace sinew {

/// The third-order low-pass Butterworth filter as a difference equation,
///   y_n = Σ_{k=0}^{3} feedforward[k] x_{n−k} − Σ_{k=1}^{3} feedback[k] y_{n−k},
/// from the bilinear transform of 1/((s + 1)(s² + s + 1)) with the cutoff prewarped, so that one
/// pass has gain 1/√2 at the cutoff and two passes have 1/2.
struct ButterworthCoefficients {
  Eigen::Vector4d feedforward, feedback;  // feedback[0] = 1
};

/// rate, cutoff [Hz]. Throws std::invalid_argument unless 0 < cutoff < rate/2.
ButterworthCoefficients third_order_butterworth(double rate, double cutoff);

/// Filters every column forward and backward, so that nothing is delayed. Each pass starts with its
/// first three samples unfiltered, as OpenSim's Signal::LowpassIIR does; pad first.
/// columns: frames × any number. Throws std::invalid_argument for fewer than 4 frames.
void filter_forward_and_backward(const ButterworthCoefficients& filter,
                                 Eigen::Ref<Eigen::MatrixXd> columns);

/// Puts `count` rows before and after the table's own: its rows reflected through its end points in
/// time and value, which keeps value and slope. OpenSim's Storage::pad.
/// Throws std::invalid_argument unless 0 ≤ count < rows.
TimeTable pad_by_reflection(const TimeTable& table, int count);

/// The table at equal steps of its smallest time step, from quintic natural splines through its
/// columns; the table itself if its steps already agree to 1e-9 of a step. At most 100,000 rows,
/// for which the step grows. OpenSim's Storage::resample. Throws std::invalid_argument for fewer
/// than 6 rows, time that does not increase strictly, or a value that is not finite, naming row and
/// column.
TimeTable resample_uniformly(const TimeTable& table);

/// Zero-lag low-pass of all columns with OpenSim's conventions for coordinates: half the record is
/// reflected to each end, the padded record resampled uniformly if it is not uniform, and filtered
/// forward and backward. The result keeps the padding, so that a spline through it has its ends far
/// from the record's. cutoff [Hz]. O(rows · columns).
/// Throws std::invalid_argument, naming values and remedy, for fewer than 4 rows, a cutoff that is
/// not positive or not below half the sampling rate (OpenSim lowers it silently to 0.49 of the
/// rate), NaN, or time that does not increase.
TimeTable lowpass_with_padding(const TimeTable& table, double cutoff);

}  // namespace sinew
