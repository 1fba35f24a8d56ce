#include "model/osim_writer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>
#include <random>

#include "model/furcation.h"
#include "model/kinematic_tree.h"
#include "model/osim_file.h"
#include "model/osim_reader.h"
#include "model/path_length.h"
#include "model/whole_body.h"
#include "tests/model/random_model.h"
#include "tests/model/same_model.h"
#include "tests/model/shared_models.h"

namespace sinew {
namespace {

using Eigen::Vector3d;

// Rounding of chains of some 20 products of numbers near 1.
constexpr double kPoseTolerance = 1e-12;

// Both at the same random poses: same X_WB, same path lengths.
void expect_same_kinematics(const MusculoskeletalModel& a, const MusculoskeletalModel& b) {
  const KinematicTree tree_a = compile_tree(a, {.ignore_locks = true});
  const KinematicTree tree_b = compile_tree(b, {.ignore_locks = true});
  KinematicWorkspace at_a(tree_a), at_b(tree_b);
  std::mt19937 random(11);
  for (int pose = 0; pose < 3; ++pose) {
    const std::vector<double> q = random_pose(a, random);
    for (std::size_t c = 0; c < q.size(); ++c) {
      at_a.q[static_cast<std::size_t>(tree_a.q_of_coordinate[c])] = q[c];
      at_b.q[static_cast<std::size_t>(tree_b.q_of_coordinate[c])] = q[c];
    }
    update_poses(tree_a, at_a);
    update_poses(tree_b, at_b);
    for (std::size_t l = 0; l < at_a.X_WB.size(); ++l) {
      EXPECT_LT((at_a.X_WB[l].R - at_b.X_WB[l].R).norm(), kPoseTolerance) << a.bodies[l].name;
      EXPECT_LT((at_a.X_WB[l].p - at_b.X_WB[l].p).norm(),
                kPoseTolerance * (1.0 + at_a.X_WB[l].p.norm()))
          << a.bodies[l].name;
    }
    for (std::size_t i = 0; i < a.paths.size(); ++i) {
      const double length = path_length(a.paths[i], tree_a, at_a);
      EXPECT_NEAR(path_length(b.paths[i], tree_b, at_b), length, kPoseTolerance * (1.0 + length))
          << a.paths[i].name;
    }
  }
}

void expect_round_trip(const MusculoskeletalModel& model) {
  const std::string text = write_osim(model);
  const MusculoskeletalModel again = parse_osim("written.osim", text);
  EXPECT_EQ(again.document_version, 40000);
  std::string name = model.name;
  std::replace(name.begin(), name.end(), ' ', '_');
  EXPECT_EQ(again.name, name);
  EXPECT_TRUE(again.unsupported.empty());
  expect_same(model, again);
  expect_same_kinematics(model, again);
}

TEST(OsimWriter, WritesEveryPublishedModelAsItReadsIt) {
  SINEW_SKIP_WITHOUT_SHARED_DATA();
  int models = 0;
  for (const auto& path : shared_models()) {
    if (has_no_bodies(path)) continue;
    SCOPED_TRACE(path);
    expect_round_trip(read_osim(path));
    ++models;
  }
  EXPECT_EQ(models, 46);
}

// Their author leaves classes and stiffness to the writer; all else comes back.
TEST(OsimWriter, WritesTheWholeBody) {
  for (const auto level :
       {WholeBodyOptions::Level::kSimplified, WholeBodyOptions::Level::kDetailed}) {
    const MusculoskeletalModel model = whole_body({.level = level});
    const MusculoskeletalModel again = parse_osim("body.osim", write_osim(model));
    EXPECT_TRUE(losses_of_osim(model).empty());
    expect_same(model.bodies, again.bodies);
    expect_same(model.joints, again.joints);
    expect_same(model.coordinates, again.coordinates);
    expect_same(model.couplers, again.couplers);
    expect_same(model.markers, again.markers);
    expect_same_kinematics(model, again);
    ASSERT_EQ(model.paths.size(), again.paths.size());
    for (std::size_t i = 0; i < model.paths.size(); ++i) {
      EXPECT_EQ(again.paths[i].name, model.paths[i].name);
      EXPECT_EQ(again.paths[i].kind, model.paths[i].kind);
      EXPECT_NEAR(again.paths[i].natural_length, model.paths[i].natural_length, 1e-12);
      if (model.paths[i].kind != PathElement::Kind::kMuscle) continue;
      EXPECT_EQ(again.paths[i].max_isometric_force, model.paths[i].max_isometric_force);
    }
  }
}

// Poses and lengths that OpenSim itself has of what was written, moved at all coordinates, virtual
// links' too.
void expect_poses_of_opensim(const MusculoskeletalModel& model, const char* golden) {
  std::ifstream file(golden);
  const nlohmann::json poses = nlohmann::json::parse(file)["poses"];
  const KinematicTree tree = compile_tree(model, {.ignore_locks = true});
  KinematicWorkspace workspace(tree);
  ASSERT_EQ(poses.size(), 2u);
  for (const nlohmann::json& pose : poses) {
    ASSERT_EQ(pose["coordinates"].size(), model.coordinates.size());
    for (const auto& [name, value] : pose["coordinates"].items()) {
      const int c = model.find_coordinate(name);
      ASSERT_GE(c, 0) << name;
      workspace.q[static_cast<std::size_t>(tree.q_of_coordinate[static_cast<std::size_t>(c)])] =
          value;
    }
    update_poses(tree, workspace);
    ASSERT_EQ(pose["bodies"].size(), model.bodies.size() - 1);
    for (std::size_t b = 1; b < model.bodies.size(); ++b) {
      const auto values = pose["bodies"].at(model.bodies[b].name).get<std::vector<double>>();
      for (int i = 0; i < 12; ++i) {
        const RigidTransform& X = workspace.X_WB[b];
        const double found = i < 9 ? X.R(i / 3, i % 3) : X.p[i - 9];
        EXPECT_NEAR(found, values[static_cast<std::size_t>(i)], kPoseTolerance)
            << model.bodies[b].name;
      }
    }
    ASSERT_EQ(pose["lengths"].size(), model.paths.size());
    for (const PathElement& path : model.paths) {
      EXPECT_NEAR(path_length(path, tree, workspace), pose["lengths"].at(path.name).get<double>(),
                  kPoseTolerance)
          << path.name;
    }
  }
}

// Conditional and moving points, muscles and tendons.
TEST(OsimWriter, WritesWhatOpenSimPosesAndMeasuresAlike) {
  SINEW_SKIP_WITHOUT_SHARED_DATA();
  const MusculoskeletalModel model =
      furcate(read_osim(kSharedData / "opensim-models/Gait2354_Simbody/gait2354_simbody.osim"))
          .model;
  ASSERT_EQ(model.virtual_link_count(), 14);
  expect_poses_of_opensim(model, "tests/golden/osim_written.json");
}

// 144 bodies and 1206 wires.
TEST(OsimWriter, WritesAWholeBodyThatOpenSimPosesAndMeasuresAlike) {
  expect_poses_of_opensim(whole_body({.level = WholeBodyOptions::Level::kDetailed}),
                          "tests/golden/osim_whole_body.json");
}

TEST(OsimWriter, NamesWhatItLeavesOut) {
  SINEW_SKIP_WITHOUT_SHARED_DATA();
  const auto losses = losses_of_osim(
      read_osim(kSharedData / "opensim-core/Applications/ID/tests/resources/arm26.osim"));
  ASSERT_EQ(losses.size(), 1u);
  EXPECT_EQ(losses[0].text,
            "5 paths are written without the surfaces that they wrap over, which Sinew does not "
            "treat (first: 'TRIlong')");
  const auto forces = losses_of_osim(
      read_osim(kSharedData / "nimblephysics/Arnold2013Synthetic/unscaled_generic.osim"));
  ASSERT_GE(forces.size(), 2u);
  EXPECT_EQ(to_string(forces[0]).substr(to_string(forces[0]).find("unscaled_generic.osim")),
            "unscaled_generic.osim:14364: <ExpressionBasedBushingForce> is not written, as Sinew "
            "does not treat it (2 of them, first: 'PassiveAnkleBushing_r')");
}

TEST(OsimWriter, WritesModelsWithBlanksInTheirNameAsOpenSimTakesThem) {
  MusculoskeletalModel model = random_model(1, {.coupler_count = 0});
  for (Coordinate& c : model.coordinates) {
    const Joint& joint = model.joints[static_cast<std::size_t>(c.joint)];
    const auto index = static_cast<std::size_t>(&c - model.coordinates.data());
    c.motion = osim::motion_of(joint, index - static_cast<std::size_t>(joint.coordinates[0]));
  }
  model.name = "Wrist Model/2";
  EXPECT_EQ(parse_osim("written.osim", write_osim(model)).name, "Wrist_Model_2");
  ASSERT_EQ(losses_of_osim(model).size(), 1u);
  EXPECT_EQ(losses_of_osim(model)[0].text,
            "OpenSim refuses blanks and \\ / * + in names: the model 'Wrist Model/2' is written "
            "as 'Wrist_Model_2'");
}

// Everything that a description can hold and published models do not show together.
class ModelWithPaths {
 public:
  explicit ModelWithPaths(unsigned seed) : random_(seed), model_(random_model(seed)) {
    for (std::size_t j = 0; j < model_.joints.size(); ++j) {
      const Joint& joint = model_.joints[j];
      for (std::size_t i = 0; i < joint.coordinates.size(); ++i) {
        coordinate(joint.coordinates[i]).motion = osim::motion_of(joint, i);
      }
    }
    // A massless one on a free joint on which paths end would be a virtual link.
    model_.bodies[1].mass = 1.0;
    model_.bodies[1].I_BCm = Eigen::Matrix3d::Identity();
    describe_coordinates();
    add_virtual_link("fork", 3);
    add_virtual_link("other_fork", 0);
    add_paths();
    model_.welds.push_back({"weld", 2, 7, frame(), frame(), {}});
    model_.point_constraints.push_back({"point", 0, 5, vector(), vector(), {}});
    validate(model_);
  }

  const MusculoskeletalModel& model() const { return model_; }
  MusculoskeletalModel& model() { return model_; }

 private:
  double uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }
  Vector3d vector() { return {uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)}; }
  RigidTransform frame() { return {rotation_from_body_xyz(3.0 * vector()), vector()}; }
  Coordinate& coordinate(int c) { return model_.coordinates[static_cast<std::size_t>(c)]; }

  void describe_coordinates() {
    coordinate(0).range_min = -1.0 / 3.0;
    coordinate(0).range_max = std::numbers::pi;
    coordinate(0).clamped = true;
    coordinate(1).default_speed = 0.1;
    coordinate(2).prescribed = ScalarFunction{SineFunction{0.1, 0.2, 0.3, 0.4}, 1.0 / 7.0};
    coordinate(3).prescribed = ScalarFunction{PiecewiseConstantFunction{{0, 1, 2}, {3, 4, 5}}};
  }

  void add_virtual_link(const std::string& name, int parent) {
    Body body;
    body.name = name;
    body.virtual_link = true;
    Joint joint;
    joint.name = name + "_joint";
    joint.kind = Joint::Kind::kFree;
    joint.parent = parent;
    joint.child = static_cast<int>(model_.bodies.size());
    joint.X_PF.p = vector();
    for (const char* suffix : {"rx", "ry", "rz", "tx", "ty", "tz"}) {
      Coordinate c;
      c.name = name + "_" + suffix;
      c.joint = static_cast<int>(model_.joints.size());
      c.motion =
          suffix[0] == 'r' ? Coordinate::Motion::kRotational : Coordinate::Motion::kTranslational;
      joint.coordinates.push_back(static_cast<int>(model_.coordinates.size()));
      model_.coordinates.push_back(c);
    }
    model_.bodies.push_back(body);
    model_.joints.push_back(joint);
  }

  PathPoint point(const std::string& name, int body) {
    PathPoint p;
    p.name = name;
    p.body = body;
    p.p_BP = vector();
    return p;
  }

  PathElement element(PathElement::Kind kind, const std::string& class_name, int from, int to) {
    PathElement path;
    path.name = "path" + std::to_string(model_.paths.size());
    path.kind = kind;
    path.class_name = class_name;
    path.points = {point(path.name + "-P1", from), point(path.name + "-P2", to)};
    return path;
  }

  void add_muscle(const std::string& class_name, int from, int to) {
    PathElement path = element(PathElement::Kind::kMuscle, class_name, from, to);
    path.max_isometric_force = uniform(100, 1000);
    path.optimal_fiber_length = uniform(0.05, 0.3);
    path.tendon_slack_length = uniform(0.05, 0.3);
    path.pennation_angle = uniform(0.0, 0.4);
    path.natural_length = muscle_natural_length(path);
    PathPoint conditional = point(path.name + "-P3", 4);
    conditional.kind = PathPoint::Kind::kConditional;
    conditional.condition_coordinate = 5;
    conditional.condition_min = -0.25;
    conditional.condition_max = 1.0 / 3.0;
    PathPoint moving = point(path.name + "-P4", 6);
    moving.kind = PathPoint::Kind::kMoving;
    moving.location[0] = {Vector3d::UnitX(), 4, {LinearFunction{0.1, 0.2}, 1.5}};
    moving.location[1] = {Vector3d::UnitX(), 4, {SimmSpline{{-1, 0, 1}, {0.1, 0.2, 0.1}}}};
    moving.location[2] = {Vector3d::UnitX(), 6, {PolynomialFunction{{0.1, 0.2, 0.3}}}};
    path.points.insert(path.points.begin() + 1, {conditional, moving});
    model_.paths.push_back(path);
  }

  void add_paths() {
    const int fork = model_.find_body("fork"), other = model_.find_body("other_fork");
    for (const char* muscle : {"Thelen2003Muscle", "Millard2012EquilibriumMuscle",
                               "DeGrooteFregly2016Muscle", "Muscle_of_a_plugin"}) {
      add_muscle(muscle, 2, fork);
    }
    PathElement tendon = element(PathElement::Kind::kTendon, "PathSpring", fork, 1);
    tendon.natural_length = 0.1 + 0.2;
    tendon.stiffness = 1e5 / 3.0;
    tendon.dissipation = 0.01;
    model_.paths.push_back(tendon);
    PathElement ligament = element(PathElement::Kind::kLigament, "Ligament", other, 1);
    ligament.natural_length = 0.7;
    ligament.pcsa_force = 1500.0;
    model_.paths.push_back(ligament);
    model_.paths.push_back(element(PathElement::Kind::kActuator, "PathActuator", 2, 3));
  }

  std::mt19937 random_;
  MusculoskeletalModel model_;
};

TEST(OsimWriter, WritesEveryKindOfElement) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    SCOPED_TRACE(seed);
    const ModelWithPaths random(seed);
    ASSERT_EQ(random.model().virtual_link_count(), 2);
    expect_round_trip(random.model());
  }
}

// Angles at and near the singularity of body-fixed X-Y-Z.
TEST(OsimWriter, KeepsOrientationsAtTheSingularityOfTheirAngles) {
  for (const double y : {90.0, -90.0, 90.0 - 1e-6, 89.9, 0.0, -180.0}) {
    const Vector3d angles = Vector3d(37.0, y, -110.0) * std::numbers::pi / 180.0;
    const Eigen::Matrix3d R = rotation_from_body_xyz(angles);
    const Eigen::Matrix3d again = rotation_from_body_xyz(body_xyz_from_rotation(R));
    EXPECT_LT((R - again).cwiseAbs().maxCoeff(), 1e-15) << y;
  }
  EXPECT_EQ(body_xyz_from_rotation(Eigen::Matrix3d::Identity()), Vector3d::Zero());
}

// 3.3 % of stretch carries the muscles of the link.
TEST(OsimWriter, GivesTendonsWithoutStiffnessThatOfTheirMuscles) {
  ModelWithPaths random(3);
  MusculoskeletalModel& model = random.model();
  double force = 0.0;
  for (PathElement& path : model.paths) {
    if (path.kind == PathElement::Kind::kMuscle) force += path.max_isometric_force;
    if (path.kind == PathElement::Kind::kTendon) path.stiffness = path.dissipation = kNaN;
  }
  const MusculoskeletalModel again = parse_osim("written.osim", write_osim(model));
  const PathElement& tendon = again.paths[4];
  ASSERT_EQ(tendon.kind, PathElement::Kind::kTendon);
  EXPECT_NEAR(tendon.stiffness * 0.033 * tendon.natural_length, force, 1e-9 * force);
  EXPECT_EQ(tendon.dissipation, 0.0);

  model.paths[4].points.front().body = 1;  // off the virtual link
  const MusculoskeletalModel alone = parse_osim("written.osim", write_osim(model));
  EXPECT_NEAR(alone.paths[4].stiffness * 0.033 * 0.3, 1000.0, 1e-9);
}

TEST(OsimWriter, NamesClassesAndPointsThatAnAuthorLeftOut) {
  ModelWithPaths random(4);
  MusculoskeletalModel& model = random.model();
  for (PathElement& path : model.paths) {
    path.class_name.clear();
    for (PathPoint& point : path.points) point.name.clear();
  }
  const MusculoskeletalModel again = parse_osim("written.osim", write_osim(model));
  EXPECT_EQ(again.paths[0].class_name, "Millard2012EquilibriumMuscle");
  EXPECT_EQ(again.paths[0].points[3].name, "path0-P4");
  EXPECT_EQ(again.paths[4].class_name, "PathSpring");
  EXPECT_EQ(again.paths[5].class_name, "Ligament");
  EXPECT_EQ(again.paths[6].class_name, "PathActuator");
}

std::string error_of(const MusculoskeletalModel& model) {
  try {
    write_osim(model);
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

TEST(OsimWriter, RefusesWhatADocumentCannotSay) {
  const ModelWithPaths good(5);
  const auto error_after = [&](auto change) {
    MusculoskeletalModel model = good.model();
    change(model);
    return error_of(model);
  };
  EXPECT_EQ(error_after([](auto&) {}), "no error");
  EXPECT_EQ(error_after([](auto& m) { m.bodies[1].name = "left foot"; }),
            "model: the name of a body cannot stand in an .osim file; expected a name without "
            "blanks and \\ / * +, found 'left foot'. Rename it.");
  EXPECT_EQ(error_after([](auto& m) { m.joints[0].name = "a/b"; }),
            "model: the name of a joint cannot stand in an .osim file; expected a name without "
            "blanks and \\ / * +, found 'a/b'. Rename it.");
  EXPECT_EQ(error_after([](auto& m) { m.markers[0].name = ""; }),
            "model: the name of a marker cannot stand in an .osim file; expected a name without "
            "blanks and \\ / * +, found ''. Rename it.");
  EXPECT_EQ(error_after([](auto& m) { m.coordinates[0].name = "a b"; }),
            "model: the name of coordinate 'a b' cannot stand in an .osim file; expected a name "
            "without blanks and \\ / * +, found 'a b'. Rename it.");
  EXPECT_EQ(error_after([](auto& m) { m.paths[0].name = "a*b"; }),
            "model: the name of a path cannot stand in an .osim file; expected a name without "
            "blanks and \\ / * +, found 'a*b'. Rename it.");
  EXPECT_EQ(error_after([](auto& m) { m.paths[0].points[1].name = "a+b"; }),
            "model: the name of a point of 'path0' cannot stand in an .osim file; expected a name "
            "without blanks and \\ / * +, found 'a+b'. Rename it.");
  EXPECT_EQ(
      error_after([](auto& m) { m.coordinates[0].motion = Coordinate::Motion::kTranslational; }),
      "model: the motion type of coordinate 'q0' cannot stand in an .osim file; expected "
      "rotational, as joint 'joint1' makes it, found translational. Correct its motion "
      "type.");
  EXPECT_EQ(error_after([](auto& m) {
              m.paths[0].optimal_fiber_length = 0.1;
              m.paths[0].tendon_slack_length = 0.25;
              m.paths[0].natural_length = 0.3;
            }),
            "model: the natural length of muscle 'path0' cannot stand in an .osim file; expected "
            "0.4 m, which follows from fibre and tendon, found 0.3 m. Change "
            "optimal_fiber_length or tendon_slack_length instead.");
  EXPECT_EQ(error_after([](auto& m) { m.paths[4].natural_length = kNaN; }),
            "model: tendon 'path4' cannot stand in an .osim file; expected a natural length above "
            "0, found nan. Give it the length at which it becomes taut.");
  EXPECT_EQ(error_after([](auto& m) { m.paths[6].natural_length = 0.5; }),
            "model: the natural length of actuator 'path6' cannot stand in an .osim file; "
            "expected none, found 0.5 m. Make it a tendon, or remove the length.");
}

// A massless floating body is a virtual link only if a path ends on it and nothing hangs on it.
TEST(OsimWriter, RecognisesVirtualLinks) {
  ModelWithPaths random(6);
  MusculoskeletalModel model = random.model();
  for (Body& body : model.bodies) body.virtual_link = false;
  const auto links = [](const MusculoskeletalModel& m) {
    return parse_osim("written.osim", write_osim(m)).virtual_link_count();
  };
  EXPECT_EQ(links(model), 2);
  MusculoskeletalModel unheld = model;
  unheld.paths[5].points.front().body = 1;
  EXPECT_EQ(links(unheld), 1);
  MusculoskeletalModel heavy = model;
  heavy.bodies.back().mass = 1.1e-6;
  EXPECT_EQ(links(heavy), 1);
  MusculoskeletalModel carrying = model;
  Body body;
  body.name = "carried";
  Joint joint;
  joint.name = "on_the_fork";
  joint.parent = static_cast<int>(model.bodies.size()) - 1;
  joint.child = static_cast<int>(model.bodies.size());
  carrying.bodies.push_back(body);
  carrying.joints.push_back(joint);
  EXPECT_EQ(links(carrying), 1);
}

}  // namespace
}  // namespace sinew
