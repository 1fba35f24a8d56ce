#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <numbers>

#include "tests/pipeline/command_line.h"

namespace sinew {
namespace {

using Arguments = std::vector<std::string>;
using Json = nlohmann::json;
namespace fs = std::filesystem;

// Copies of published folders, because their setups write beside themselves.
class Published : public ::testing::Test {
 protected:
  void SetUp() override {
    shared_ = shared_data();
    if (shared_.empty()) GTEST_SKIP() << "needs the published recordings in ../shared/data";
  }

  const fs::path& path() const { return folder_.path(); }

  void copy(const std::string& from, const std::string& to) {
    fs::copy(shared_ / from, path() / to, fs::copy_options::recursive);
    for (const auto& entry : fs::recursive_directory_iterator(path() / to)) {
      fs::permissions(entry.path(), fs::perms::owner_write, fs::perm_options::add);
    }
  }

  // Runs a setup as it is; the table that it wrote.
  TimeTable solve(const Arguments& arguments, const fs::path& output) {
    const Outcome outcome = run_sinew(path(), arguments);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    const TimeTableFile file = read_storage(path() / output);
    EXPECT_TRUE(file.warnings.empty());
    return file.table;
  }

  TimeTable published(const std::string& file) { return read_storage(shared_ / file).table; }

  Json summary(const std::string& folder) {
    return Json::parse(content_of(path() / folder / "summary.json"));
  }

  TemporaryFolder folder_;
  fs::path shared_;
};

// Every column of the published table, within the tolerance in the table's unit. Rows are compared
// in order: their times differ by rounding.
void expect_table(const TimeTable& ours, const TimeTable& theirs, double tolerance) {
  EXPECT_EQ(ours.labels.size(), theirs.labels.size());
  ASSERT_EQ(ours.time.size(), theirs.time.size());
  EXPECT_LT((ours.time - theirs.time).cwiseAbs().maxCoeff(), 2e-3);
  for (const std::string& label : theirs.labels) {
    const int a = ours.find_column(label), b = theirs.find_column(label);
    ASSERT_GE(a, 0) << label;
    EXPECT_LE((ours.values.col(a) - theirs.values.col(b)).cwiseAbs().maxCoeff(), tolerance)
        << label;
  }
}

// OpenSim stops before it has converged: up to 0.15 degrees from the minimum.
TEST_F(Published, Gait2354SetupsAsTheyAre) {
  copy("opensim-models/Gait2354_Simbody", "g");
  const std::string reference = "opensim-models/Gait2354_Simbody/reference/";
  const TimeTable ik =
      solve({"ik", "--setup", "g/subject01_Setup_IK.xml"}, "g/subject01_walk1_ik.mot");
  EXPECT_EQ(ik.in_degrees, true);
  EXPECT_EQ(ik.labels, published(reference + "subject01_walk1_ik.mot").labels);
  expect_table(ik, published(reference + "subject01_walk1_ik.mot"), 0.15);
  // Inverse dynamics of the published angles, which the first line has just replaced.
  fs::copy_file(shared_ / (reference + "subject01_walk1_ik.mot"),
                path() / "g/subject01_walk1_ik.mot", fs::copy_options::overwrite_existing);
  const TimeTable id = solve({"id", "--setup", "g/subject01_Setup_InverseDynamics.xml"},
                             "g/ResultsInverseDynamics/inverse_dynamics.sto");
  EXPECT_EQ(id.in_degrees, false);
  expect_table(id, published(reference + "inverse_dynamics.sto"), 1.0);
}

TEST_F(Published, Gait10dof18muscSetupsAsTheyAre) {
  copy("opensim-models/Gait10dof18musc", "g");
  const std::string reference = "opensim-models/Gait10dof18musc/reference/";
  const TimeTable ik =
      solve({"ik", "--setup", "g/IK/walk_Setup_IK.xml"}, "g/IK/subject01_walk_IK.mot");
  expect_table(ik, published(reference + "subject01_walk_IK.mot"), 0.2);
  const TimeTable id =
      solve({"id", "--setup", "g/ID/walk_Setup_ID.xml"}, "g/ID/Results/subject01_walk_ID.sto");
  // OpenSim's rows stand up to 2 ms beside the recording's times, in which a force changes by 2 N.
  expect_table(id, published(reference + "subject01_walk_ID.sto"), 2.0);
}

// The tolerances are those of OpenSim's own tests: 0.2 degrees.
TEST_F(Published, OpenSimsInverseKinematicsTests) {
  copy("opensim-core/Applications/IK/tests/resources", "ik");
  const TimeTable golden =
      published("opensim-core/Applications/IK/tests/resources/std_subject01_walk1_ik.mot");
  const fs::path output = "ik/subject01_walk1_ik_test.mot";
  expect_table(solve({"ik", "--setup", "ik/subject01_Setup_InverseKinematics.xml"}, output), golden,
               0.2);
  fs::remove(path() / output);
  const std::string setup = "ik/subject01_Setup_InverseKinematics_NoModel.xml";
  const Outcome refused = run_sinew(path(), {"ik", "--setup", setup});
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_EQ(error_line(refused, path()),
            setup + ":4: <model_file> names no file. Correct the setup, or give --model FILE.");
  EXPECT_FALSE(fs::exists(path() / output));
  expect_table(solve({"ik", "--setup", setup, "--model", "ik/subject01_simbody.osim"}, output),
               golden, 0.2);
}

TEST_F(Published, OpenSimsInverseDynamicsTests) {
  copy("opensim-core/Applications/ID/tests/resources", "id");
  const TimeTable arm = solve({"id", "--setup", "id/arm26_Setup_InverseDynamics.xml"},
                              "id/Results/arm26_InverseDynamics.sto");
  expect_table(
      arm, published("opensim-core/Applications/ID/tests/resources/std_arm26_InverseDynamics.sto"),
      1e-2);
  // The ending that the setup leaves out is added; frames are those of its time range.
  const TimeTable gait = solve({"id", "--setup", "id/subject01_Setup_InverseDynamics.xml"},
                               "id/Results/subject01_InverseDynamics.sto");
  EXPECT_NEAR(gait.time[0], 0.5, 1e-6);
  EXPECT_NEAR(gait.time[gait.time.size() - 1], 1.6, 1e-5);
}

TEST_F(Published, SetupsFromAnotherMachineWorkWithOptions) {
  const std::string study = "BMC/data/opensim/Mod&Sim2018";
  copy(study, "s");
  const TimeTable ik =
      solve({"ik", "--setup", "s/IK/IK_setup.xml"}, "s/IK/results/ik_output_run.mot");
  EXPECT_EQ(ik.labels, published(study + "/IK/results/ik_output_run.mot").labels);
  Arguments arguments = {"id", "--setup", "s/ID/id_setup.xml"};
  const auto refused = [&](const std::string& message) {
    const Outcome outcome = run_sinew(path(), arguments);
    EXPECT_EQ(outcome.exit_code, 2);
    EXPECT_EQ(error_line(outcome, path()), message);
  };
  refused(
      "s/ID/id_setup.xml:9: <model_file> names no file. Correct the setup, or give --model "
      "FILE.");
  arguments.insert(arguments.end(), {"--model", "s/Scale/Rajagopal2015_scaled.osim"});
  refused(
      "s/ID/id_setup.xml:5: <results_directory> is a path of another system; expected a path, "
      "relative to the setup's folder, found H:\\OpenSim\\Mod&Sim2018\\ID\\results/"
      "inverse_dynamics.sto. Correct the setup, or give --out FILE.");
  arguments.insert(arguments.end(), {"--out", "id.sto", "--loads", "s/ID/grf_setup.xml"});
  refused(
      "s/ID/grf_setup.xml:36: <datafile> names a file that does not exist; expected a path, "
      "relative to the setup's folder, found H:\\OpenSim\\Mod&Sim2018\\ExpData\\grf_run.mot. "
      "Correct the setup, or give --load-data FILE.");
  EXPECT_EQ(tree_of(path()).size(), 1u + tree_of(path() / "s").size());
  arguments.insert(arguments.end(), {"--load-data", "s/ExpData/grf_run.mot"});
  const TimeTable id = solve(arguments, "id.sto");
  EXPECT_EQ(id.time.size(), published(study + "/ID/results/inverse_dynamics.sto").time.size());
}

// Rows of the table of recordings, each through the whole pipeline.
struct Trial {
  const char* name;
  const char* model;
  const char* markers;
  const char* tasks;
  const char* loads;
  const char* load_data;
};

std::ostream& operator<<(std::ostream& stream, const Trial& trial) { return stream << trial.name; }

#define GAIT2354 "opensim-models/Gait2354_Simbody/"
#define GAIT10 "opensim-models/Gait10dof18musc/"
#define ARNOLD "nimblephysics/Arnold2013Synthetic/subject01/"
#define BMC "BMC/data/opensim/Mod&Sim2018/"

constexpr Trial kTrials[] = {
    {"Gait2354", GAIT2354 "subject01_simbody.osim", GAIT2354 "subject01_walk1.trc",
     GAIT2354 "subject01_Setup_IK.xml", GAIT2354 "subject01_walk1_grf.xml", ""},
    {"Gait10dof18musc", GAIT10 "subject01.osim", GAIT10 "ExperimentalData/subject01_walk.trc",
     GAIT10 "IK/walk_Setup_IK.xml", GAIT10 "ExperimentalData/subject01_walk_grf.xml", ""},
    {"Arnold2013", ARNOLD "subject01.osim", ARNOLD "trials/walk2/markers.trc", "", "",
     ARNOLD "trials/walk2/grf.mot"},
    {"BmcRun", BMC "Scale/Rajagopal2015_scaled.osim", BMC "ExpData/motion_capture_run.trc",
     BMC "IK/IK_setup.xml", BMC "ID/grf_setup.xml", BMC "ExpData/grf_run.mot"}};

class PublishedTrial : public Published, public ::testing::WithParamInterface<Trial> {
 protected:
  Arguments inverse_kinematics() {
    const Trial& t = GetParam();
    Arguments all = {"--model", (shared_ / t.model).string(), "--markers",
                     (shared_ / t.markers).string()};
    if (*t.tasks != 0) all.insert(all.end(), {"--tasks", (shared_ / t.tasks).string()});
    return all;
  }

  Arguments loads() {
    const Trial& t = GetParam();
    Arguments all = {"--loads", *t.loads != 0 ? (shared_ / t.loads).string() : own_loads()};
    if (*t.load_data != 0) all.insert(all.end(), {"--load-data", (shared_ / t.load_data).string()});
    return all;
  }

  // For recordings that come without an ExternalLoads file.
  std::string own_loads() {
    std::string forces;
    for (const std::string side : {"r", "l"}) {
      forces += "<ExternalForce name=\"" + side + "\"><applied_to_body>calcn_" + side +
                "</applied_to_body><force_identifier>ground_force_" + side +
                "_v</force_identifier><point_identifier>ground_force_" + side +
                "_p</point_identifier><torque_identifier>ground_torque_" + side +
                "_</torque_identifier></ExternalForce>\n";
    }
    return folder_
        .write("loads.xml",
               "<OpenSimDocument Version=\"40000\"><ExternalLoads name=\"l\"><objects>" + forces +
                   "</objects></ExternalLoads></OpenSimDocument>\n")
        .string();
  }

  static Arguments joined(Arguments a, const Arguments& b) {
    a.insert(a.end(), b.begin(), b.end());
    return a;
  }
};

TEST_P(PublishedTrial, RunsFromMarkersToTorques) {
  const Arguments inputs = joined(inverse_kinematics(), loads());
  std::string first;
  for (const std::string threads : {"1", "2", "5"}) {
    const Outcome outcome = run_sinew(
        path(), joined(joined({"run"}, inputs), {"--threads", threads, "--out", "r" + threads}));
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    const std::string bytes = content_of(path() / ("r" + threads) / "ik.mot") +
                              content_of(path() / ("r" + threads) / "id.sto");
    if (first.empty()) first = bytes;
    EXPECT_TRUE(bytes == first) << threads << " threads";
  }
  const std::string name = GetParam().name;
  const Json json = summary("r1");
  EXPECT_EQ(json["inverse_kinematics"]["frames_not_converged"], 0);
  EXPECT_EQ(json["inverse_dynamics"]["root_residuals"].size(), name == "Gait10dof18musc" ? 3u : 6u);
  const TimeTable id = read_storage(path() / "r1/id.sto").table;
  EXPECT_TRUE(id.values.allFinite());
  EXPECT_GE(id.find_column("hip_flexion_r_moment"), 0);
  EXPECT_EQ(id.time, read_storage(path() / "r1/ik.mot").table.time);
  // Wrap objects and forces without a muscle are named where there are any.
  const std::string warnings = json["warnings"].dump();
  const bool rajagopal = name == "Arnold2013" || name == "BmcRun";
  EXPECT_EQ(warnings.find("run over wrap objects, which are not supported") != warnings.npos,
            rajagopal);
  EXPECT_EQ(warnings.find("--exact-custom-joints") != warnings.npos, rajagopal);
}

class PublishedWalk : public PublishedTrial {};

TEST_P(PublishedWalk, IsNowhereWorseThanTheAssembler) {
  const Outcome outcome = run_sinew(path(), joined(joined({"validate"}, inverse_kinematics()),
                                                   {"--every", "20", "--json", "v.json"}));
  EXPECT_EQ(outcome.exit_code, 0) << outcome.out << outcome.err;
  EXPECT_NE(outcome.out.find("\nPASS: "), std::string::npos);
  const Json json = Json::parse(content_of(path() / "v.json"));
  EXPECT_EQ(json["passed"], true);
  EXPECT_EQ(json["worse_frames"], 0);
  EXPECT_GT(json["frames"].size(), 5u);
  EXPECT_GT(json["median_time_ratio"].get<double>(), 1.0);
}

INSTANTIATE_TEST_SUITE_P(Rows, PublishedWalk, ::testing::ValuesIn(kTrials, kTrials + 3),
                         [](const auto& info) { return std::string(info.param.name); });

INSTANTIATE_TEST_SUITE_P(Rows, PublishedTrial, ::testing::ValuesIn(kTrials),
                         [](const auto& info) { return std::string(info.param.name); });

TEST_F(Published, ExactCustomJointsChangeTorquesAndEndTheWarning) {
  const std::string folder = "nimblephysics/Arnold2013Synthetic/subject01/";
  const Arguments run = {"run",
                         "--model",
                         (shared_ / (folder + "subject01.osim")).string(),
                         "--markers",
                         (shared_ / (folder + "trials/walk2/markers.trc")).string(),
                         "--to",
                         "3.6"};
  const auto solve_to = [&](const std::string& out, const Arguments& more) {
    Arguments all = run;
    all.insert(all.end(), {"--out", out});
    all.insert(all.end(), more.begin(), more.end());
    const Outcome outcome = run_sinew(path(), all);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    return outcome.err.find("(--exact-custom-joints) give torques that match") != std::string::npos;
  };
  EXPECT_TRUE(solve_to("as-opensim", {}));
  EXPECT_FALSE(solve_to("exact", {"--exact-custom-joints"}));
  EXPECT_EQ(summary("exact")["options"]["exact_custom_joints"], true);
  const TimeTable a = read_storage(path() / "as-opensim/id.sto").table;
  const TimeTable b = read_storage(path() / "exact/id.sto").table;
  const int hip = a.find_column("hip_flexion_r_moment");
  EXPECT_GT((a.values.col(hip) - b.values.col(hip)).cwiseAbs().maxCoeff(), 0.01);
  EXPECT_EQ(content_of(path() / "as-opensim/ik.mot"), content_of(path() / "exact/ik.mot"));
}

// The recording was made from these angles, without noise or filter.
TEST_F(Published, ArnoldsAnglesAndTorquesComeBack) {
  const std::string folder = "nimblephysics/Arnold2013Synthetic/subject01/";
  ASSERT_EQ(
      run_sinew(path(),
                {"ik", "--model", (shared_ / (folder + "subject01.osim")).string(), "--markers",
                 (shared_ / (folder + "trials/walk2/markers.trc")).string(), "--out", "q.mot"})
          .exit_code,
      0);
  const TimeTable ours = read_storage(path() / "q.mot").table;
  const TimeTable truth = published(folder + "coordinates.sto");
  ASSERT_EQ(ours.time.size(), truth.time.size());
  int compared = 0;
  for (const std::string& label : truth.labels) {
    const int a = ours.find_column(label), b = truth.find_column(label);
    if (a < 0) continue;  // welded in this model
    ++compared;
    const bool length = label.starts_with("pelvis_t") && label != "pelvis_tilt";
    const double unit = length ? 1.0 : 180.0 / std::numbers::pi;
    EXPECT_LE((ours.values.col(a) - unit * truth.values.col(b)).cwiseAbs().maxCoeff(), 1e-4)
        << label;
  }
  EXPECT_EQ(compared, 31);
}

}  // namespace
}  // namespace sinew
