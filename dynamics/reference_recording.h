#pragma once

#include "data/marker_trajectories.h"
#include "data/reference_walk.h"
#include "data/time_table.h"
#include "data/tool_setup.h"
#include "dynamics/marker_artifacts.h"
#include "model/musculoskeletal_model.h"

namespace sinew {

struct ReferenceRecordingOptions {
  double strides = 2.0;        // > 0
  double marker_rate = 100.0;  // [Hz]
  double force_rate = 1000.0;  // [Hz]
  MarkerArtifacts artifacts;   // of the markers; the forces stay exact

  /// Throws std::invalid_argument naming field, value and bound.
  void validate() const;
};

/// What a laboratory would record of a walk, and what it would give much to know.
struct ReferenceRecording {
  MusculoskeletalModel model;
  MarkerTrajectories markers;
  TimeTable forces;  // ground_force_r_vx … [N], …_px … [m], ground_torque_r_x … [N m];
                     // all of a foot's columns are 0 while it is in the air; as many samples in
                     // the last frame of the markers as in every other
  ExternalLoadsSetup loads;  // bound to the columns of `forces`
  // At the markers' times; every coordinate of the model [rad or m; 1/s; 1/s²]. Virtual links stand
  // where the wires' cost of inverse kinematics, eq. (38), is least for the bones' pose; they have
  // neither speed nor acceleration, which a link without mass does not need.
  TimeTable true_coordinates, true_speeds, true_accelerations;
  TimeTable true_forces;  // at the markers' times; labels and convention as generalized_forces,
                          // couplers ignored, virtual links left out
};

/// Makes the recording of a walk. The motion is given, with exact derivatives; what the floor must
/// do follows:
///  1. inverse dynamics without loads gives the wrench that moves the root, which nothing but the
///     floor can supply: its resultant is F, its moment about the world's origin M;
///  2. F acts at the centre of pressure c on the floor, c_x = M_z / F_y, c_z = −M_x / F_y, besides
///     the free moment about the vertical;
///  3. feet share the resultant, see share_wrench;
///  4. inverse dynamics with these loads gives the true torques; the root's are zero to rounding.
/// Throws InputError if the model or a curve cannot be used, std::invalid_argument for bad options
/// and if the floor would have to pull.
ReferenceRecording make_reference_recording(const MusculoskeletalModel& model,
                                            const ReferenceWalk& walk,
                                            const ReferenceRecordingOptions& options = {});
/// Of the embedded walk and the detailed whole body.
ReferenceRecording make_reference_recording(const ReferenceRecordingOptions& options = {});

/// Markers of the model standing still at its defaults, for a second: the static trial that models
/// are scaled to. Artifacts as in the walk.
MarkerTrajectories make_static_recording(const MusculoskeletalModel& model,
                                         const ReferenceRecordingOptions& options = {});

}  // namespace sinew
