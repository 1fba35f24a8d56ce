#pragma once

#include <string>
#include <vector>

#include "data/force_platform.h"
#include "data/numbers.h"
#include "data/time_table.h"

namespace sinew {

/// A force on the subject over time, of a platform or of columns of a table.
struct ForceSignal {
  std::string name;    // `platform 1`, `ground_force_r`
  int plate = 0;       // the platform's number; 0: a table's
  double rate = 0.0;   // [Hz]
  double start = 0.0;  // time of the first sample [s]
  RowMatrix force;     // samples × 3 [N]
  RowMatrix center;    // samples × 3 [m]; NaN where nothing presses

  int sample_count() const { return static_cast<int>(force.rows()); }
  double time(Eigen::Index sample) const { return start + static_cast<double>(sample) / rate; }
};

/// Of every platform that can be used, time 0 at the first frame.
std::vector<ForceSignal> force_signals(const std::vector<ForcePlatformRecording>& plates);

/// Of every three columns BASEvx, BASEvy, BASEvz with BASEpx, BASEpy, BASEpz as OpenSim's external
/// loads name them; centres count where the force is at least `threshold` [N]. None for a table
/// whose times do not step evenly.
std::vector<ForceSignal> force_signals(const TimeTable& table, double threshold);

/// A time that something presses, with ends where the force along `up` crosses limits.
struct ForceContact {
  int signal = 0;               // index
  double from = 0.0, to = 0.0;  // [s], between samples by straight lines
  bool begins = true,
       ends = true;        // within the record; else it is loaded at its first or last sample
  double peak = 0.0;       // along `up` [N]
  Eigen::Vector3d center;  // mean centre of pressure, weighted by force; NaN if unknown
};

struct ForceContactOptions {
  // A contact begins where the force rises to this and ends where it has fallen below `release`,
  // so that noise about one limit makes no steps [N]. 20 N is what laboratories use.
  double threshold = kContactForce, release = 0.5 * kContactForce;
  double shortest = 0.05;    // [s]; a rebound of the heel lasts less
  double least_peak = 50.0;  // [N]; a lower one is no step

  /// Throws std::invalid_argument naming field, value and bound.
  void validate() const;
};

/// All contacts of all signals, by signal and time. O(samples).
std::vector<ForceContact> find_contacts(const std::vector<ForceSignal>& signals,
                                        const Eigen::Vector3d& up,
                                        const ForceContactOptions& options = {});

}  // namespace sinew
