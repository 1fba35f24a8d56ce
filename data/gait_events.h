#pragma once

#include <string>
#include <vector>

#include "data/c3d_file.h"
#include "data/foot_markers.h"
#include "data/force_signal.h"
#include "data/marker_trajectories.h"
#include "data/numbers.h"

namespace sinew {

/// A foot that strikes the floor or leaves it.
struct GaitEvent {
  enum class Kind { kHeelStrike, kToeOff };

  Kind kind = Kind::kHeelStrike;
  Side side = Side::kNone;  // kNone: nothing tells
  double time = 0.0;        // [s]; by forces if there, else by the file, else by kinematics
  int plate = 0;            // the platform's number; 0: none, or a table's force
  // When each source says; NaN where it says nothing.
  double by_forces = kNaN;
  double by_file = kNaN;
  double by_kinematics = kNaN;

  bool operator==(const GaitEvent&) const = default;
};

const char* to_string(GaitEvent::Kind kind);  // `heel strike`, `toe off`
const char* to_string(Side side);             // `left`, `right`, empty

/// When forces rise to a threshold and fall below another (ForceContactOptions). The side is that
/// of the foot whose markers are nearest to the centre of pressure in the contact's middle frames,
/// within 0.25 m; none where no foot is named or both are as near. Contacts of one foot on several
/// platforms that overlap are one. A contact that the record cuts has one event. By time.
/// O(samples + contacts · frames).
std::vector<GaitEvent> events_from_forces(const std::vector<ForceSignal>& signals,
                                          const MarkerTrajectories* markers,
                                          const Eigen::Vector3d& up,
                                          const ForceContactOptions& options = {});

struct KinematicEventOptions {
  enum class Method {
    kAuto,          // kCoordinates where a marker of the pelvis is named, else kFootVelocity
    kCoordinates,   // Zeni, Richards, Higginson (2008) Gait Posture 27:710-714
    kFootVelocity,  // O'Connor, Thorpe, O'Malley, Vaughan (2007) Gait Posture 25:469-474
  };
  Method method = Method::kAuto;
  // Zero-lag low-pass of the markers [Hz]; both papers use 6 to 7 for walking.
  double cutoff = 7.0;
  // A turning point counts if the curve turns by this part of its range before and after it.
  double prominence = 0.15;
  // ... if it lies within this part of the range from the curve's largest (or smallest) value,
  double height = 0.5;
  // and if the same foot's last one is this long ago [s]: the fastest walk has strides of 0.75 s.
  double least_stride = 0.4;
  // A curve that spans less is no walk's: of coordinates [m], of velocities [m/s].
  double least_way = 0.2, least_velocity = 0.5;
  // Foot velocity: heels strike below this part of the heel's range of height.
  double heel_height = 0.35;

  /// Throws std::invalid_argument naming field, value and bound.
  void validate() const;
};

/// Heel strikes and toe offs of the feet whose heel and toe are named, from markers alone. Where no
/// heel was measured the ankle stands for it.
///
/// Coordinates: with f the way that the subject goes (or faces, if it goes less than half a metre),
///   strike: (p_heel − p_pelvis)·f is largest,   off: (p_toe − p_pelvis)·f is smallest.
/// Foot velocity, of the middle c of heel and toe: strike: ċ·up is smallest while the heel is low;
///   off: ċ·up is largest.
/// Times lie between frames, on the parabola through the turning point and its neighbours. By time.
/// O(frames). Throws std::invalid_argument for a cutoff that is not below half the rate.
std::vector<GaitEvent> events_from_kinematics(const MarkerTrajectories& markers,
                                              const Eigen::Vector3d& up,
                                              const KinematicEventOptions& options = {});

/// The events among those of a C3D file that are strikes and offs: labels such as `Foot Strike`,
/// `Foot Off`, `Heel Strike`, `Toe Off`, `RHS`, `LTO`, with contexts Left and Right.
std::vector<GaitEvent> events_from_file(const std::vector<C3dEvent>& events);

/// One event where several sources tell of the same: same kind, sides that do not differ, and times
/// within `tolerance` [s], which is less than half of the time from one foot's strike to the
/// other's. Forces give the time before the file, the file before kinematics. By time.
std::vector<GaitEvent> merge_events(const std::vector<GaitEvent>& by_forces,
                                    const std::vector<GaitEvent>& by_file,
                                    const std::vector<GaitEvent>& by_kinematics,
                                    double tolerance = 0.12);

/// As the group EVENT has them: `Foot Strike` and `Foot Off`, contexts Left, Right, General.
std::vector<C3dEvent> c3d_events(const std::vector<GaitEvent>& events);

/// A row an event: time, frame, side, event, platform, and the time by each source.
std::string events_csv(const std::vector<GaitEvent>& events, const MarkerTrajectories& markers);

}  // namespace sinew
