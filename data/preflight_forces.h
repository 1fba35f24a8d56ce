#pragma once

#include <vector>

#include "data/c3d_file.h"
#include "data/finding.h"
#include "data/force_platform.h"
#include "data/force_signal.h"

namespace sinew {

struct ForceCheckOptions {
  // A flat top has at least this many equal samples; a smooth peak of a converter with few bits has
  // as many, but falls off slowly beside them.
  int least_flat = 4;
  // Beside it, within half its length, the channel falls by this many of its smallest steps: a
  // parabola that is flat to one step has fallen by four of them there.
  double steps_beside = 12.0;
  // ... and by this part of its range.
  double range_beside = 0.02;
  // At 100 N, 5 N more or less move the centre of pressure by 5 % of its way from the middle, and
  // they turn the hip by 5 N·m.
  double offset = 5.0;  // [N]
  // An unloaded stretch is at least this long [s], and quieter than this [N].
  double quiet_time = 0.1, quiet = 5.0;
  // Below this rate forces do not show a heel strike [Hz].
  double least_rate = 200.0;

  /// Throws std::invalid_argument naming the field that is not above 0.
  void validate() const;
};

/// Samples first … first + count − 1 at exactly the largest or smallest value of a channel, with
/// steep flanks: the converter or amplifier was at its end.
struct FlatTop {
  Eigen::Index first = 0, count = 0;  // of the longest
  int stretches = 0;
  double value = 0.0;
};

/// Flat tops at both ends of a channel's range. What stays near zero is an unloaded platform. With
/// `at_limit`, the channel's ends of the converter's range, a value there counts however often it
/// is met; else one met in more than half of all samples is how the channel rests.
std::vector<FlatTop> find_flat_tops(const Eigen::VectorXd& samples,
                                    const std::vector<double>& limits,
                                    const ForceCheckOptions& options = {});

/// Kind `saturation`: flat tops of a platform's channels, errors at the end of the converter's
/// range (ANALOG:BITS, OFFSET, SCALE). The contact's forces are of no use: `--assign PLATE:none@…`.
std::vector<Finding> find_saturation(const C3dFile& file,
                                     const std::vector<ForcePlatformRecording>& plates,
                                     const ForceCheckOptions& options = {});

/// A stretch of samples in which a platform carries nothing.
struct UnloadedStretch {
  Eigen::Index first = 0, count = 0;
  Eigen::Vector3d force = Eigen::Vector3d::Zero();  // mean [N]
};

/// Stretches in which the force is small against its peak, quiet and long enough, in order of time.
/// None where the platform is loaded all the time. O(samples).
std::vector<UnloadedStretch> find_unloaded(const ForcePlatformRecording& plate,
                                           const ForceCheckOptions& options = {});

/// Kind `baseline`: an unloaded platform that shows a force, an error from `threshold` [N] on, for
/// then it seems loaded all the time: `--zero-plates PLATE@FROM-TO`; and one whose baseline drifts,
/// with two such times. Notes of platforms that are never unloaded.
std::vector<Finding> find_baseline_faults(const ForcePlatformRecording& plate, double threshold,
                                          const ForceCheckOptions& options = {});

/// Kind `rate`: channels of platforms that are sampled too slowly.
std::vector<Finding> find_force_rate_faults(const C3dFile& file,
                                            const ForceCheckOptions& options = {});

}  // namespace sinew
