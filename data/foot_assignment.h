#pragma once

#include <optional>
#include <string>
#include <vector>

#include "data/force_platform.h"
#include "data/marker_trajectories.h"

namespace sinew {

/// A foot that may stand on platforms.
struct Foot {
  std::string name;          // "right", "left"
  std::string body;          // of the model, which the loads act on: "calcn_r", ...
  std::vector<int> markers;  // that sit on it
};

/// Right and left feet by the names of markers (data/marker_names.h); bodies are calcn_r and
/// calcn_l. A side without foot markers is left out.
std::vector<Foot> find_feet(const MarkerTrajectories& markers);

/// What the user said: contacts of this platform whose middle lies in the range are this foot's,
/// or nobody's.
struct AssignmentOverride {
  int plate = 0;                   // its number, from 1
  std::string foot;                // a foot's name, or "none"
  std::optional<double> from, to;  // [s]
};
/// `PLATE:FOOT` or `PLATE:FOOT@FROM-TO`: `1:right`, `2:none@0.5-1.2`. Nothing if it is not.
std::optional<AssignmentOverride> parse_override(const std::string& text);

/// One time that something presses on a platform.
struct PlateContact {
  enum class State {
    kAssigned,  // loads are taken for the foot
    kUnusable,  // loads are left out, `reason` says why
    kNobody     // left out because the user said so
  };

  int plate = 0;                // index into the recordings
  double from = 0.0, to = 0.0;  // [s]
  double peak = 0.0;            // largest force along the normal [N]
  int foot = -1;                // index; -1 if none fits
  State state = State::kUnusable;
  double confidence = 0.0;  // 0 to 1; 1 is what the user said
  // Share of frames with a centre of pressure in which it lies within 10 cm of the foot that stands
  // still; NaN where the foot was not measured.
  double share = 0.0;
  double outside = 0.0;  // how far the foot reaches over the platform's edge [m]; 0 = not at all
  bool overridden = false;
  std::string reason;
};

struct FootAssignment {
  std::vector<Foot> feet;
  std::vector<PlateContact> contacts;  // by platform, then time
};

/// Which foot stands on which platform and when. Markers and platforms are in a model's axes, y up,
/// on one clock that starts at the platforms' first sample.
///
/// A contact is a stretch of at least 50 ms in which the platform carries `threshold` or more, with
/// breaks of up to 30 ms. In its frames a foot fits if its slowest marker moves by less than 0.7
/// m/s and the centre of pressure is within 10 cm of a line between two of its markers, or 25 cm of
/// the only one that is measured. The foot that fits oftener is taken; confidence is its share
/// times what the other foot's lacks of it. A contact is unusable where no foot fits half of the
/// time, where both fit about alike, where the other foot stands still within the platform's edges
/// for more than 50 ms (two feet on one platform), and where the foot reaches over the edge by more
/// than 5 cm while no other platform carries it. O(frames · contacts). Throws std::invalid_argument
/// for an override whose platform or foot does not exist.
FootAssignment assign_feet(const MarkerTrajectories& markers, std::vector<Foot> feet,
                           const std::vector<ForcePlatformRecording>& plates, double threshold,
                           const std::vector<AssignmentOverride>& overrides);

/// Columns FOOT_force_vx … FOOT_force_px … FOOT_torque_x for each foot, at the platforms' rate: the
/// loads of its contacts, zero elsewhere. Where two platforms carry a foot at once they are summed,
/// and the centre of pressure is where the sum leaves only a vertical moment on their mean height.
/// Centres go on between contacts as in force_table. Platforms must have been through `condition`.
TimeTable foot_loads(const FootAssignment& assignment,
                     const std::vector<ForcePlatformRecording>& plates);

/// A row a contact: platform, times, foot, state, confidence, reason.
std::string contacts_csv(const FootAssignment& assignment,
                         const std::vector<ForcePlatformRecording>& plates);

/// `platform 1, 0.52 s to 1.18 s: right (98 % sure)`.
std::string describe(const PlateContact& contact, const FootAssignment& assignment,
                     const std::vector<ForcePlatformRecording>& plates);

}  // namespace sinew
