#include "model/limb_paths.h"

#include <algorithm>
#include <cctype>
#include <cmath>

#include "model/kinematic_tree.h"
#include "model/model_check.h"

namespace sinew {
namespace {

const Joint& joint_of(const MusculoskeletalModel& model, int body) {
  return model.joints[static_cast<std::size_t>(body) - 1];
}

bool is_virtual(const MusculoskeletalModel& model, int body) {
  return model.bodies[static_cast<std::size_t>(body)].virtual_link;
}

// Bodies that carry no other.
std::vector<int> leaves_of(const MusculoskeletalModel& model) {
  std::vector<bool> carries(model.bodies.size(), false);
  for (const Joint& joint : model.joints) {
    if (!is_virtual(model, joint.child)) carries[static_cast<std::size_t>(joint.parent)] = true;
  }
  std::vector<int> leaves;
  for (int b = 1; b < static_cast<int>(model.bodies.size()); ++b) {
    if (!carries[static_cast<std::size_t>(b)] && !is_virtual(model, b)) leaves.push_back(b);
  }
  return leaves;
}

}  // namespace

Eigen::Vector3d up_of(const MusculoskeletalModel& model) {
  const double g = model.gravity.norm();
  return g > 0.0 ? Eigen::Vector3d(-model.gravity / g) : Eigen::Vector3d::UnitY();
}

bool of_virtual_link(const MusculoskeletalModel& model, int coordinate) {
  const int joint = model.coordinates[static_cast<std::size_t>(coordinate)].joint;
  return is_virtual(model, model.joints[static_cast<std::size_t>(joint)].child);
}

std::vector<std::string> coordinates_to_ground(const MusculoskeletalModel& model, int body) {
  std::vector<std::string> names;
  for (; body > 0; body = joint_of(model, body).parent) {
    for (const int c : joint_of(model, body).coordinates) {
      names.push_back(model.coordinates[static_cast<std::size_t>(c)].name);
    }
  }
  return names;
}

std::vector<int> torques_with(const MusculoskeletalModel& model, int body) {
  std::vector<bool> chain(model.bodies.size(), false);
  const auto parent = [&](std::size_t b) {
    return static_cast<std::size_t>(model.joints[b - 1].parent);
  };
  chain[static_cast<std::size_t>(body)] = true;
  for (auto b = static_cast<std::size_t>(body) + 1; b < chain.size(); ++b) {
    chain[b] = chain[parent(b)];  // bodies stand after their parents
  }
  for (auto b = static_cast<std::size_t>(body); b > 0; b = parent(b)) chain[b] = true;
  std::vector<int> coordinates;
  for (std::size_t c = 0; c < model.coordinates.size(); ++c) {
    const Joint& joint = model.joints[static_cast<std::size_t>(model.coordinates[c].joint)];
    if (chain[static_cast<std::size_t>(joint.child)]) coordinates.push_back(static_cast<int>(c));
  }
  return coordinates;
}

int side_of(const std::string& name, const std::string& partner) {
  if (name.size() != partner.size()) return 0;
  const auto at = std::mismatch(name.begin(), name.end(), partner.begin()).first;
  if (at == name.end()) return 0;
  const int letter = std::tolower(static_cast<unsigned char>(*at));
  return letter == 'r' ? 1 : letter == 'l' ? -1 : 0;
}

int partner_body(const MusculoskeletalModel& model, int body) {
  for (const std::string& name : partner_names(model.bodies[static_cast<std::size_t>(body)].name)) {
    if (const int partner = model.find_body(name); partner > 0) return partner;
  }
  return -1;
}

int side_of_body(const MusculoskeletalModel& model, int body) {
  const int partner = partner_body(model, body);
  if (partner < 0) return 0;
  return side_of(model.bodies[static_cast<std::size_t>(body)].name,
                 model.bodies[static_cast<std::size_t>(partner)].name);
}

Stance default_stance(const MusculoskeletalModel& model) {
  Stance stance;
  if (model.bodies.size() < 2) return stance;
  const KinematicTree tree = compile_tree(model);
  KinematicWorkspace ws(tree);
  std::copy(tree.default_q.begin(), tree.default_q.end(), ws.q.begin());
  update_poses(tree, ws);
  const Eigen::Vector3d up = up_of(model);
  const auto height = [&](int body, const Eigen::Vector3d& p_BP) {
    return up.dot(ws.X_WB[static_cast<std::size_t>(body)] * p_BP);
  };
  const auto reach = [&](double h) {
    if (!(h >= stance.lowest)) stance.lowest = h;
    if (!(h <= stance.highest)) stance.highest = h;
  };
  for (int b = 1; b < static_cast<int>(model.bodies.size()); ++b) {
    if (is_virtual(model, b)) continue;
    reach(height(b, Eigen::Vector3d::Zero()));
    reach(height(b, model.bodies[static_cast<std::size_t>(b)].p_BCm));
  }
  for (const Marker& marker : model.markers) {
    if (marker.body > 0) reach(height(marker.body, marker.p_BM));
  }
  const double quarter = stance.lowest + 0.25 * (stance.highest - stance.lowest);
  for (const int leaf : leaves_of(model)) {
    double low = std::min(height(leaf, Eigen::Vector3d::Zero()),
                          height(leaf, model.bodies[static_cast<std::size_t>(leaf)].p_BCm));
    for (const Marker& marker : model.markers) {
      if (marker.body == leaf) low = std::min(low, height(leaf, marker.p_BM));
    }
    if (low <= quarter) stance.feet.push_back(leaf);
  }
  for (const int foot : stance.feet) {
    const int partner = partner_body(model, foot);
    if (std::find(stance.feet.begin(), stance.feet.end(), partner) == stance.feet.end()) continue;
    int limb = foot;
    while (joint_of(model, limb).parent > 0 &&
           joint_of(model, joint_of(model, limb).parent).parent > 0) {
      limb = joint_of(model, limb).parent;
    }
    const Joint& hip = joint_of(model, limb);
    if (hip.parent > 0) stance.hip = height(hip.parent, hip.X_PF.p);
  }
  return stance;
}

bool is_floating(const MusculoskeletalModel& model) {
  for (const Joint& joint : model.joints) {
    if (joint.parent != 0 || is_virtual(model, joint.child)) continue;
    int shifts = 0;
    for (const int c : joint.coordinates) {
      const Coordinate& coordinate = model.coordinates[static_cast<std::size_t>(c)];
      shifts += coordinate.motion == Coordinate::Motion::kTranslational && !coordinate.locked;
    }
    if (shifts >= 2) return true;
  }
  return false;
}

bool stands_for_a_person(const MusculoskeletalModel& model) {
  return is_floating(model) && std::isfinite(default_stance(model).hip);
}

}  // namespace sinew
