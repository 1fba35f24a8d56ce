#pragma once

#include <Eigen/Core>
#include <vector>

namespace sinew {

struct SampleSpikeOptions {
  // A spike is at most this many samples long: a loose plug, a switched lamp, a lost bit.
  int longest = 3;
  // It leaves its neighbours by more than this part of the channel's usual range, between the
  // hundredth and the ninety-ninth of a hundred values ...
  double part_of_range = 0.25;
  // ... and by this times the steps beside it, which are large where a heel strikes.
  double times_usual = 8.0;
  // Below this rate an impact fits between two samples: only what leaves the range by this many
  // times it is a spike.
  double least_rate = 200.0, times_range = 5.0;  // [Hz]
  // No force is this many times the channel's range: it is wild however long it lasts.
  double wild = 1000.0;

  /// Throws std::invalid_argument naming the field that is not above 0.
  void validate() const;
};

/// Samples first … last of a channel that cannot have been.
struct SampleSpike {
  Eigen::Index first = 0, last = 0;
  double value = 0.0;  // the farthest off

  bool operator==(const SampleSpike&) const = default;
};

/// Spikes of a channel of a force platform, or of a column of forces, at `rate` [Hz]: samples that
/// leave the line between the samples beside them and come back to it, and values that are not
/// finite or beyond all measure. `wild_only` looks for the last two: for centres of pressure, which
/// jump by themselves. O(samples · log samples).
std::vector<SampleSpike> find_sample_spikes(const Eigen::VectorXd& samples, double rate,
                                            bool wild_only = false,
                                            const SampleSpikeOptions& options = {});

/// Goes straight from the sample before a spike to the one behind it, level at the record's ends.
/// Nothing changes where no other sample is finite.
void bridge_samples(Eigen::Ref<Eigen::VectorXd, 0, Eigen::InnerStride<>> samples,
                    Eigen::Index first, Eigen::Index last);

}  // namespace sinew
