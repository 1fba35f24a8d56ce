#pragma once

#include <string>
#include <vector>

#include "ik/tracking.h"
#include "model/segment_words.h"

namespace sinew {

/// What a trunk or a head without markers is taken to do.
struct UprightPosture {
  std::vector<Segment> segments;  // the trunk, the head, or both
  std::vector<int> coordinates;   // of the joints from them to what markers determine
  RowMatrix values;               // frames × coordinates [rad]
  bool empty() const { return coordinates.empty(); }
};

/// People keep trunk and head upright while the pelvis tilts, drops and turns under them
/// (Cappozzo 1981, J Biomech 14:411-418; Perry & Burnfield 2010, ch. 7): their orientation in the
/// world is that of the model's default pose, its root not turned, facing where the pelvis, or what
/// else carries them and has markers, faces on the average over a stride. Coordinates that markers
/// leave undetermined on the way there are found by least squares with
///     w_u Σ_s |log(R^d_s R_sᵀ)|² + w_p Σ_c (q_c − q0_c)²
/// with all others as the markers have them, s the topmost body of trunk and head, w_p =
/// posture_weight and w_u = 100 w_p: what is turned between several joints is shared evenly. Empty
/// where trunk and head have markers or nothing leaves them open. Frames are all of the recording;
/// `tasks` are what is tracked, with the posture's tasks. Time: two inverse kinematics.
UprightPosture upright_posture(const MusculoskeletalModel& model, const KinematicTree& tree,
                               const MarkerFile& recording, const IkTaskSet& tasks,
                               double posture_weight, const TrackingOptions& options);

}  // namespace sinew
