#include "model/osim_file.h"

#include <gtest/gtest.h>

#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <regex>
#include <sstream>

#include "model/kinematic_tree.h"
#include "tests/model/shared_models.h"

namespace sinew {
namespace {

using Eigen::Vector3d;

// What a row of INDEX.md, which was made without Sinew, says of a model.
struct IndexRow {
  int version = 0;
  std::string name;
  std::size_t bodies = 0;
  double mass = 0.0;
  std::size_t coordinates = 0, locked = 0, markers = 0;
  std::map<std::string, int> joints, constraints, muscles;
};

// {'PinJoint': 5, 'WeldJoint': 4} or -
std::map<std::string, int> read_counts(const std::string& text) {
  static const std::regex kPair("'(\\w+)': (\\d+)");
  std::map<std::string, int> counts;
  for (std::sregex_iterator it(text.begin(), text.end(), kPair), end; it != end; ++it) {
    counts[(*it)[1]] = std::stoi((*it)[2]);
  }
  return counts;
}

std::map<std::string, IndexRow> read_index() {
  static const std::regex kRow(
      "\\| `([^`]+\\.osim)` \\| \\d+ \\| v(\\d+) \"([^\"]*)\": (\\d+) bodies, ([\\d.]+) kg, (\\d+) "
      "coords \\((\\d+) locked\\), joints (\\{[^}]*\\}), constraints (-|\\{[^}]*\\}), muscles "
      "(-|\\{[^}]*\\}),.*?(\\d+) markers.*");
  std::map<std::string, IndexRow> rows;
  std::ifstream file(kSharedData / "INDEX.md");
  for (std::string line; std::getline(file, line);) {
    std::smatch m;
    if (!std::regex_match(line, m, kRow)) continue;
    rows[m[1]] = {std::stoi(m[2]),   m[3],
                  std::stoul(m[4]),  std::stod(m[5]),
                  std::stoul(m[6]),  std::stoul(m[7]),
                  std::stoul(m[11]), read_counts(m[8]),
                  read_counts(m[9]), read_counts(m[10])};
  }
  return rows;
}

std::map<std::string, int> joints_by_kind(const MusculoskeletalModel& model) {
  static const char* const kNames[] = {
      "WeldJoint",   "PinJoint",    "SliderJoint", "UniversalJoint", "BallJoint",
      "GimbalJoint", "PlanarJoint", "FreeJoint",   "EllipsoidJoint", "CustomJoint"};
  std::map<std::string, int> counts;
  for (const Joint& joint : model.joints) ++counts[kNames[static_cast<int>(joint.kind)]];
  return counts;
}

std::map<std::string, int> constraints_by_kind(const MusculoskeletalModel& model) {
  std::map<std::string, int> counts;
  if (!model.couplers.empty()) {
    counts["CoordinateCouplerConstraint"] = static_cast<int>(model.couplers.size());
  }
  if (!model.welds.empty()) counts["WeldConstraint"] = static_cast<int>(model.welds.size());
  if (!model.point_constraints.empty()) {
    counts["PointConstraint"] = static_cast<int>(model.point_constraints.size());
  }
  return counts;
}

std::map<std::string, int> muscles_by_class(const MusculoskeletalModel& model) {
  std::map<std::string, int> counts;
  for (const PathElement& path : model.paths) {
    if (path.kind == PathElement::Kind::kMuscle) ++counts[path.class_name];
  }
  return counts;
}

TEST(OsimFile, ReadsEveryPublishedModelThatHasBodies) {
  SINEW_SKIP_WITHOUT_SHARED_DATA();
  for (const auto& path : shared_models()) {
    if (has_no_bodies(path)) continue;
    EXPECT_NO_THROW(validate(read_osim(path))) << path;
  }
}

TEST(OsimFile, FindsInEveryModelWhatItsIndexSays) {
  SINEW_SKIP_WITHOUT_SHARED_DATA();
  const std::map<std::string, IndexRow> rows = read_index();
  ASSERT_EQ(rows.size(), 37u);
  for (const auto& [file, row] : rows) {
    SCOPED_TRACE(file);
    if (has_no_bodies(file)) continue;
    const MusculoskeletalModel model = read_osim(kSharedData / file);
    EXPECT_EQ(model.document_version, row.version);
    EXPECT_EQ(model.name, row.name);
    EXPECT_EQ(model.bodies.size() - 1, row.bodies);
    EXPECT_NEAR(model.total_mass(), row.mass, 6e-4 * row.mass);  // the index rounds to 4 digits
    EXPECT_EQ(model.coordinates.size(), row.coordinates);
    EXPECT_EQ(std::count_if(model.coordinates.begin(), model.coordinates.end(),
                            [](const Coordinate& c) { return c.locked; }),
              static_cast<std::ptrdiff_t>(row.locked));
    EXPECT_EQ(model.markers.size(), row.markers);
    EXPECT_EQ(joints_by_kind(model), row.joints);
    EXPECT_EQ(constraints_by_kind(model), row.constraints);
    EXPECT_EQ(muscles_by_class(model), row.muscles);
  }
}

nlohmann::json golden(const char* name) {
  std::ifstream file(std::string("tests/golden/") + name);
  return nlohmann::json::parse(file);
}

// OpenSim names the same coordinate by its joint and name; joints without a name differ.
double golden_value(const nlohmann::json& coordinates, const MusculoskeletalModel& model,
                    const Coordinate& c) {
  const std::string joint = model.joints[static_cast<std::size_t>(c.joint)].name;
  if (coordinates.contains(joint + "/" + c.name)) return coordinates[joint + "/" + c.name];
  if (coordinates.contains(c.name)) return coordinates[c.name];
  for (const auto& [path, value] : coordinates.items()) {
    if (path.substr(path.find('/') + 1) == c.name) return value;
  }
  ADD_FAILURE() << "no value for " << c.name;
  return kNaN;
}

// OpenSim converts documents before version 30505 to its present layout and writes frames with six
// digits on the way. Orientations near π/2 so move by up to 5e-6 rad.
double pose_tolerance(int version) { return version < 30505 ? 1e-5 : 1e-12; }

void expect_pose(const MusculoskeletalModel& model, const nlohmann::json& pose) {
  const KinematicTree tree = compile_tree(model, {.ignore_locks = true});
  KinematicWorkspace workspace(tree);
  std::vector<double> given(model.coordinates.size());
  for (std::size_t c = 0; c < given.size(); ++c) {
    given[c] = golden_value(pose["coordinates"], model, model.coordinates[c]);
    workspace.q[static_cast<std::size_t>(tree.q_of_coordinate[c])] = given[c];
  }
  // Dependent coordinates are the tree's own to find.
  for (const CoordinateCoupler& coupler : model.couplers) {
    workspace.q[static_cast<std::size_t>(
        tree.q_of_coordinate[static_cast<std::size_t>(coupler.dependent)])] = kNaN;
  }
  update_poses(tree, workspace);
  for (std::size_t c = 0; c < given.size(); ++c) {
    EXPECT_NEAR(workspace.q[static_cast<std::size_t>(tree.q_of_coordinate[c])], given[c], 1e-14)
        << model.coordinates[c].name;
  }
  ASSERT_EQ(pose["bodies"].size(), model.bodies.size() - 1);
  for (const auto& [name, values] : pose["bodies"].items()) {
    const int body = model.find_body(name);
    ASSERT_GT(body, 0) << name;
    const RigidTransform& X_WB = workspace.X_WB[static_cast<std::size_t>(body)];
    for (int i = 0; i < 12; ++i) {
      const double found = i < 9 ? X_WB.R(i / 3, i % 3) : X_WB.p[i - 9];
      EXPECT_NEAR(found, values[static_cast<std::size_t>(i)].get<double>(),
                  pose_tolerance(model.document_version))
          << name << " " << i;
    }
  }
}

TEST(OsimFile, PosesModelsOldAndNewAsOpenSim) {
  SINEW_SKIP_WITHOUT_SHARED_DATA();
  const nlohmann::json models = golden("osim_poses.json")["models"];
  ASSERT_EQ(models.size(), 13u);
  for (const auto& [file, poses] : models.items()) {
    SCOPED_TRACE(file);
    const MusculoskeletalModel model = read_osim(kSharedData / file);
    ASSERT_EQ(poses.size(), 2u);
    for (const nlohmann::json& pose : poses) expect_pose(model, pose);
  }
}

TEST(OsimFile, TellsCoordinatesOfOneNameInTwoJointsApart) {
  SINEW_SKIP_WITHOUT_SHARED_DATA();
  const MusculoskeletalModel model = read_osim(
      kSharedData / "opensim-core/OpenSim/Simulation/Test/StationDefinedFrames_Advanced.osim");
  EXPECT_EQ(model.find_coordinate("rx"), 0);
  EXPECT_EQ(model.find_coordinate("freejoint_2/rx"), 6);
  ASSERT_EQ(model.warnings.size(), 5u);
  EXPECT_EQ(model.warnings[0].text,
            "another joint has a coordinate called 'rx' too; this one is called 'freejoint_2/rx' "
            "here and in results");
}

}  // namespace
}  // namespace sinew
