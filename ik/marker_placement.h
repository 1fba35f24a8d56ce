#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "data/marker_trajectories.h"
#include "data/tool_setup.h"
#include "ik/cold_start.h"
#include "ik/minimizer.h"
#include "ik/tracking.h"
#include "model/musculoskeletal_model.h"

namespace sinew {

struct MarkerPlacementOptions {
  std::optional<double> from, to;  // the part of the static trial that is averaged [s]
  // Weight of markers without a task that applies. OpenSim's is 1; 0 leaves them out of the pose.
  double default_weight = 1.0;
  // Warn of markers that move more than this along an axis within the range [m].
  std::optional<double> max_marker_movement;
  bool move_markers = true;  // else only the pose is found
  MinimizerOptions minimizer;
  ColdStartOptions cold_start;

  /// Throws std::invalid_argument naming field, value and bound.
  void validate() const;
};

/// What became of one marker of the model.
struct PlacedMarker {
  enum class Fate {
    kMoved,
    kFixed,        // the model says that it stays
    kNotMeasured,  // in the recording, but never seen within the range; stays
    kRemoved,      // not in the recording at all
  };

  std::string name;
  Fate fate = Fate::kMoved;
  double weight = 0.0;
  double distance = kNaN;  // from the model's marker to the measured one in the pose found [m]
};

struct MarkerPlacementResult {
  MusculoskeletalModel model;         // with its markers moved, those without a recording removed
  Eigen::VectorXd coordinates;        // the static pose [rad or m]
  double time = kNaN;                 // first frame of the range [s]
  int frames = 0;                     // averaged
  std::vector<PlacedMarker> markers;  // as the model's were
  double marker_rms = kNaN;           // before moving, over the weighted markers [m]
  double marker_max = kNaN;           // likewise [m]
  std::string worst_marker;
  Termination termination = Termination::kNone;  // of finding the pose
  ColdStartResult search;                        // likewise
  std::vector<Warning> warnings;
};

/// The mean of a static trial bound to a model: one frame of inverse kinematics.
struct BoundPlacement {
  MarkerFile mean;
  TrackingProblem tracking;
};

/// What place_markers() finds the pose from, with its arguments.
BoundPlacement bind_placement(const MusculoskeletalModel& model, const KinematicTree& tree,
                              const MarkerFile& trial, const IkTaskSet* tasks,
                              const RowMatrix* coordinate_values,
                              const MarkerPlacementOptions& options);

/// OpenSim's MarkerPlacer: averages the static trial, finds the pose by weighted least squares on
/// the markers and coordinate tasks, lowest of several starts (ColdStart), and moves every marker
/// that is not fixed to where it was measured. The default pose of the model stays. As in OpenSim,
///
///     ½ Σ w_m |Δp_m|² / Σ w_m + ½ Σ w_c Δq_c²
///
/// is minimized, over the measured markers m and the coordinate tasks c.
///
/// `coordinate_values`: 1 × coordinates of the model, for tasks that take them from a file [rad or
/// m], NaN where there is none; or null. Throws InputError if the recording has no marker of
/// the model. Time: one frame of inverse kinematics.
MarkerPlacementResult place_markers(const MusculoskeletalModel& model, const MarkerFile& trial,
                                    const IkTaskSet* tasks, const RowMatrix* coordinate_values,
                                    const MarkerPlacementOptions& options = {});

/// One frame: the mean of each marker over the frames first … last in which it is measured, at the
/// time of the first.
MarkerTrajectories average_frames(const MarkerTrajectories& markers, int first, int last);

}  // namespace sinew
