#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "tests/pipeline/command_line.h"
#include "tests/pipeline/small_trial.h"

namespace sinew {
namespace {

namespace fs = std::filesystem;
using Arguments = std::vector<std::string>;
using Json = nlohmann::json;

Json json_of(const fs::path& file) { return Json::parse(content_of(file)); }

std::set<std::string> codes_of(const Json& verdict) {
  std::set<std::string> codes;
  for (const Json& r : verdict["reasons"]) codes.insert(r["code"].get<std::string>());
  return codes;
}

double figure_of(const Json& verdict, const std::string& code) {
  for (const Json& r : verdict["reasons"]) {
    if (r["code"] == code) return r["figure"].get<double>();
  }
  return std::nan("");
}

// Lines of the digest, which begins with the kinematics.
long digest_lines(const std::string& out) {
  const std::size_t at = out.find("inverse kinematics: ");
  EXPECT_NE(at, out.npos) << out;
  return std::count(out.begin() + static_cast<std::ptrdiff_t>(at), out.end(), '\n');
}

class VerdictOfRun : public ::testing::Test {
 protected:
  VerdictOfRun() { SmallTrial::write(folder_); }
  const fs::path& path() const { return folder_.path(); }
  Outcome sinew(const Arguments& arguments) const { return run_sinew(path(), arguments); }

  TemporaryFolder folder_;
};

TEST_F(VerdictOfRun, FailsWhereMarkersAreInAnotherUnit) {
  MarkerTrajectories wrong = SmallTrial::recording();
  wrong.p_WM *= 10.0;  // millimetres that were called centimetres
  write_trc(path() / "wrong.trc", wrong);
  Arguments run = {"run", "--model", "model.osim", "--markers", "wrong.trc", "--out", "r"};
  Outcome outcome = sinew(run);
  EXPECT_EQ(outcome.exit_code, 1) << outcome.out;
  EXPECT_NE(outcome.out.find("\nverdict: not usable\n"), std::string::npos) << outcome.out;
  EXPECT_NE(outcome.out.find("`sinew check"), std::string::npos);
  // Results are written all the same, and say so themselves.
  for (const char* file : {"ik.mot", "id.sto", "summary.json"}) {
    EXPECT_TRUE(fs::exists(path() / "r" / file)) << file;
  }
  Json verdict = json_of(path() / "r/verdict.json");
  EXPECT_EQ(verdict["verdict"], "unusable");
  EXPECT_GT(figure_of(verdict, "marker-rms"), 1000.0);
  EXPECT_EQ(verdict["joints"]["hip"]["angles"], "unusable");
  EXPECT_EQ(json_of(path() / "r/summary.json")["verdict"], verdict);
  run.push_back("--accept");
  outcome = sinew(run);
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_EQ(json_of(path() / "r/verdict.json"), verdict);
}

TEST_F(VerdictOfRun, InverseKinematicsLeavesTorquesOpen) {
  const Outcome outcome =
      sinew({"ik", "--model", "model.osim", "--markers", "walk.trc", "--out", "q.mot"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  const Json verdict = json_of(path() / "q_verdict.json");
  EXPECT_EQ(verdict["verdict"], "good") << verdict.dump(2);
  EXPECT_EQ(verdict["joints"], (Json{{"floor", {{"angles", "usable"}, {"torques", "none"}}},
                                     {"hip", {{"angles", "usable"}, {"torques", "none"}}}}));
}

// Twice the weight pulls the body down, and half a body hangs on loads that carry a whole one.
TEST_F(VerdictOfRun, InverseDynamicsLooksAtTheLoads) {
  ASSERT_EQ(
      sinew({"ik", "--model", "model.osim", "--markers", "walk.trc", "--out", "q.mot"}).exit_code,
      0);
  const auto judged = [&](double factor) {
    TimeTable loads = SmallTrial::loads(0.0, (SmallTrial::kFrames - 1) * SmallTrial::kStep);
    loads.values.col(1) *= factor;
    write_storage(path() / "f.mot", loads);
    folder_.write("f.xml", SmallTrial::loads_setup("f.mot"));
    const Outcome outcome = sinew({"id", "--model", "model.osim", "--coordinates", "q.mot",
                                   "--loads", "f.xml", "--out", "id.sto"});
    const Json verdict = json_of(path() / "id_verdict.json");
    EXPECT_EQ(outcome.exit_code, verdict["verdict"] == "unusable" ? 1 : 0);
    return verdict;
  };
  Json verdict = judged(1.0);
  EXPECT_NE(verdict["verdict"], "unusable") << verdict.dump(2);
  EXPECT_FALSE(codes_of(verdict).contains("mass-carried"));
  verdict = judged(-1.0);
  EXPECT_EQ(verdict["verdict"], "unusable");
  EXPECT_NEAR(figure_of(verdict, "loads-pull-down"), -48.0 * 9.80665, 1e-6);
  verdict = judged(2.0);
  EXPECT_EQ(verdict["verdict"], "unusable");
  // The model has half of what the loads carry.
  EXPECT_NEAR(figure_of(verdict, "mass-carried"), 50.0, 1.0);
  verdict = judged(1e4);
  EXPECT_TRUE(codes_of(verdict).contains("mass-carried"));
  EXPECT_EQ(verdict["joints"]["hip"]["torques"], "unusable");
}

TEST_F(VerdictOfRun, WithoutLoadsAnglesStayUsable) {
  const Outcome outcome =
      sinew({"run", "--model", "model.osim", "--markers", "walk.trc", "--out", "r"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.out;
  const Json verdict = json_of(path() / "r/verdict.json");
  EXPECT_EQ(verdict["verdict"], "remarks");
  EXPECT_TRUE(codes_of(verdict).contains("no-loads"));
  EXPECT_EQ(verdict["joints"]["hip"]["angles"], "usable");
  EXPECT_EQ(verdict["joints"]["hip"]["torques"], "unusable");
  EXPECT_LE(digest_lines(outcome.out), 12) << outcome.out;
}

TEST_F(VerdictOfRun, StandsBesideAScaledModel) {
  const Arguments scale = {"scale",    "--auto", "--model", "model.osim",  "--markers", "walk.trc",
                           "--frames", "4",      "--out",   "fitted.osim", "--json",    "f.json"};
  const Outcome outcome = sinew(scale);
  EXPECT_EQ(outcome.exit_code, 0) << outcome.out << outcome.err;
  const Json verdict = json_of(path() / "fitted_verdict.json");
  EXPECT_NE(verdict["verdict"], "unusable") << verdict.dump(2);
  EXPECT_EQ(json_of(path() / "f.json")["verdict"], verdict);
  EXPECT_EQ(verdict["joints"]["hip"]["angles"], "none");
}

TEST_F(VerdictOfRun, NeverOverwritesAnInput) {
  fs::copy_file(path() / "walk.trc", path() / "q_verdict.json");
  const Outcome outcome =
      sinew({"ik", "--model", "model.osim", "--markers", "q_verdict.json", "--out", "q.mot"});
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_NE(outcome.err.find("is both the output and an input"), std::string::npos) << outcome.err;
}

// All that can be said of the walk that the program brings along is that fingers, vertebrae and the
// like have no markers.
TEST(VerdictOfTheEmbeddedWalk, IsUsable) {
  const TemporaryFolder folder;
  const Outcome outcome = run_sinew(folder.path(), {"run", "--out", "r"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  const Json verdict = json_of(folder.path() / "r/verdict.json");
  for (const std::string& code : codes_of(verdict)) {
    EXPECT_TRUE(code == "segment-without-marker" || code == "undetermined-coordinates") << code;
  }
  EXPECT_EQ(verdict["verdict"], "remarks");
  for (const char* joint : {"hip_r", "hip_l", "knee_r", "knee_l"}) {
    ASSERT_TRUE(verdict["joints"].contains(joint)) << joint << verdict["joints"].dump(2);
    EXPECT_EQ(verdict["joints"][joint]["angles"], "usable") << joint;
    EXPECT_EQ(verdict["joints"][joint]["torques"], "usable") << joint;
  }
  EXPECT_LE(digest_lines(outcome.out), 12) << outcome.out;
}

// Inputs written for faults of which nothing was said; see their expected.md.
class VerdictOfCase : public ::testing::Test {
 protected:
  void SetUp() override {
    std::error_code error;
    cases_ = fs::absolute("../shared/cases");
    if (!fs::is_directory(cases_, error)) GTEST_SKIP() << "needs the cases in ../shared/cases";
  }
  Outcome sinew(Arguments arguments) const { return run_sinew(folder_.path(), arguments); }
  std::string file(const std::string& name) const { return (cases_ / name).string(); }

  TemporaryFolder folder_;
  fs::path cases_;
};

TEST_F(VerdictOfCase, CoordinatesNothingMeasures) {
  const std::string folder = "coordinates-nothing-measures/";
  const Outcome outcome = sinew({"ik", "--model", file(folder + "toy.osim"), "--markers",
                                 file(folder + "pel.trc"), "--out", "q.mot"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.out;
  const Json verdict = json_of(folder_.path() / "q_verdict.json");
  EXPECT_EQ(verdict["verdict"], "remarks");
  std::map<std::string, int> uses;
  for (const auto& [joint, use] : verdict["joints"].items()) {
    const bool leg = joint.find("hip") != joint.npos || joint.find("knee") != joint.npos ||
                     joint.find("ankle") != joint.npos;
    EXPECT_EQ(use["angles"], leg ? "unusable" : "usable") << joint;
    ++uses[use["angles"]];
  }
  EXPECT_EQ(uses["unusable"], 6);
}

TEST_F(VerdictOfCase, FitOfAMetre) {
  const std::string folder = "fit-of-a-metre-without-a-word/";
  const Outcome outcome = sinew({"ik", "--model", file(folder + "gm.osim"), "--markers",
                                 file(folder + "walk.trc"), "--out", "q.mot"});
  EXPECT_EQ(outcome.exit_code, 1);
  const Json verdict = json_of(folder_.path() / "q_verdict.json");
  EXPECT_EQ(verdict["verdict"], "unusable");
  EXPECT_NEAR(figure_of(verdict, "marker-rms"), 1097.8, 0.05);
}

TEST_F(VerdictOfCase, LoadsOfATable) {
  const std::string folder = "loads-of-a-table-unchecked/";
  const std::map<std::string, std::string> expected = {
      {"ok", ""}, {"mm", "residual-moment"}, {"neg", "loads-pull-down"}, {"zup", "loads-sideways"}};
  for (const auto& [name, code] : expected) {
    const Outcome outcome =
        sinew({"run", "--model", file(folder + "toy.osim"), "--markers", file(folder + "walk.trc"),
               "--loads", file(folder + "g_" + name + ".xml"), "--out", name});
    const Json verdict = json_of(folder_.path() / name / "verdict.json");
    EXPECT_EQ(outcome.exit_code, code.empty() ? 0 : 1) << name << verdict["reasons"].dump(2);
    EXPECT_TRUE(code.empty() || codes_of(verdict).contains(code)) << name;
  }
}

// Published trials are judged as what they are: usable, with the limits that they exceed named.
class VerdictOfPublished : public ::testing::Test {
 protected:
  void SetUp() override {
    shared_ = shared_data();
    if (shared_.empty()) GTEST_SKIP() << "needs the published recordings in ../shared/data";
  }
  std::string file(const std::string& name) const { return (shared_ / name).string(); }

  TemporaryFolder folder_;
  fs::path shared_;
};

TEST_F(VerdictOfPublished, Gait2354) {
  const std::string folder = "opensim-models/Gait2354_Simbody/";
  const Outcome outcome =
      run_sinew(folder_.path(), {"run", "--model", file(folder + "subject01_simbody.osim"),
                                 "--markers", file(folder + "subject01_walk1.trc"), "--tasks",
                                 file(folder + "subject01_Setup_IK.xml"), "--loads",
                                 file(folder + "subject01_walk1_grf.xml"), "--out", "r"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.out;
  EXPECT_LE(digest_lines(outcome.out), 12) << outcome.out;
  EXPECT_EQ(outcome.err.find(shared_.string()), std::string::npos) << outcome.err;
  const Json summary = json_of(folder_.path() / "r/summary.json");
  const Json verdict = json_of(folder_.path() / "r/verdict.json");
  EXPECT_EQ(verdict["verdict"], "remarks");
  EXPECT_NEAR(figure_of(verdict, "marker-rms"),
              1e3 * summary["inverse_kinematics"]["marker_rms_m"].get<double>(), 1e-9);
  // The vector's RMS from the columns' own, over the same frames.
  double force = 0.0, moment = 0.0;
  for (const Json& r : summary["inverse_dynamics"]["root_residuals"]) {
    (r["unit"] == "N" ? force : moment) += std::pow(r["rms"].get<double>(), 2);
  }
  const Json root = summary["inverse_dynamics"]["root"];
  EXPECT_EQ(root["frames"], summary["inverse_dynamics"]["frames"]);
  EXPECT_NEAR(root["force_rms_n"].get<double>(), std::sqrt(force), 1e-9);
  EXPECT_NEAR(root["moment_rms_nm"].get<double>(), std::sqrt(moment), 1e-9);
  EXPECT_NEAR(figure_of(verdict, "residual-moment"), 100.0 * root["moment_share"].get<double>(),
              1e-9);
  EXPECT_NE(outcome.out.find(fmt::format("{:.3g} N m RMS", std::sqrt(moment))), std::string::npos)
      << outcome.out;
}

TEST_F(VerdictOfPublished, SetupsOfGait2354AndGait10dof) {
  for (const char* folder : {"opensim-models/Gait2354_Simbody", "opensim-models/Gait10dof18musc"}) {
    const fs::path to = folder_.path() / fs::path(folder).filename();
    fs::copy(shared_ / folder, to, fs::copy_options::recursive);
    for (const auto& entry : fs::recursive_directory_iterator(to)) {
      fs::permissions(entry.path(), fs::perms::owner_write, fs::perm_options::add);
    }
  }
  const std::vector<std::pair<Arguments, std::string>> commands = {
      {{"scale", "--setup", "Gait2354_Simbody/subject01_Setup_Scale.xml", "--out-dir", "s"},
       "s/subject01_simbody_verdict.json"},
      {{"ik", "--setup", "Gait2354_Simbody/subject01_Setup_IK.xml"},
       "Gait2354_Simbody/subject01_walk1_ik_verdict.json"},
      {{"id", "--setup", "Gait2354_Simbody/subject01_Setup_InverseDynamics.xml"},
       "Gait2354_Simbody/ResultsInverseDynamics/inverse_dynamics_verdict.json"},
      {{"ik", "--setup", "Gait10dof18musc/IK/walk_Setup_IK.xml"},
       "Gait10dof18musc/IK/subject01_walk_IK_verdict.json"},
      {{"id", "--setup", "Gait10dof18musc/ID/walk_Setup_ID.xml"},
       "Gait10dof18musc/ID/Results/subject01_walk_ID_verdict.json"}};
  for (const auto& [command, verdict] : commands) {
    const Outcome outcome = run_sinew(folder_.path(), command);
    EXPECT_EQ(outcome.exit_code, 0) << verdict << outcome.out << outcome.err;
    // The planar model's inverse dynamics keeps all limits; all others exceed one of Hicks'.
    const bool planar = verdict.ends_with("walk_ID_verdict.json");
    EXPECT_EQ(json_of(folder_.path() / verdict)["verdict"], planar ? "good" : "remarks") << verdict;
  }
}

}  // namespace
}  // namespace sinew
