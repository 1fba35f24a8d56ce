#include "model/whole_body.h"

#include <gtest/gtest.h>

#include <cctype>
#include <cmath>
#include <fstream>
#include <map>
#include <random>
#include <sstream>

#include "data/reference_walk.h"
#include "model/kinematic_tree.h"
#include "model/osim_file.h"
#include "model/path_length.h"
#include "model/simbody_model.h"
#include "tests/model/random_model.h"
#include "tests/model/shared_models.h"

namespace sinew {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Level = WholeBodyOptions::Level;
using Sex = WholeBodyOptions::Sex;

constexpr double kPoseTolerance = 1e-12;  // rounding of chains of some 30 products near 1
constexpr double kMassTolerance = 0.01;   // of mass, of length and of moment of inertia

int dof(const MusculoskeletalModel& model) {
  return static_cast<int>(model.coordinates.size() - model.couplers.size());
}

RigidTransform pose(const MusculoskeletalModel& model, const KinematicWorkspace& ws,
                    const std::string& body) {
  return ws.X_WB[static_cast<std::size_t>(model.find_body(body))];
}

// --- Masses. ---

struct SegmentFigures {
  const char* name;  // as in the file of the source
  double mass, length, centre, sagittal, transverse, longitudinal;
};

// De Leva 1996, table 4, men; the lengths of a man of 1.741 m [m].
constexpr SegmentFigures kMen[] = {
    {"Head", 0.0694, 0.2033, 0.5976, 0.362, 0.376, 0.312},
    {"Upper trunk", 0.1596, 0.1707, 0.2999, 0.716, 0.454, 0.659},
    {"Middle trunk", 0.1633, 0.2155, 0.4502, 0.482, 0.383, 0.468},
    {"Lower trunk", 0.1117, 0.1457, 0.6115, 0.615, 0.551, 0.587},
    {"Upper arm", 0.0271, 0.2817, 0.5772, 0.285, 0.269, 0.158},
    {"Forearm", 0.0162, 0.2689, 0.4574, 0.276, 0.265, 0.121},
    {"Hand", 0.0061, 0.0862, 0.7900, 0.628, 0.513, 0.401},
    {"Thigh", 0.1416, 0.4222, 0.4095, 0.329, 0.329, 0.149},
    {"Shank", 0.0433, 0.4340, 0.4395, 0.251, 0.246, 0.102},
    {"Foot", 0.0137, 0.2581, 0.4415, 0.257, 0.245, 0.124},
};

std::vector<std::string> bones_of(const std::string& segment) {
  const auto vertebrae = [](char region, int from, int to) {
    std::vector<std::string> names;
    for (int i = from; i <= to; ++i) names.push_back(region + std::to_string(i));
    return names;
  };
  const auto with = [](std::vector<std::string> list, const std::vector<std::string>& more) {
    list.insert(list.end(), more.begin(), more.end());
    return list;
  };
  if (segment == "Head") return with(vertebrae('C', 1, 7), {"skull"});
  if (segment == "Upper trunk") {
    return with(vertebrae('T', 1, 9), {"clavicle_r", "clavicle_l", "scapula_r", "scapula_l"});
  }
  if (segment == "Middle trunk") return with(vertebrae('T', 10, 12), vertebrae('L', 1, 4));
  if (segment == "Lower trunk") return {"pelvis", "L5"};
  if (segment == "Upper arm") return {"humerus_r"};
  if (segment == "Forearm") return {"ulna_r", "radius_r"};
  if (segment == "Thigh") return {"femur_r", "patella_r"};
  if (segment == "Shank") return {"tibia_r"};
  if (segment == "Foot") return {"calcn_r", "hallux_r", "toes_r"};
  std::vector<std::string> hand = {"hand_r", "metacarpal1_r", "thumb_proximal_r", "thumb_distal_r"};
  for (const char* finger : {"index", "middle", "ring", "little"}) {
    hand.push_back(std::string(finger) + "_proximal_r");
    hand.push_back(std::string(finger) + "_distal_r");
  }
  return hand;
}

struct Composite {
  double mass = 0.0;
  Vector3d centre = Vector3d::Zero();
  Matrix3d inertia = Matrix3d::Zero();
};

// Of some bodies, in the world, about their common mass centre.
Composite composite(const MusculoskeletalModel& model, const KinematicWorkspace& ws,
                    const std::vector<std::string>& bones) {
  Composite whole;
  for (const std::string& bone : bones) {
    const Body& body = model.bodies[static_cast<std::size_t>(model.find_body(bone))];
    whole.mass += body.mass;
    whole.centre += body.mass * (pose(model, ws, bone) * body.p_BCm);
  }
  whole.centre /= whole.mass;
  for (const std::string& bone : bones) {
    const Body& body = model.bodies[static_cast<std::size_t>(model.find_body(bone))];
    const RigidTransform X_WB = pose(model, ws, bone);
    const Matrix3d r = skew(X_WB * body.p_BCm - whole.centre);
    whole.inertia += X_WB.R * body.I_BCm * X_WB.R.transpose() - body.mass * r * r;
  }
  return whole;
}

// End points of a segment in the neutral pose: first end point, unit vector to the second, and the
// columns of the sagittal, transverse and longitudinal axes.
struct Ends {
  Vector3d first;
  Vector3d along;
  int sagittal, transverse, longitudinal;  // of X, Y, Z
};

Ends ends_of(const MusculoskeletalModel& model, const KinematicWorkspace& ws,
             const std::string& segment, double scale) {
  const auto at = [&](const char* body) { return pose(model, ws, body).p; };
  const Vector3d down = -Vector3d::UnitY();
  const auto above_hips = [&](double y) { return Vector3d(at("pelvis") + Vector3d(0.0, y, 0.0)); };
  if (segment == "Upper trunk") return {above_hips(0.5319 * scale), down, 0, 2, 1};
  if (segment == "Middle trunk") return {above_hips(0.3612 * scale), down, 0, 2, 1};
  if (segment == "Lower trunk") return {above_hips(0.1457 * scale), down, 0, 2, 1};
  if (segment == "Upper arm") return {at("humerus_r"), down, 0, 2, 1};
  if (segment == "Forearm") return {at("ulna_r"), down, 0, 2, 1};
  if (segment == "Hand") return {at("hand_r"), down, 2, 0, 1};  // palm to the thigh
  if (segment == "Thigh") return {at("femur_r"), down, 0, 2, 1};
  if (segment == "Shank") return {at("tibia_r"), down, 0, 2, 1};
  // The heel stands 60 mm behind the ankle, at 0.45 of the ankle's height of 70.2 mm.
  if (segment == "Foot") {
    return {at("calcn_r") + Vector3d(-0.060, -0.55 * 0.0702, 0.0), Vector3d::UnitX(), 1, 2, 0};
  }
  return {Vector3d(at("pelvis").x(), 1.80 - 0.0702, 0.0), down, 0, 2, 1};  // head; ankle at 0.0702
}

struct Neutral {
  explicit Neutral(const WholeBodyOptions& options)
      : model(whole_body(options)), tree(compile_tree(model)), ws(tree) {
    update_poses(tree, ws);
  }
  MusculoskeletalModel model;
  KinematicTree tree;
  KinematicWorkspace ws;
};

void expect_segment(const Neutral& body, const SegmentFigures& figures, double length,
                    double mass) {
  SCOPED_TRACE(figures.name);
  const Composite found = composite(body.model, body.ws, bones_of(figures.name));
  Ends ends = ends_of(body.model, body.ws, figures.name, 1.80 / 1.741);
  // The vertex is 1.80 m above the floor, the ankles 0.0702 m.
  if (std::string(figures.name) == "Head") {
    ends.first.y() += pose(body.model, body.ws, "calcn_r").p.y();
  }
  EXPECT_NEAR(found.mass, mass * figures.mass, 1e-3 * mass * figures.mass);
  const Vector3d centre = ends.first + figures.centre * length * ends.along;
  EXPECT_LE((found.centre - centre).norm(), kMassTolerance * figures.centre * length);
  const auto moment = [&](double radius) {
    return mass * figures.mass * std::pow(radius * length, 2);
  };
  const struct {
    int axis;
    double moment;
  } kMoments[] = {{ends.sagittal, moment(figures.sagittal)},
                  {ends.transverse, moment(figures.transverse)},
                  {ends.longitudinal, moment(figures.longitudinal)}};
  for (const auto& expected : kMoments) {
    EXPECT_NEAR(found.inertia(expected.axis, expected.axis), expected.moment,
                kMassTolerance * expected.moment);
    for (int other = 0; other < 3; ++other) {
      if (other == expected.axis) continue;
      EXPECT_LE(std::abs(found.inertia(expected.axis, other)), kMassTolerance * expected.moment);
    }
  }
}

TEST(WholeBody, HasTheSegmentsOfItsSource) {
  const Neutral body({});
  for (const SegmentFigures& figures : kMen) {
    expect_segment(body, figures, 1.80 / 1.741 * figures.length, 75.0);
  }
  EXPECT_NEAR(body.model.total_mass(), 75.0, 1e-12);
}

// The same, of men and women, from a published transcription of the tables.
TEST(WholeBody, HasTheSegmentsOfThePublishedFile) {
  SINEW_SKIP_WITHOUT_SHARED_DATA();
  for (const Sex sex : {Sex::kMale, Sex::kFemale}) {
    const char* name = sex == Sex::kMale ? "BSPmale_ZdeLeva.txt" : "BSPfemale_ZdeLeva.txt";
    SCOPED_TRACE(name);
    std::ifstream file(kSharedData / "BMC/data" / name);
    ASSERT_TRUE(file.good());
    const Neutral body({.mass = 60.0, .sex = sex});
    int compared = 0;
    for (std::string line; std::getline(file, line);) {
      std::istringstream fields(line);
      std::string segment, ends;
      SegmentFigures figures{};
      std::getline(fields, segment, '\t');
      std::getline(fields, ends, '\t');
      fields >> figures.mass >> figures.centre >> figures.sagittal >> figures.transverse >>
          figures.longitudinal;
      for (const SegmentFigures& man : kMen) {
        // The foot's row is the only one of its name; the shank's other end points differ.
        if (segment != man.name || !fields) continue;
        figures.name = man.name;
        expect_segment(body, figures, 1.80 / 1.741 * man.length, 60.0);
        ++compared;
      }
    }
    EXPECT_EQ(compared, 10);
    EXPECT_NEAR(body.model.total_mass(), 60.0, 1e-12);
  }
}

// --- Skeleton. ---

TEST(WholeBody, HasTheDegreesOfFreedomOfTheIssue) {
  const MusculoskeletalModel model = whole_body({.level = Level::kSimplified});
  EXPECT_EQ(dof(model), 155);
  EXPECT_EQ(model.virtual_link_count(), 0);
}

// Hips, knees, feet, shoulders and elbows stand and turn as in the embedded walk, so that its
// curves mean the same here.
TEST(WholeBody, MovesAsTheEmbeddedWalkDoes) {
  const MusculoskeletalModel walk = parse_osim("walk.osim", reference_walk_model());
  const MusculoskeletalModel body = whole_body({.level = Level::kSimplified});
  const KinematicTree walk_tree = compile_tree(walk), body_tree = compile_tree(body);
  KinematicWorkspace walk_ws(walk_tree), body_ws(body_tree);
  std::mt19937 random(5);
  std::uniform_real_distribution<double> value(-0.5, 0.5);
  for (int trial = 0; trial < 10; ++trial) {
    int shared = 0;
    for (std::size_t c = 0; c < walk.coordinates.size(); ++c) {
      const Coordinate& coordinate = walk.coordinates[c];
      const int other = body.find_coordinate(coordinate.name);
      // The walk's back is one joint at the navel, its toes one body.
      if (other < 0 || coordinate.name.starts_with("mtp")) continue;
      const double q = trial == 0 ? coordinate.default_value : value(random);
      walk_ws.q[static_cast<std::size_t>(walk_tree.q_of_coordinate[c])] = q;
      body_ws
          .q[static_cast<std::size_t>(body_tree.q_of_coordinate[static_cast<std::size_t>(other)])] =
          q;
      ++shared;
    }
    EXPECT_EQ(shared, 26);
    update_poses(walk_tree, walk_ws);
    update_poses(body_tree, body_ws);
    for (const char* name :
         {"pelvis", "femur_r", "tibia_r", "patella_r", "calcn_r", "humerus_r", "ulna_r", "femur_l",
          "tibia_l", "patella_l", "calcn_l", "humerus_l", "ulna_l"}) {
      const RigidTransform A = pose(walk, walk_ws, name), B = pose(body, body_ws, name);
      EXPECT_LE((A.p - B.p).norm(), 1e-8) << name;  // the tables have six digits of a millimetre
      EXPECT_LE((A.R - B.R).norm(), 1e-12) << name;
    }
  }
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
    for (int i = 0; i < state.getNU(); ++i) {
      if (!std::isfinite(state.getUDot()[i])) what = "not finite";
    }
  } catch (const std::exception& error) {
    what = error.what();
  }
  EXPECT_NE(what, "");
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
    if (body.source.file != "model/whole_body/virtual_links_leg.csv") continue;
    int most = 0;
    for (const auto& [bone, wires] : bones) most = std::max(most, wires);
    const int parent = bone_of(model, link);
    EXPECT_EQ(bones[parent], most) << body.name;
  }
}

// Markers of the embedded walk stand where they stand there; there are more of them, on every
// segment.
TEST(WholeBody, WearsTheMarkersOfTheEmbeddedWalk) {
  const MusculoskeletalModel walk = parse_osim("walk.osim", reference_walk_model());
  const KinematicTree walk_tree = compile_tree(walk);
  KinematicWorkspace walk_ws(walk_tree);
  update_poses(walk_tree, walk_ws);
  const Neutral body({});
  EXPECT_EQ(body.model.markers.size(), 70u);
  EXPECT_EQ(walk.markers.size(), 43u);
  for (const Marker& marker : walk.markers) {
    const int other = body.model.find_marker(marker.name);
    ASSERT_GE(other, 0) << marker.name;
    const Marker& found = body.model.markers[static_cast<std::size_t>(other)];
    const Vector3d expected = walk_ws.X_WB[static_cast<std::size_t>(marker.body)] * marker.p_BM;
    const Vector3d place = body.ws.X_WB[static_cast<std::size_t>(found.body)] * found.p_BM;
    EXPECT_LE((place - expected).norm(), 1e-6) << marker.name;  // four digits of a millimetre
  }
  std::map<std::string, int> on_body;
  for (const Marker& marker : body.model.markers) {
    ++on_body[body.model.bodies[static_cast<std::size_t>(marker.body)].name];
  }
  for (const char* name : {"skull", "pelvis", "femur_r", "femur_l", "tibia_r", "tibia_l", "calcn_r",
                           "calcn_l", "humerus_r", "humerus_l"}) {
    EXPECT_GE(on_body[name], 3) << name;
  }
  for (const char* name : {"C7", "T1", "T6", "T10", "L3", "hand_r", "hand_l", "hallux_r"}) {
    EXPECT_GE(on_body[name], 1) << name;
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

// The message of the body made from tables one of which has `from` replaced by `to` once.
std::string error_with(const std::string& name, const std::string& from, const std::string& to) {
  const std::string file = "model/whole_body/" + name + ".csv";
  std::vector<anatomy::EmbeddedTable> tables;
  std::string spoiled;
  for (const anatomy::EmbeddedTable& table : anatomy::whole_body_tables()) {
    tables.push_back(table);
    if (table.file != file) continue;
    spoiled = std::string(table.text);
    const std::size_t at = spoiled.find(from);
    if (at == std::string::npos) return "'" + from + "' does not stand in the table";
    spoiled.replace(at, from.size(), to);
  }
  for (anatomy::EmbeddedTable& table : tables) {
    if (table.file == file) table.text = spoiled;
  }
  try {
    whole_body({}, tables);
  } catch (const InputError& error) {
    const std::string text = error.what();
    const std::size_t line = text.find(':') + 1;
    EXPECT_EQ(text.substr(0, line), file + ":");
    EXPECT_TRUE(std::isdigit(static_cast<unsigned char>(text[line]))) << text;
    return text.substr(text.find(':', line) + 2);
  }
  return "no error";
}

struct SpoiledTable {
  const char* table;
  const char* from;
  const char* to;
  const char* error;
};

constexpr SpoiledTable kSpoiledTables[] = {
    {"joints", "bone,parent,x,", "bone,parent,",
     "column 'x' is missing; expected columns "
     "bone,parent,x,y,z,coordinates,axes,ranges,joint,coupling, found "
     "bone,parent,y,z,coordinates,axes,ranges,joint,coupling. Correct the header."},
    {"joints", "bone,parent,", "bone,bone,",
     "a column stands twice; expected columns "
     "bone,parent,x,y,z,coordinates,axes,ranges,joint,coupling, found bone. Correct the header."},
    {"joints", "bone,parent,", "bone,parents,",
     "a column is unknown; expected columns "
     "bone,parent,x,y,z,coordinates,axes,ranges,joint,coupling, found parents. Correct the "
     "header."},
    {"joints", "L5,pelvis,-40,", "L5,pelvis,",
     "the row has another number of fields than the header; expected 10, found 9. Add or remove "
     "commas."},
    {"joints", "L5,pelvis,-40,", "L5,pelvis,abc,",
     "field 'x' is unusable; expected a finite number, found abc. Correct the number."},
    {"joints", "L5,pelvis,-40,", "L5,pelvis,nan,",
     "field 'x' is unusable; expected a finite number, found nan. Correct the number."},
    {"joints", "L5,pelvis,-40,", "L5,pelvis,,",
     "field 'x' is unusable; expected a finite number, found nothing. Correct the number."},
    {"joints", "L5,pelvis,", "L5,T5,",
     "field 'parent' is unusable; expected ground or the bone of an earlier row, found T5. Correct "
     "the name or the order of the rows."},
    {"joints", "L5_extension L5_bending L5_rotation,Z X Y", "L5_extension L5_bending,Z X Y",
     "field 'axes' is unusable; expected as many as coordinates, 2, found Z X Y. Give each "
     "coordinate an axis."},
    {"joints", "Z X Y,-10:7 -3:3 -3:3", "Z X Y,-10:7 -3:3",
     "field 'ranges' is unusable; expected as many as coordinates, 3, found -10:7 -3:3. Give each "
     "coordinate a range."},
    {"joints", "Z X Y,-10:7", "Z X Y,10:-7",
     "field 'ranges' is unusable; expected low:high around the default, 0 unless given between "
     "them, found 10:-7. Correct the range."},
    {"joints", "Z X Y,-10:7", "Z X Y,-10",
     "field 'ranges' is unusable; expected 2 to 3 numbers joined by ':', found -10. Correct the "
     "numbers."},
    {"joints", "Z X Y,-10:7", "Z W Y,-10:7",
     "field 'axes' is unusable; expected X, Y, Z, -X, -Y, -Z or three numbers joined by ':', found "
     "W. Correct the axis."},
    {"joints", "Z 0.684:0.669:-0.290", "Z 0.684:0.669",
     "field 'axes' is unusable; expected 3 numbers joined by ':', found 0.684:0.669. Correct the "
     "numbers."},
    {"joints", "Z 0.684:0.669:-0.290", "Z 0:0:0",
     "field 'axes' is unusable; expected an axis that has a direction, found 0:0:0. Correct it."},
    {"joints", "Z X Y x y z", "Z X Y x x z",
     "field 'axes' is unusable; expected each shift once, found Z X Y x x z. Remove one of them."},
    {"joints", "0.65:knee_angle_r\n", "0.65:elbow_flex_r\n",
     "field 'coupling' is unusable; expected slope:coordinate, of an earlier row, for a joint of "
     "one coordinate, found 0.65:elbow_flex_r. Correct the coupling."},
    {"joints", "0.65:knee_angle_r\n", "half:knee_angle_r\n",
     "field 'coupling' is unusable; expected 1 numbers joined by ':', found half. Correct the "
     "numbers."},
    {"joints", "T12,L1,", "L3,L1,",
     "field 'bone' is unusable; expected a name that is not taken, found L3. Rename one of the "
     "bones."},
    {"segment_places", "thigh,femur_r", "thai,femur_r",
     "field 'segment' is unusable; expected a male segment of model/whole_body/segments.csv, found "
     "thai. Correct the name or add the row."},
    {"segments", "thigh,male,14.16,422.2", "thigh,male,14.16,",
     "field 'length_mm' is unusable; expected a finite number, found nothing. Correct the number."},
    {"segment_places", "head,pelvis", "head,neck",
     "field 'bone' is unusable; expected a bone of model/whole_body/joints.csv, found neck. "
     "Correct "
     "the name."},
    {"segment_places", "thigh,femur_r,0,0,0,-Y,X", "thigh,femur_r,0,0,0,-Y,Y",
     "field 'sagittal' is unusable; expected an axis square to 'along', found Y. Correct it."},
    {"bones", "T9,upper_trunk,0.1,", "T9,upper_trunk,0.2,",
     "field 'segment' is unusable; expected shares in model/whole_body/bones.csv that add up to 1, "
     "found 1.1 for upper_trunk. Correct the shares."},
    {"bones", "T9,upper_trunk,0.1,", "T9,upper_trunk,-0.1,",
     "field 'share' is unusable; expected 'rest' or a positive number, found -0.1. Correct the "
     "share."},
    {"bones", "L5,lower_trunk,0.1,", "L5,lower_trunk,1,",
     "field 'segment' is unusable; expected shares in model/whole_body/bones.csv below 1 in sum, "
     "found 1 for lower_trunk. Correct the shares."},
    {"bones", "L5,lower_trunk,0.1,", "L5,lower_trunk,rest,",
     "field 'share' is unusable; expected one rest, found another. Give it a number."},
    {"bones", "hallux_r,foot,0.056,35", "hallux_r,foot,0.056,350",
     "field 'share' is unusable; expected others that leave an inertia which a body can have, "
     "found "
     "rest. Make the others smaller or move them inward."},
    {"bones", "T12,middle_trunk,0.145", "T11,middle_trunk,0.145",
     "field 'bone' is unusable; expected each bone once, found T11. Remove one of the rows."},
    {"landmarks_leg", "asis_r,pelvis,", "asis_r,pelvic,",
     "field 'bone' is unusable; expected a bone of model/whole_body/joints.csv, found pelvic. "
     "Correct the name."},
    {"landmarks_leg", "aiis_r,pelvis,", "asis_r,pelvis,",
     "field 'landmark' is unusable; expected a name that is not taken, found asis_r. Rename one of "
     "them."},
    {"landmarks_leg", "asis_r,pelvis,", "asis,pelvis,",
     "field 'z' is unusable; expected 0, or a name that ends in _r, found 118. Name the side, or "
     "move it."},
    {"landmarks_leg", "lesser_trochanter_r,", "lesser_trochanter,",
     "field 'landmark' is unusable; expected a name that ends in _r, as its bone's does, found "
     "lesser_trochanter. Add the side."},
    {"virtual_links_leg", "achilles_r,tibia_r", "achilles_r,shin_r",
     "field 'bone' is unusable; expected a bone of model/whole_body/joints.csv, found shin_r. "
     "Correct the name."},
    {"wires_leg", "soleus_r,medial,muscle,detailed", "soleus_r,medial,muscle,fine",
     "field 'level' is unusable; expected simplified, detailed or both, found fine. Correct the "
     "level."},
    {"wires_leg", "soleus_r,medial,muscle,", "soleus_r,medial,rope,",
     "field 'kind' is unusable; expected muscle, tendon or ligament, found rope. Correct the "
     "kind."},
    {"wires_leg", "soleus_r,medial,", "soleus_r,central,",
     "field 'slip' is unusable; expected a wire's name that is not taken, found soleus_central_r. "
     "Name the slip."},
    {"wires_leg", "soleus_r,medial,muscle,detailed,1195,", "soleus_r,medial,muscle,detailed,0,",
     "field 'force' is unusable; expected a number above 0, at most 10000, found 0. Correct the "
     "number."},
    {"wires_leg", "soleus_tibia_low_r @achilles_r", "soleus_tibia_deep_r @achilles_r",
     "field 'path' is unusable; expected landmarks of model/whole_body/landmarks_*.csv, found "
     "soleus_tibia_deep_r. Correct the name or add the landmark."},
    {"wires_leg", "soleus_tibia_low_r @achilles_r", "soleus_tibia_low_r @tibia_r",
     "field 'path' is unusable; expected a virtual link of model/whole_body/virtual_links_*.csv, "
     "at "
     "level detailed, found @tibia_r. Correct the name, the level, or add the virtual link."},
    {"wires_leg", "soleus_tibia_low_r @achilles_r", "soleus_tibia_low_r @achilles_r:1:2",
     "field 'path' is unusable; expected 3 numbers joined by ':', found 1:2. Correct the numbers."},
    {"wires_leg", "soleus_tibia_low_r @achilles_r", "soleus_tibia_low_r",
     "field 'path' is unusable; expected two points or more, found soleus_tibia_low_r. Add "
     "points."},
    {"wires_leg", "soleus_tibia_low_r @achilles_r", "@achilles_r @achilles_r",
     "field 'path' is unusable; expected points 5 mm apart or more, found 0 mm. Correct the "
     "landmarks."},
    {"markers", "RTHI,femur_r", "THI,femur_r",
     "field 'marker' is unusable; expected a name that begins with R, on a bone of the right side, "
     "found THI. Rename it."},
    {"markers", "LASI,", "RASI,",
     "two markers are called 'RASI'; expected unique names. Rename one of them."},
};

TEST(WholeBody, NamesTableLineAndFieldOfWhatIsUnusable) {
  for (const SpoiledTable& spoiled : kSpoiledTables) {
    EXPECT_EQ(error_with(spoiled.table, spoiled.from, spoiled.to), spoiled.error)
        << spoiled.table << ": " << spoiled.to;
  }
}

TEST(WholeBody, AsksForEveryTable) {
  const auto all = anatomy::whole_body_tables();
  EXPECT_EQ(all.size(), 14u);
  for (std::size_t left_out = 0; left_out < all.size(); ++left_out) {
    std::vector<anatomy::EmbeddedTable> tables(all.begin(), all.end());
    tables.erase(tables.begin() + static_cast<std::ptrdiff_t>(left_out));
    std::string text = "no error";
    try {
      whole_body({}, tables);
    } catch (const InputError& error) {
      text = error.what();
    }
    EXPECT_EQ(text, std::string(all[left_out].file) +
                        ": the table is missing; expected a table of the body. Add the file and "
                        "build.");
  }
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
