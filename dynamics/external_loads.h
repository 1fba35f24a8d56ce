#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "data/input_error.h"
#include "data/time_table.h"
#include "data/tool_setup.h"
#include "model/musculoskeletal_model.h"
#include "model/simbody.h"
#include "model/simbody_model.h"

namespace sinew {

struct ExternalLoadsOptions {
  /// Zero-lag low-pass of the loads themselves [Hz]; negative: none, as in OpenSim. A load with a
  /// point is filtered as force and moment about the origin of the frame that force and point are
  /// given in, never as a point, which jumps whenever a foot leaves the plate.
  double cutoff = -1.0;

  /// Throws std::invalid_argument naming field, value and bound.
  void validate() const;
};

/// Measured forces and torques on bodies, as functions of time. Between samples they follow the
/// cubic natural spline through the samples (from 4 samples on; straight lines for 2 or 3, a
/// constant for one), each of the nine components by itself, as in OpenSim's ExternalForce.
/// Immutable; evaluation allocates nothing.
class ExternalLoads {
 public:
  /// No loads at all, at any time.
  ExternalLoads() = default;

  /// Finds bodies and columns of every force in `setup` that applies.
  /// A point that is NaN while its force is exactly zero is filled from its neighbours in time,
  /// with a warning: such a point acts on nothing. Of two identical rows at one time the second is
  /// dropped, with a warning.
  /// Throws InputError naming file and line for an unknown body or frame, a missing column, two
  /// different rows at one time, and any other value that is not finite, with row and column; and
  /// for a low-pass of a load whose force and point are given in different frames.
  ExternalLoads(const MusculoskeletalModel& model, const ExternalLoadsSetup& setup,
                const TimeTableFile& data, const ExternalLoadsOptions& options = {});

  /// One load at one time, in the frames the recording has it in.
  struct Sample {
    int body = 0;         // acts on this body
    int force_frame = 0;  // body in whose axes force and torque are given
    int point_frame = 0;  // body from whose origin and in whose axes the point is given
    Eigen::Vector3d force = Eigen::Vector3d::Zero();   // [N]
    Eigen::Vector3d point = Eigen::Vector3d::Zero();   // [m]
    Eigen::Vector3d torque = Eigen::Vector3d::Zero();  // [N m]
  };

  int size() const { return static_cast<int>(loads_.size()); }
  /// Whether load 0 … size() − 1 acts at a point of its own, rather than at its body's origin.
  bool has_point(int load) const { return loads_[static_cast<std::size_t>(load)].has_point; }
  const std::vector<Warning>& warnings() const { return warnings_; }

  /// Throws InputError unless the recording covers from … to [s], to half its mean step.
  void require_coverage(double from, double to) const;

  /// load: 0 … size() − 1. Beyond the record's ends the last polynomial continues.
  Sample sample(int load, double t) const;

  /// Adds all loads at time t to F_B_W: one spatial force a mobilized body, [moment about the
  /// body's origin; force], in ground. `state` must be realized to Position. O(loads).
  void add_body_forces(double t, const SimbodyModel& compiled, const SimTK::State& state,
                       SimTK::Vector_<SimTK::SpatialVec>& F_B_W) const;

 private:
  struct Load {
    Sample frames;  // body and frames; the rest unused
    bool has_point = false;
    int line = 0;  // in the setup
  };
  static constexpr int kComponents = 9;  // force, point, torque

  void bind(const MusculoskeletalModel& model, const ExternalLoadsSetup& setup,
            const ExternalForce& force, const TimeTableFile& data, TimeTable& samples);
  void filter(const ExternalLoadsSetup& setup, double cutoff, TimeTable& samples);
  void fit(const TimeTable& samples);

  std::vector<Load> loads_;
  std::vector<Warning> warnings_;
  SourceLocation data_source_;
  double first_time_ = 0.0, last_time_ = 0.0, mean_step_ = 0.0;
  int terms_ = 0;           // coefficients of each polynomial: 4, 2 or 1
  Eigen::VectorXd time_;    // starts of the intervals and the end of the last [s]
  RowMatrix coefficients_;  // terms·intervals × 9·loads
};

}  // namespace sinew
