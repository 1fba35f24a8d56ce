#pragma once

#include <Eigen/Core>
#include <vector>

#include "data/time_table.h"
#include "data/verdict_reason.h"
#include "dynamics/external_loads.h"
#include "model/musculoskeletal_model.h"

namespace sinew {

/// Where a load acts, over the frames in which it carries more than a tenth of the model's weight.
struct LoadPlacement {
  int body = -1;              // that it acts on
  int other = -1;             // the body of the other side, or −1
  int frames = 0;             // loaded ones
  double distance = kNaN;     // the middle one of the point to its body [m]
  double to_other = kNaN;     // the same to the other body [m]
  double nearer_other = 0.0;  // part of the loaded frames, by 5 cm or more
  // Of the points whose coordinate along a horizontal axis of ground has the other sign: the axis
  // that brings them nearest to the body, and the middle distance [m].
  int mirror_axis = -1;
  double mirrored = kNaN;
  // Over all frames, whatever it carries: the largest force times how much farther than 0.15 m its
  // point is from the body, and when [N m, s].
  double far_moment = 0.0, far_time = kNaN;
};

/// Every load that has a point, of a model that stands for a person. A body is where its origin,
/// its mass centre, the joints that it carries and its markers, and those of the bodies that it
/// carries, are. `q`: frames × coordinates [rad, m] at the times. O(frames · (loads + size of the
/// model)).
std::vector<LoadPlacement> load_placements(const MusculoskeletalModel& model,
                                           const Eigen::VectorXd& time, const RowMatrix& q,
                                           const ExternalLoads& loads);

/// Codes `loads-of-other-foot`, not usable: a load that in more than a tenth of its loaded frames,
/// one of several steps, acts nearer to the other side's body; `loads-mirrored`, not usable: one
/// whose points come to its body when the sign of one horizontal coordinate is turned, nearer by
/// 5 cm or more than as they are; `loads-beside-foot`: one that acts away from its body, a remark
/// from 0.15 m on, not usable from 0.4 m; `loads-not-on-foot`: one on a leg above the foot, whose
/// joints below carry nothing. `supporting`: the coordinates whose torques they spoil.
std::vector<VerdictReason> load_placement_reasons(const MusculoskeletalModel& model,
                                                  const std::vector<LoadPlacement>& placements,
                                                  const std::vector<std::string>& supporting);

}  // namespace sinew
