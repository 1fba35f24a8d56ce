#include "model/whole_body.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <random>

#include "model/kinematic_tree.h"
#include "model/osim_file.h"
#include "model/path_length.h"
#include "model/simbody_model.h"
#include "tests/model/random_model.h"
#include "tests/model/whole_body_neutral.h"

namespace sinew {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Level = WholeBodyOptions::Level;
using Sex = WholeBodyOptions::Sex;

constexpr double kPoseTolerance = 1e-12;  // rounding of chains of some 30 products near 1

int dof(const MusculoskeletalModel& model) {
  return static_cast<int>(model.coordinates.size() - model.couplers.size());
}

// --- Skeleton. ---

TEST(WholeBody, HasTheBonesDegreesOfFreedom) {
  const MusculoskeletalModel model = whole_body({.level = Level::kSimplified});
  EXPECT_EQ(dof(model), 155);
  EXPECT_EQ(model.virtual_link_count(), 0);
  EXPECT_EQ(dof(whole_body({})), 155 + 6 * whole_body({}).virtual_link_count());
}

TEST(WholeBody, HasTheSamePosesInSimbody) {
  for (const Level level : {Level::kSimplified, Level::kDetailed}) {
    const MusculoskeletalModel model = whole_body({.level = level});
    const KinematicTree tree = compile_tree(model);
    KinematicWorkspace ws(tree);
    const SimbodyModel simbody(model);
    SimTK::State state = simbody.default_state();
    std::mt19937 random(7);
    for (int trial = 0; trial < 5; ++trial) {
      const std::vector<double> q = random_pose(model, random);
      for (std::size_t c = 0; c < q.size(); ++c) {
        ws.q[static_cast<std::size_t>(tree.q_of_coordinate[c])] = q[c];
      }
      update_poses(tree, ws);  // sets coupled coordinates
      std::vector<double> coupled(q.size());
      for (std::size_t c = 0; c < q.size(); ++c) {
        coupled[c] = ws.q[static_cast<std::size_t>(tree.q_of_coordinate[c])];
      }
      simbody.set_q(state, coupled);
      simbody.system().realize(state, SimTK::Stage::Position);
      for (std::size_t b = 1; b < model.bodies.size(); ++b) {
        const RigidTransform X_WB =
            to_eigen(simbody.matter()
                         .getMobilizedBody(simbody.body(static_cast<int>(b)))
                         .getBodyTransform(state));
        EXPECT_LE((X_WB.p - ws.X_WB[b].p).norm(), kPoseTolerance) << model.bodies[b].name;
        EXPECT_LE((X_WB.R - ws.X_WB[b].R).norm(), kPoseTolerance) << model.bodies[b].name;
      }
    }
  }
}

// Coordinates, speeds and accelerations of the bones are the same in both; virtual links move as
// they like. They must not change what the joints have to do, and must ask for nothing themselves.
TEST(WholeBody, HasMasslessVirtualLinksThatAskForNoForce) {
  const MusculoskeletalModel bare = whole_body({.level = Level::kSimplified});
  const MusculoskeletalModel strung = whole_body({.level = Level::kDetailed});
  const SimbodyModel bare_simbody(bare), strung_simbody(strung);
  SimTK::State bare_state = bare_simbody.default_state();
  SimTK::State state = strung_simbody.default_state();
  std::mt19937 random(3);
  std::uniform_real_distribution<double> value(-1.0, 1.0);
  SimTK::Vector bare_rates(bare_state.getNU()), rates(state.getNU());
  for (std::size_t c = 0; c < strung.coordinates.size(); ++c) {
    const int i = static_cast<int>(c);
    const double q = 0.5 * value(random), u = value(random), rate = 10.0 * value(random);
    state.updQ()[strung_simbody.q_index(i)] = q;
    state.updU()[strung_simbody.u_index(i)] = u;
    rates[strung_simbody.u_index(i)] = rate;
    const int other = bare.find_coordinate(strung.coordinates[c].name);
    if (other < 0) continue;
    bare_state.updQ()[bare_simbody.q_index(other)] = q;
    bare_state.updU()[bare_simbody.u_index(other)] = u;
    bare_rates[bare_simbody.u_index(other)] = rate;
  }
  const auto forces = [](const SimbodyModel& model, const SimTK::State& at,
                         const SimTK::Vector& speeds_rate) {
    model.system().realize(at, SimTK::Stage::Dynamics);
    SimTK::Vector residual;
    model.matter().calcResidualForceIgnoringConstraints(
        at, model.system().getMobilityForces(at, SimTK::Stage::Dynamics),
        model.system().getRigidBodyForces(at, SimTK::Stage::Dynamics), speeds_rate, residual);
    return residual;
  };
  const SimTK::Vector bare_forces = forces(bare_simbody, bare_state, bare_rates);
  const SimTK::Vector strung_forces = forces(strung_simbody, state, rates);
  double largest = 0.0;
  for (int i = 0; i < bare_forces.size(); ++i)
    largest = std::max(largest, std::abs(bare_forces[i]));
  EXPECT_GT(largest, 100.0);
  for (std::size_t c = 0; c < strung.coordinates.size(); ++c) {
    const int other = bare.find_coordinate(strung.coordinates[c].name);
    const double expected = other < 0 ? 0.0 : bare_forces[bare_simbody.u_index(other)];
    EXPECT_NEAR(strung_forces[strung_simbody.u_index(static_cast<int>(c))], expected,
                1e-12 * largest)
        << strung.coordinates[c].name;
  }
}

// What simbody_model.h says of accelerations: there are none that could be found.
TEST(WholeBody, HasNoAccelerationsOfMasslessVirtualLinks) {
  const MusculoskeletalModel model = whole_body({});
  ASSERT_GT(model.virtual_link_count(), 0);
  const SimbodyModel simbody(model);
  SimTK::State state = simbody.default_state();
  std::string what;
  try {
    simbody.system().realize(state, SimTK::Stage::Acceleration);
  } catch (const std::exception& error) {
    what = error.what();
  }
  EXPECT_NE(what.find("Matrix is singular"), std::string::npos) << what;
}

// --- Symmetry. ---

// The other side's name, of bodies and coordinates; the same for the midline.
std::string other_side(std::string name) {
  for (std::size_t i = name.size(); i-- > 1;) {
    const bool ends = i + 1 == name.size() || name[i + 1] == '_';
    if (!ends || name[i - 1] != '_' || (name[i] != 'r' && name[i] != 'l')) continue;
    name[i] = name[i] == 'r' ? 'l' : 'r';
    break;
  }
  return name;
}

// By what a coordinate's value is multiplied in the mirrored pose.
double mirror_sign(const MusculoskeletalModel& model, const Coordinate& c) {
  const Joint& joint = model.joints[static_cast<std::size_t>(c.joint)];
  const std::string end = c.name.substr(c.name.rfind('_') + 1);
  if (joint.kind == Joint::Kind::kFree) return end == "rx" || end == "ry" || end == "tz" ? -1 : 1;
  const bool midline = other_side(c.name) == c.name;
  return midline && (end == "bending" || end == "rotation" || end == "list" || end == "tz") ? -1
                                                                                            : 1;
}

const Matrix3d kMirror = Vector3d(1.0, 1.0, -1.0).asDiagonal();

class WholeBodySymmetry : public testing::TestWithParam<Level> {};

TEST_P(WholeBodySymmetry, IsInTheDescription) {
  const MusculoskeletalModel model = whole_body({.level = GetParam()});
  for (std::size_t b = 1; b < model.bodies.size(); ++b) {
    const Body& body = model.bodies[b];
    const int other = model.find_body(other_side(body.name));
    ASSERT_GT(other, 0) << body.name;
    const Body& mirror = model.bodies[static_cast<std::size_t>(other)];
    EXPECT_NEAR(body.mass, mirror.mass, 1e-12) << body.name;
    EXPECT_LE((body.p_BCm - kMirror * mirror.p_BCm).norm(), 1e-12) << body.name;
    EXPECT_LE((body.I_BCm - kMirror * mirror.I_BCm * kMirror).norm(), 1e-12) << body.name;
    const Joint& joint = model.joints[b - 1];
    const Joint& image = model.joints[static_cast<std::size_t>(other) - 1];
    EXPECT_LE((joint.X_PF.p - kMirror * image.X_PF.p).norm(), 1e-12) << body.name;
    EXPECT_EQ(other_side(model.bodies[static_cast<std::size_t>(joint.parent)].name),
              model.bodies[static_cast<std::size_t>(image.parent)].name);
  }
  int markers = 0;
  for (const Marker& marker : model.markers) {
    std::string name = marker.name;
    if (name.front() == 'R') name.front() = 'L';
    const int other = model.find_marker(name);
    // Plug-in-Gait's marker that tells the sides apart has no partner.
    if (marker.name == "RBAK") continue;
    ASSERT_GE(other, 0) << name;
    if (name == marker.name) continue;
    EXPECT_LE((marker.p_BM - kMirror * model.markers[static_cast<std::size_t>(other)].p_BM).norm(),
              1e-12);
    ++markers;
  }
  EXPECT_GE(markers, 30);
}

// Wires are as long in any pose as their mirror images in the mirrored pose, and X_WB is mirrored.
TEST_P(WholeBodySymmetry, IsInEveryPose) {
  const MusculoskeletalModel model = whole_body({.level = GetParam()});
  const KinematicTree tree = compile_tree(model);
  std::map<std::string, const PathElement*> paths;
  for (const PathElement& path : model.paths) paths[path.name] = &path;
  KinematicWorkspace ws(tree), mirrored_ws(tree);
  std::mt19937 random(11);
  for (int trial = 0; trial < 5; ++trial) {
    const std::vector<double> q = random_pose(model, random);
    for (std::size_t c = 0; c < q.size(); ++c) {
      const int other = model.find_coordinate(other_side(model.coordinates[c].name));
      ASSERT_GE(other, 0) << model.coordinates[c].name;
      ws.q[static_cast<std::size_t>(tree.q_of_coordinate[c])] = q[c];
      mirrored_ws
          .q[static_cast<std::size_t>(tree.q_of_coordinate[static_cast<std::size_t>(other)])] =
          mirror_sign(model, model.coordinates[c]) * q[c];
    }
    update_poses(tree, ws);
    update_poses(tree, mirrored_ws);
    for (std::size_t b = 1; b < model.bodies.size(); ++b) {
      const std::string& name = model.bodies[b].name;
      const RigidTransform image = pose(model, mirrored_ws, other_side(name));
      EXPECT_LE((ws.X_WB[b].p - kMirror * image.p).norm(), 1e-12) << name;
      EXPECT_LE((ws.X_WB[b].R - kMirror * image.R * kMirror).norm(), 1e-12) << name;
    }
    for (const PathElement& path : model.paths) {
      const auto other = paths.find(other_side(path.name));
      ASSERT_NE(other, paths.end()) << path.name;
      EXPECT_NEAR(path_length(path, tree, ws), path_length(*other->second, tree, mirrored_ws),
                  1e-12)
          << path.name;
      EXPECT_NEAR(path.natural_length, other->second->natural_length, 1e-12) << path.name;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Levels, WholeBodySymmetry,
                         testing::Values(Level::kSimplified, Level::kDetailed),
                         [](const auto& level) {
                           return level.param == Level::kDetailed ? "Detailed" : "Simplified";
                         });

// --- Wires and markers. ---

// How many of `items` come from that table.
template <typename Items>
int count_from(const Items& items, const std::string& table) {
  int count = 0;
  for (const auto& item : items) {
    count += item.source.file == "model/whole_body/" + table + ".csv" ? 1 : 0;
  }
  return count;
}

// Both sides together.
struct RegionCounts {
  const char* region;
  int simplified_wires, wires, virtual_links;
};
constexpr RegionCounts kRegions[] = {
    {"leg", 90, 240, 28}, {"trunk", 144, 640, 24}, {"arm", 120, 326, 20}};

TEST(WholeBody, HasTheWiresAndVirtualLinksOfItsRegionsAndTheirSum) {
  const MusculoskeletalModel simplified = whole_body({.level = Level::kSimplified});
  const MusculoskeletalModel detailed = whole_body({});
  for (const RegionCounts& expected : kRegions) {
    SCOPED_TRACE(expected.region);
    const std::string wires = std::string("wires_") + expected.region;
    EXPECT_EQ(count_from(simplified.paths, wires), expected.simplified_wires);
    EXPECT_EQ(count_from(detailed.paths, wires), expected.wires);
    EXPECT_EQ(count_from(detailed.bodies, std::string("virtual_links_") + expected.region),
              expected.virtual_links);
  }
  EXPECT_EQ(simplified.paths.size(), 354u);
  EXPECT_EQ(simplified.virtual_link_count(), 0);
  EXPECT_EQ(dof(simplified), 155);
  EXPECT_EQ(detailed.paths.size(), 1206u);
  EXPECT_EQ(detailed.virtual_link_count(), 72);
  EXPECT_EQ(dof(detailed), 587);
}

// L0 by the paths' lengths in the neutral pose, against the rule in the header.
TEST(WholeBody, TakesNaturalLengthsFromTheNeutralPose) {
  for (const Level level : {Level::kSimplified, Level::kDetailed}) {
    const Neutral body({.level = level});
    for (const PathElement& path : body.model.paths) {
      const double neutral = path_length(path, body.tree, body.ws);
      EXPECT_GE(neutral, 0.005) << path.name;
      if (path.kind != PathElement::Kind::kMuscle) {
        EXPECT_GE(path.natural_length, (1.0 - 1e-12) * neutral) << path.name;
        EXPECT_LE(path.natural_length, 1.5 * neutral) << path.name;
        continue;
      }
      EXPECT_GT(path.max_isometric_force, 0.0) << path.name;
      EXPECT_NEAR(path.optimal_fiber_length + path.tendon_slack_length, neutral, 1e-12);
      EXPECT_NEAR(path.natural_length, neutral + 0.5 * path.optimal_fiber_length, 1e-12);
      EXPECT_GE(path.tendon_slack_length, 0.0) << path.name;
    }
  }
}

// Everything that forks is held: three wires or more, not all to one body.
TEST(WholeBody, HoldsEveryVirtualLinkByThreeWires) {
  const MusculoskeletalModel model = whole_body({});
  std::map<int, int> wires;
  for (const PathElement& path : model.paths) {
    for (const PathPoint& point : path.points) {
      if (model.bodies[static_cast<std::size_t>(point.body)].virtual_link) ++wires[point.body];
    }
  }
  for (std::size_t b = 1; b < model.bodies.size(); ++b) {
    if (!model.bodies[b].virtual_link) continue;
    EXPECT_GE(wires[static_cast<int>(b)], 3) << model.bodies[b].name;
  }
}

// The bone that a point belongs to: its body, or what its virtual link hangs from.
int bone_of(const MusculoskeletalModel& model, int body) {
  while (model.bodies[static_cast<std::size_t>(body)].virtual_link) {
    body = model.joints[static_cast<std::size_t>(body) - 1].parent;
  }
  return body;
}

// A virtual link hangs from the bone that most of its wires touch next.
TEST(WholeBody, HangsVirtualLinksFromTheBoneOfMostWires) {
  const MusculoskeletalModel model = whole_body({});
  std::map<int, std::map<int, int>> touches;  // virtual link → bone → wires
  for (const PathElement& path : model.paths) {
    for (std::size_t i = 0; i < path.points.size(); ++i) {
      const int body = path.points[i].body;
      if (!model.bodies[static_cast<std::size_t>(body)].virtual_link) continue;
      const std::size_t next = i == 0 ? 1 : i - 1;
      ++touches[body][bone_of(model, path.points[next].body)];
    }
  }
  for (auto& [link, bones] : touches) {
    const Body& body = model.bodies[static_cast<std::size_t>(link)];
    int most = 0;
    for (const auto& [bone, wires] : bones) most = std::max(most, wires);
    const int parent = bone_of(model, link);
    EXPECT_EQ(bones[parent], most) << body.name;
  }
}

TEST(WholeBody, WearsMarkersOnEverySegment) {
  const MusculoskeletalModel model = whole_body();
  EXPECT_EQ(model.markers.size(), 70u);
  for (const char* bone : {"skull", "pelvis", "T1", "femur_r", "tibia_r", "calcn_r", "humerus_r",
                           "ulna_r", "hand_r", "hand_l", "calcn_l"}) {
    const int body = model.find_body(bone);
    ASSERT_GT(body, 0) << bone;
    const auto wears = [&](const Marker& marker) { return marker.body == body; };
    EXPECT_TRUE(std::any_of(model.markers.begin(), model.markers.end(), wears)) << bone;
  }
}

// --- Options and tables. ---

TEST(WholeBody, RefusesOptionsOutOfBounds) {
  const auto error = [](const WholeBodyOptions& options) -> std::string {
    try {
      whole_body(options);
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "no error";
  };
  EXPECT_EQ(error({.height = 1.0}), "WholeBodyOptions::height is 1 m; it must be 1.2 to 2.3");
  EXPECT_EQ(error({.height = kNaN}), "WholeBodyOptions::height is nan m; it must be 1.2 to 2.3");
  EXPECT_EQ(error({.height = 180.0}), "WholeBodyOptions::height is 180 m; it must be 1.2 to 2.3");
  EXPECT_EQ(error({.mass = 0.0}), "WholeBodyOptions::mass is 0 kg; it must be 20 to 250");
  EXPECT_EQ(error({.mass = 1e9}), "WholeBodyOptions::mass is 1000000000 kg; it must be 20 to 250");
}

TEST(WholeBody, IsFoundByName) {
  EXPECT_EQ(find_whole_body("whole-body")->level, Level::kSimplified);
  EXPECT_EQ(find_whole_body("whole-body-detailed")->level, Level::kDetailed);
  EXPECT_FALSE(find_whole_body("whole_body"));
}

TEST(WholeBody, ScalesWithHeightAndMassInBothSexes) {
  const Neutral reference({});
  for (const Sex sex : {Sex::kMale, Sex::kFemale}) {
    for (const double height : {1.20, 1.62, 2.30}) {
      const Neutral body({.height = height, .mass = 62.5, .sex = sex});
      EXPECT_NEAR(body.model.total_mass(), 62.5, 1e-12);
      EXPECT_EQ(body.model.paths.size(), reference.model.paths.size());
      for (std::size_t b = 1; b < body.model.bodies.size(); ++b) {
        const Vector3d expected = height / 1.80 * reference.ws.X_WB[b].p;
        EXPECT_LE((body.ws.X_WB[b].p - expected).norm(), 1e-12) << body.model.bodies[b].name;
      }
      for (std::size_t w = 0; w < body.model.paths.size(); ++w) {
        const double expected = height / 1.80 * reference.model.paths[w].natural_length;
        EXPECT_NEAR(body.model.paths[w].natural_length, expected, 1e-12);
      }
      EXPECT_NO_THROW(SimbodyModel{body.model});
    }
  }
}

}  // namespace
}  // namespace sinew
