#include "model/furcation.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <stdexcept>

#include "model/furcation_ends.h"

namespace sinew {
namespace {

using Eigen::Vector3d;
using furcation::MuscleEnd;
using Group = std::vector<MuscleEnd>;

std::vector<std::string> names_of(const MusculoskeletalModel& model, const Group& group) {
  std::vector<std::string> names;
  for (const MuscleEnd& end : group) {
    names.push_back(model.paths[static_cast<std::size_t>(end.path)].name);
  }
  return names;
}

std::string list(const std::vector<std::string>& names) {
  return fmt::format("{}", fmt::join(names, ", "));
}

SourceLocation place_of(const MusculoskeletalModel& model) {
  return {model.name.empty() ? "model" : model.name};
}

double spread_of(const Group& group) {
  double spread = 0.0;
  for (const MuscleEnd& a : group) {
    for (const MuscleEnd& b : group) spread = std::max(spread, (a.p_W - b.p_W).norm());
  }
  return spread;
}

// The common tendon's length, and what it must at least be.
struct TendonLength {
  double longest = std::numeric_limits<double>::infinity(), shortest = 0.0;
};

TendonLength tendon_length(const Group& group, const FurcationOptions& options) {
  TendonLength length;
  for (const MuscleEnd& end : group) {
    length.longest = std::min({length.longest, options.tendon_part * end.tendon_slack_length,
                               end.length_on_bone + options.tendon_part * end.length_off_bone});
    length.shortest = std::max(length.shortest, end.length_on_bone + options.shortest_tendon);
  }
  return length;
}

// All within the distance of each other, in the model's order.
std::vector<Group> find_groups(const std::vector<MuscleEnd>& ends, double distance) {
  std::vector<Group> groups;
  for (const MuscleEnd& end : ends) {
    const auto fits = [&](const Group& group) {
      return std::all_of(group.begin(), group.end(), [&](const MuscleEnd& other) {
        return other.bone == end.bone && other.path != end.path &&
               (other.p_W - end.p_W).norm() <= distance;
      });
    };
    const auto group = std::find_if(groups.begin(), groups.end(), fits);
    if (group == groups.end()) {
      groups.push_back({end});
    } else {
      group->push_back(end);
    }
  }
  std::erase_if(groups, [](const Group& group) { return group.size() < 2; });
  return groups;
}

/// Changes a copy of the model, one furcation after the other.
class Furcator {
 public:
  Furcator(const MusculoskeletalModel& model, const FurcationOptions& options)
      : original_(model), options_(options), pose_(model) {
    result_.model = model;
  }

  FurcatedModel run() {
    if (options_.requests.empty()) {
      for (const bool insertion : {true, false}) {
        for (const Group& group : find_groups(pose_.ends(insertion), options_.distance)) {
          furcate_if_possible(group);
        }
      }
    }
    for (const FurcationRequest& request : options_.requests) furcate_request(request);
    sinew::validate(result_.model);
    return std::move(result_);
  }

 private:
  const std::string& body_name(int b) const {
    return result_.model.bodies[static_cast<std::size_t>(b)].name;
  }

  void furcate_if_possible(const Group& group) {
    const TendonLength length = tendon_length(group, options_);
    if (length.longest >= length.shortest) {
      apply(group, next_name(group[0].bone), length.longest);
      return;
    }
    const PathElement& first = original_.paths[static_cast<std::size_t>(group[0].path)];
    result_.warnings.push_back(
        {first.source.file.empty() ? place_of(original_) : first.source,
         fmt::format("{} are left as they are on '{}': the tendon that they could share is {:.1f} "
                     "mm, and {:.1f} mm are needed to leave the bone",
                     list(names_of(original_, group)), body_name(group[0].bone),
                     1e3 * length.longest, 1e3 * length.shortest)});
  }

  std::string next_name(int bone) {
    std::string name;
    do {
      name = fmt::format("furcation_{}_{}", body_name(bone), ++numbers_[bone]);
    } while (result_.model.find_body(name) >= 0);
    return name;
  }

  // The ends that a request means: all insertions if these are on one bone, else all origins.
  Group requested_ends(const FurcationRequest& request) const {
    const auto reject = [&](std::string problem, std::string expected, std::string found,
                            std::string remedy) {
      throw InputError(place_of(original_), {std::move(problem), std::move(expected),
                                             std::move(found), std::move(remedy)});
    };
    for (const bool insertion : {true, false}) {
      Group group;
      for (const std::string& muscle : request.muscles) {
        const auto path = std::find_if(original_.paths.begin(), original_.paths.end(),
                                       [&](const PathElement& p) { return p.name == muscle; });
        if (path == original_.paths.end()) {
          reject(fmt::format("has no muscle '{}' to furcate", muscle), "names of its muscles", "",
                 "See `sinew model info --moment-arms`.");
        }
        const auto end = pose_.end(static_cast<int>(path - original_.paths.begin()), insertion);
        if (!end) {
          reject(fmt::format("'{}' cannot be furcated", muscle),
                 "a muscle with a tendon_slack_length and a path over a joint", "",
                 "Leave it out.");
        }
        group.push_back(*end);
      }
      const bool one_bone = std::all_of(group.begin(), group.end(), [&](const MuscleEnd& end) {
        return end.bone == group[0].bone;
      });
      if (one_bone) return group;
    }
    reject(fmt::format("{} do not end on one bone", list(request.muscles)),
           "muscles with a bone in common at one of their ends", "", "Leave some of them out.");
    return {};
  }

  void furcate_request(const FurcationRequest& request) {
    const Group group = requested_ends(request);
    if (const double spread = spread_of(group); spread > options_.distance) {
      throw InputError(
          place_of(original_),
          {fmt::format("the ends of {} are too far apart", list(request.muscles)),
           fmt::format("{:g} m or less", options_.distance), fmt::format("{:.4f} m", spread),
           "Allow a larger distance, or leave some of them out."});
    }
    const TendonLength length = tendon_length(group, options_);
    if (length.longest < length.shortest) {
      throw InputError(
          place_of(original_),
          {fmt::format("{} have too little tendon in common", list(request.muscles)),
           fmt::format("{:.4f} m, to leave the bone", length.shortest),
           fmt::format("{:.4f} m", length.longest), "Leave the one with the least tendon out."});
    }
    const std::string name = request.name.empty() ? next_name(group[0].bone) : request.name;
    if (result_.model.find_body(name) >= 0) {
      throw InputError(place_of(original_),
                       {fmt::format("the name '{}' is taken by another body", name), "a new name",
                        "", "Choose another name."});
    }
    apply(group, name, length.longest);
  }

  void apply(const Group& group, const std::string& name, double length) {
    const MuscleEnd& strongest =
        *std::max_element(group.begin(), group.end(),
                          [](const MuscleEnd& a, const MuscleEnd& b) { return a.force < b.force; });
    const Vector3d p_WL = strongest.point_before_end(length);
    const int parent = parent_bone(group);
    const int link = add_link(name, parent, p_WL);
    add_tendon(name, link, strongest, length);
    for (const MuscleEnd& end : group) {
      // The link's axes are its parent's.
      const Eigen::Matrix3d& R_WP = pose_.X_WB(parent).R;
      shorten(end, link, R_WP.transpose() * (end.point_before_end(length) - p_WL), length);
    }
    result_.furcations.push_back({name, name + "_tendon", body_name(strongest.bone),
                                  names_of(original_, group), strongest.insertion, spread_of(group),
                                  length});
  }

  // The tendon leads to the bone; on a tie that is the one.
  static int parent_bone(const Group& group) {
    std::map<int, int> paths = {{group[0].bone, 1}};
    for (const MuscleEnd& end : group) ++paths[end.next_body];
    int parent = group[0].bone;
    for (const auto& [body, count] : paths) {
      if (body != 0 && count > paths.at(parent)) parent = body;
    }
    return parent;
  }

  int add_link(const std::string& name, int parent, const Vector3d& p_WL) {
    MusculoskeletalModel& model = result_.model;
    Body body;
    body.name = name;
    body.virtual_link = true;
    Joint joint;
    joint.name = name + "_joint";
    joint.kind = Joint::Kind::kFree;
    joint.parent = parent;
    joint.child = static_cast<int>(model.bodies.size());
    joint.X_PF.p = pose_.X_WB(parent).inverse() * p_WL;
    for (const char* suffix : {"rx", "ry", "rz", "tx", "ty", "tz"}) {
      Coordinate c;
      c.name = name + "_" + suffix;
      c.joint = static_cast<int>(model.joints.size());
      const bool turns = suffix[0] == 'r';
      c.motion = turns ? Coordinate::Motion::kRotational : Coordinate::Motion::kTranslational;
      // Not bounds: programs that show models want a range.
      c.range_max = turns ? 0.5 * std::numbers::pi : 0.1;
      c.range_min = -c.range_max;
      joint.coordinates.push_back(static_cast<int>(model.coordinates.size()));
      model.coordinates.push_back(std::move(c));
    }
    model.bodies.push_back(std::move(body));
    model.joints.push_back(std::move(joint));
    return static_cast<int>(model.bodies.size()) - 1;
  }

  // From the link over the strongest muscle's points on the bone to its end.
  void add_tendon(const std::string& name, int link, const MuscleEnd& strongest, double length) {
    PathElement tendon;
    tendon.name = name + "_tendon";
    tendon.kind = PathElement::Kind::kTendon;
    tendon.class_name = "PathSpring";
    tendon.natural_length = length;
    PathPoint start;
    start.body = link;
    tendon.points.push_back(start);
    const std::vector<PathPoint>& points =
        original_.paths[static_cast<std::size_t>(strongest.path)].points;
    for (std::size_t i = 0; i < strongest.points_on_bone; ++i) {
      const std::size_t from_end = strongest.points_on_bone - 1 - i;
      tendon.points.push_back(
          points[strongest.insertion ? points.size() - 1 - from_end : from_end]);
    }
    if (!strongest.insertion) std::reverse(tendon.points.begin(), tendon.points.end());
    for (std::size_t i = 0; i < tendon.points.size(); ++i) {
      tendon.points[i].name = fmt::format("{}-P{}", tendon.name, i + 1);
    }
    result_.model.paths.push_back(std::move(tendon));
  }

  // Puts one point on the link in the place of the muscle's points on the bone.
  void shorten(const MuscleEnd& end, int link, const Vector3d& p_LP, double length) {
    PathElement& muscle = result_.model.paths[static_cast<std::size_t>(end.path)];
    PathPoint point;
    point.name = end.insertion ? muscle.points.back().name : muscle.points.front().name;
    point.body = link;
    point.p_BP = p_LP;
    const auto count = static_cast<std::ptrdiff_t>(end.points_on_bone);
    if (end.insertion) {
      muscle.points.erase(muscle.points.end() - count, muscle.points.end());
      muscle.points.push_back(std::move(point));
    } else {
      muscle.points.erase(muscle.points.begin(), muscle.points.begin() + count);
      muscle.points.insert(muscle.points.begin(), std::move(point));
    }
    muscle.tendon_slack_length -= length;
    muscle.natural_length -= length;
  }

  const MusculoskeletalModel& original_;
  const FurcationOptions& options_;
  furcation::DefaultPose pose_;
  std::map<int, int> numbers_;  // of the links made, by bone
  FurcatedModel result_;
};

}  // namespace

void FurcationOptions::validate() const {
  const auto reject = [](const char* name, double value, const char* expected) {
    throw std::invalid_argument(fmt::format("{} is {}; expected {}", name, value, expected));
  };
  if (!(distance >= 0.0) || !std::isfinite(distance)) {
    reject("distance", distance, "a length, 0 or more");
  }
  if (!(tendon_part > 0.0 && tendon_part < 0.5)) {
    reject("tendon_part", tendon_part, "a part above 0 and below 0.5");
  }
  if (!(shortest_tendon > 0.0) || !std::isfinite(shortest_tendon)) {
    reject("shortest_tendon", shortest_tendon, "a length above 0");
  }
  for (const FurcationRequest& request : requests) {
    std::vector<std::string> muscles = request.muscles;
    std::sort(muscles.begin(), muscles.end());
    const bool twice = std::adjacent_find(muscles.begin(), muscles.end()) != muscles.end();
    if (muscles.size() < 2 || twice) {
      throw std::invalid_argument(fmt::format(
          "'{}' is no furcation; expected two or more different muscles", list(request.muscles)));
    }
  }
}

FurcatedModel furcate(const MusculoskeletalModel& model, const FurcationOptions& options) {
  options.validate();
  return Furcator(model, options).run();
}

}  // namespace sinew
