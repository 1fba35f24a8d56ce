#pragma once

#include <vector>

#include "data/marker_trajectories.h"

namespace sinew {

/// What no marker on a person does.
struct MarkerSpikeOptions {
  // A spike lies at least this far from where its neighbours in time lead [m]: less is within what
  // cameras and skin do, and filters take it away.
  double least = 0.05;
  // ... and farther than this times what the marker turns aside from a straight line, from frame
  // to frame, within `around` beside the spike: a racket or a club that is hit does so before and
  // after, too.
  double times_usual = 4.0, around = 0.15;  // [1], [s]
  // It is back after this [s]: what stays longer may be there.
  double longest = 0.1;
  // What jumps to farther than this from the middle of all markers is on no person, however long
  // it stays there [m].
  double away = 3.0;
  // No laboratory follows people who are that far apart: what is there is left out even where it
  // stays for the whole record [m].
  double absurd = 10.0;
  // Faster than any throw or kick between two samples of a marker that is seldom seen [m/s].
  double fastest = 60.0;

  /// Throws std::invalid_argument naming the field that is not above 0.
  void validate() const;
};

/// Frames first … last, in all of which a marker is measured where it cannot have been.
struct MarkerSpike {
  int marker = 0, first = 0, last = 0;
  double distance = 0.0;  // largest, from where it must have been [m]

  bool operator==(const MarkerSpike&) const = default;
};

/// Spikes, marker by marker: the marker leaves where its last two samples send it and comes back to
/// where the two before and the two after meet, so that nothing but the samples in between is at
/// odds. At the ends of what is measured, and beside gaps, up to three samples count that are
/// four times as far off. Markers that go where others were (find_marker_swaps()) are among them.
/// A marker that is `away` for more than half of its samples is no spike (find_stray_markers())
/// unless it is absurdly far. Nothing is found where the markers' middle distance from their middle
/// is more than a person's size: the unit is wrong then (data/preflight_units.h).
/// O(frames · markers · frames within `longest`), the last only where a marker jumps.
std::vector<MarkerSpike> find_marker_spikes(const MarkerTrajectories& markers,
                                            const MarkerSpikeOptions& options = {});

/// Makes gaps of these samples.
void leave_out(MarkerTrajectories& markers, const std::vector<MarkerSpike>& spikes);

}  // namespace sinew
