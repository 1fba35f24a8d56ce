#pragma once

#include <vector>

#include "data/finding.h"
#include "data/foot_markers.h"
#include "data/force_signal.h"
#include "data/marker_trajectories.h"

namespace sinew {

struct TimingCheckOptions {
  double largest_shift = 0.5;  // that is looked for [s]: half a stride's time to the other foot
  // Speeds of a foot's slowest marker about which it comes to rest [m/s]; it swings with 2 to 5.
  double resting_speed = 0.3;
  // What the estimate is off by on recordings that are in step [s]: heels slow down before they
  // strike and slide after it. On published recordings of ten laboratories it is 38 ms at most.
  double tolerance = 0.045;
  // Correlation of a foot's rest with the force below which a contact tells nothing.
  double least_correlation = 0.6;
  // The centre of pressure is this near to the foot's markers [m]; see data/foot_assignment.h.
  double near = 0.25;

  /// Throws std::invalid_argument naming the field that is not above 0.
  void validate() const;
};

/// How one contact fits the foot that rests nearest to its centre of pressure.
struct ContactTiming {
  int contact = 0;           // index
  Side side = Side::kNone;   // of the foot
  double distance = 0.0;     // from the centre of pressure to its markers while it rests, mean [m]
  double shift = 0.0;        // by which the force comes late [s]
  double correlation = 0.0;  // of rest and force with this shift
};

/// Correlates each contact, as a function of time that is 1 while it is loaded, with that of the
/// foot, exp(−(v/v0)²) of the speed v of its slowest marker: both are 1 during a stance, and the
/// shift of the largest correlation puts one on the other. Only contacts with both ends in the
/// record. O(contacts · frames · shifts).
std::vector<ContactTiming> time_contacts(const MarkerTrajectories& markers,
                                         const std::vector<ForceContact>& contacts,
                                         const Eigen::Vector3d& up,
                                         const TimingCheckOptions& options = {});

/// Kind `clock`: forces that come early or late by the middle of all contacts: `--shift-forces`;
/// the surer the more contacts agree. Kind `place`: centres of pressure that are nowhere near a
/// foot: platforms and markers do not have the same axes or origin.
std::vector<Finding> find_clock_faults(const MarkerTrajectories& markers,
                                       const std::vector<ForceSignal>& signals,
                                       const Eigen::Vector3d& up,
                                       const TimingCheckOptions& options = {});

}  // namespace sinew
