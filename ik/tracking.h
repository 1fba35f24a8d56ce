#pragma once

#include <Eigen/Core>
#include <functional>
#include <string>
#include <vector>

#include "data/marker_trajectories.h"
#include "data/time_table.h"
#include "data/tool_setup.h"
#include "ik/cold_start.h"
#include "ik/minimizer.h"
#include "ik/residuals.h"
#include "ik/wire_binding.h"
#include "model/kinematic_tree.h"
#include "model/musculoskeletal_model.h"

namespace sinew {

/// A marker that is tracked: its column in the recording and its place in the model.
struct TrackedMarker {
  std::string name;
  int recorded = -1;  // index into MarkerTrajectories::names
  int model = -1;     // index into MusculoskeletalModel::markers
  double weight = 1.0;
};

/// A coordinate that is pulled towards values.
struct TrackedCoordinate {
  int coordinate = -1;
  double weight = 1.0;         // where all markers are seen
  double value = 0.0;          // [rad or m], where `values` is empty
  std::vector<double> values;  // one a frame of the recording
  // Stands beside the mean of the markers, not their sum: in each frame it weighs by what is seen.
  bool beside_mean = false;
};

/// Model, recording and tasks bound together: which residuals there are and what each frame asks.
struct TrackingProblem {
  IkProblem problem;
  std::vector<TrackedMarker> markers;          // problem.positions in order
  std::vector<TrackedCoordinate> coordinates;  // problem.coordinates in order
  std::vector<TrackedWire> wires;              // problem.wires in order
  // Frames of the recording × markers: what each sample's weight is multiplied by; empty: 1.
  RowMatrix marker_scales;
  // Likewise, whether a position was filled in, so that it counts in the cost but in no error;
  // empty: none was.
  Eigen::Array<bool, Eigen::Dynamic, Eigen::Dynamic> filled;
  std::vector<int> virtual_links;  // bodies of the model
  std::vector<Warning> warnings;   // unmatched markers, tasks without effect, …
};

struct BindingOptions {
  // Weight of welds and point constraints that close loops [1/m², 1/rad²]: 1e6 times a marker's,
  // which keeps loops closed to a thousandth of the marker error at most.
  double loop_weight = 1e6;
  WireOptions wires;
  // What the weight of a coordinate task stands beside. OpenSim divides the markers' part of the
  // cost by the sum of the weights of the markers seen in the frame, so that a task's weight does
  // not depend on how many there are; here the markers' part stays and the task's weight is
  // multiplied by that sum, which has the same minimum. Targets of our own stand beside the sum: a
  // weight of 1/rad² is to a radian what a marker of weight 1 is to a metre.
  enum class TaskScale { kMarkerMean, kMarkerSum };
  TaskScale task_scale = TaskScale::kMarkerMean;
  // Warn of markers that only the model or only the recording has; off where that is known already.
  bool name_unmatched = true;
};

/// Without tasks every marker that model and recording share has weight 1. With tasks, as in
/// OpenSim, only markers that a task names are tracked. Coordinate tasks take their value from the
/// task, from the model's default, or from `coordinate_values` (frames × coordinates of the model,
/// NaN where there is none). Paths become wires as BindingOptions::wires says, and virtual links
/// are drawn to their places. Throws InputError if no marker is left to track, or if a task takes
/// its values from a file and there is none.
TrackingProblem bind_recording(const MusculoskeletalModel& model, const KinematicTree& tree,
                               const MarkerFile& recording, const IkTaskSet* tasks,
                               const RowMatrix* coordinate_values,
                               const BindingOptions& options = {});

/// Writes what frame `frame` asks for. Coordinates that stand beside the markers' mean get the
/// scale Σ s_m w_m / Σ w_m, of the markers m seen in the frame over all tracked, s_m a filled
/// sample's scale (one that weighs nothing is as one that is missing). In a frame without any
/// marker their weights stand for themselves, as nothing is there to weigh them against.
void set_targets(const TrackingProblem& tracking, const MarkerTrajectories& markers, int frame,
                 IkTargets& targets);

struct TrackingOptions {
  MinimizerOptions minimizer;
  ColdStartOptions cold_start;
  bool unrelated_frames = false;        // no frame follows from the one before: each starts cold
  int first_frame = 0, end_frame = -1;  // [first, end); −1: to the last
  int threads = 0;                      // 0: all cores
  /// Called from time to time with the number of frames done; return false to stop early.
  std::function<bool(int done, int total)> progress;

  void validate() const;
};

struct FrameResult {
  Termination termination = Termination::kNone;
  int iterations = -1, evaluations = -1;
  double cost = kNaN;
  double bound_push = kNaN;  // Summary's
  double seconds = kNaN;     // of the descent that ended there
  double marker_rms = kNaN;  // over the markers measured in this frame [m]
  double marker_max = kNaN;  // [m]
  int worst_marker = -1;     // index into TrackingProblem::markers
  int measured_markers = 0;
  std::vector<IterationRow> rows;  // filled where the minimizer's options ask for them
};

/// A frame that was started cold, and what the search for its minimum found.
struct SearchedFrame {
  int frame = -1;  // relative to the first one
  ColdStartResult search;
};

struct TrackingResult {
  Eigen::VectorXd time;     // frames [s]
  RowMatrix coordinates;    // frames × coordinates of the model [rad or m]
  RowMatrix marker_errors;  // frames × tracked markers [m], NaN where not measured or filled in
  RowMatrix wire_lengths;   // frames × tracked wires [m]
  RowMatrix furcations;     // frames × 3·virtual links: p_WV of their origins [m]
  std::vector<FrameResult> frames;
  std::vector<SearchedFrame> searched;
  int looked_again = 0, lowered = 0;  // doubtful frames that were searched anew; that ended lower
  double seconds = kNaN;              // wall time of solving
  bool stopped = false;               // `progress` asked to stop; results are not complete
};

/// Solves every frame of
///
///     min ½ ( Σ s_m w_m |Δp_m|² + Σ (Σ s_m w_m) w_c Δq_c² + Σ w_o Δq_o² + Σ w_l max{0, l − l^d}² )
///
/// over markers m, coordinate tasks c, targets of our own o and wires l. The first frame starts
/// cold, see ColdStart, the others from the solution before them. The recording is cut into pieces
/// of fixed length; their first frames are solved one after the other, the pieces in parallel.
/// Where the end of a piece leads to another minimum than the next one begins with, the frame is
/// searched anew and the lower minimum followed both ways; so it is where a solution is doubtful,
/// see look_again(). The results depend on the recording only, never on the number of threads.
TrackingResult track(const MusculoskeletalModel& model, const KinematicTree& tree,
                     const TrackingProblem& tracking, const MarkerTrajectories& markers,
                     const TrackingOptions& options);

/// A cost that is rounding: a distance of 1e-5 mm on every tracked marker.
double cost_noise(const TrackingProblem& tracking);

/// Errors of the tracked markers at given coordinates, by the same rules as track(): what compares
/// another program's solution with ours. coordinates: frames × coordinates of the model.
TrackingResult evaluate_coordinates(const MusculoskeletalModel& model, const KinematicTree& tree,
                                    const TrackingProblem& tracking,
                                    const MarkerTrajectories& markers, int first_frame,
                                    const RowMatrix& coordinates);

/// Coordinates that the tracked markers and tasks leave undetermined at a pose: unknowns in the
/// null space of JᵀΣJ, i.e. those whose entry in an eigenvector with eigenvalue below 1e-10 times
/// the largest exceeds 1e-3. Returns indices of coordinates of the model, dependent ones included.
std::vector<int> undetermined_coordinates(const MusculoskeletalModel& model,
                                          const KinematicTree& tree,
                                          const TrackingProblem& tracking, const IkTargets& targets,
                                          std::span<const double> q);

}  // namespace sinew
