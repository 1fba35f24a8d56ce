#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "model/musculoskeletal_model.h"

/// What a model's tree says of limbs: which joints lie between a body and ground, which bodies are
/// feet. Virtual links are no bodies here.
namespace sinew {

/// The direction against gravity; y without gravity.
Eigen::Vector3d up_of(const MusculoskeletalModel& model);

/// Whether a coordinate moves a virtual link.
bool of_virtual_link(const MusculoskeletalModel& model, int coordinate);

/// Names of the coordinates of all joints between `body` and ground.
std::vector<std::string> coordinates_to_ground(const MusculoskeletalModel& model, int body);

/// Coordinates, ascending, of all joints whose torque hangs on how `body` moves: of those that
/// carry it and of those that it carries.
std::vector<int> torques_with(const MusculoskeletalModel& model, int body);

/// −1 left, 1 right, 0 neither: whether a name and its partner's differ by an l or an r.
int side_of(const std::string& name, const std::string& partner);
/// Of a body of the model.
int side_of_body(const MusculoskeletalModel& model, int body);
/// The body of the other side, or −1.
int partner_body(const MusculoskeletalModel& model, int body);

/// The model in its default pose.
struct Stance {
  double lowest = kNaN, highest = kNaN;  // along up, of joints, mass centres and markers [m]
  std::vector<int> feet;  // bodies that carry no other and reach into the lowest quarter
  double hip = kNaN;      // the height of the joint where the limb of a paired foot begins [m]
};
/// O(size of the model).
Stance default_stance(const MusculoskeletalModel& model);

/// Whether nothing holds the model to ground but a joint that leaves it two shifts or more.
bool is_floating(const MusculoskeletalModel& model);

/// Whether the model stands for a person, whose size and weight are known to be within limits: it
/// floats and has hips.
bool stands_for_a_person(const MusculoskeletalModel& model);

}  // namespace sinew
