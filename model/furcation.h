#pragma once

#include <string>
#include <vector>

#include "model/musculoskeletal_model.h"

namespace sinew {

/// Muscles that are to end on one virtual link, by name.
struct FurcationRequest {
  std::vector<std::string> muscles;
  std::string name;  // of the link; empty: `furcation_<bone>_<number>`

  bool operator==(const FurcationRequest&) const = default;
};

struct FurcationOptions {
  double distance = 0.01;  // ends within this of each other are one place [m]
  // Of a muscle's tendon_slack_length, and of the piece of its path outside the bone, at most this
  // part becomes the common tendon; less than half, as the other end may want its share.
  double tendon_part = 0.4;
  double shortest_tendon = 0.005;               // outside the bone [m]
  std::vector<FurcationRequest> requests = {};  // empty: all groups that are found

  /// Throws std::invalid_argument naming field, value and bounds.
  void validate() const;
};

/// One virtual link that was made.
struct Furcation {
  std::string virtual_link, tendon, bone;
  std::vector<std::string> muscles;
  bool insertion = true;       // false: of their origins
  double spread = 0.0;         // largest distance between the ends that became one [m]
  double tendon_length = 0.0;  // length and natural length of the common tendon [m]
};

struct FurcatedModel {
  MusculoskeletalModel model;
  std::vector<Furcation> furcations;
  std::vector<Warning> warnings;  // groups that were found and left as they are, with the reason
};

/// Turns muscles that end at one place of a bone into a furcation (Ayusawa & Nakamura 2012, sec.
/// IV): they end on a massless virtual link of six degrees of freedom, and one tendon runs from it
/// to the bone. All in the pose of the defaults:
///
///  - Groups: insertions of two or more muscles on one bone, all within `distance` of each other;
///    then origins likewise. An end belongs to the first group that it fits in, in the model's
///    order.
///  - The common tendon has the length T = min over the muscles of tendon_part ·
///  tendon_slack_length
///    and t + tendon_part · s, where t is the part of the path on the bone and s the piece of the
///    path that leaves it.
///  - The strongest muscle gives the tendon's course: from its path's point at T before its end,
///    where the virtual link has its origin, to its end.
///  - Every muscle ends on the link where its own path was T before its end, and loses T of its
///    tendon_slack_length. So the lengths of muscle and tendon together, and their natural lengths,
///    are what they were, to rounding.
///  - The link hangs from the bone that most of its paths lead to; its frame is parallel to that
///    bone's.
///
/// Throws InputError where a request names muscles that do not exist, do not end on one bone, end
/// farther apart than `distance`, or have too little tendon, or where a name is taken.
FurcatedModel furcate(const MusculoskeletalModel& model, const FurcationOptions& options = {});

}  // namespace sinew
