// Recorded markers that the model lacks, and segments without any.

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "data/trc_file.h"
#include "model/osim_file.h"
#include "tests/pipeline/command_line.h"
#include "tests/pipeline/lab_trial.h"

namespace sinew {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;
using Arguments = std::vector<std::string>;

class LabAttach : public WithLabTrial {
 protected:
  static void SetUpTestSuite() {
    WithLabTrial::SetUpTestSuite();
    MarkerTrajectories markers = read_trc(path() / "walk.trc").markers;
    for (std::string& name : markers.names) {
      if (name == "RTHI") name = "Band";
      if (name == "LTIB") name = "Wrap";
    }
    const int count = markers.marker_count();
    markers.names.push_back("Floor");
    markers.names.push_back("*17");
    markers.p_WM.conservativeResize(Eigen::NoChange, 3 * (count + 2));
    for (int f = 0; f < markers.frame_count(); ++f) {
      markers.p_WM.block<1, 3>(f, 3 * count) = Eigen::RowVector3d(1.0, 0.0, 0.3);
      markers.p_WM.block<1, 3>(f, 3 * count + 3) = markers.p_WM.block<1, 3>(f, 0);
    }
    write_trc(path() / "others.trc", markers);
  }
  static Outcome run(const std::string& out, const Arguments& more = {}) {
    Arguments all = {"run",    "--c3d", "others.trc", "--model", "model.osim", "--no-scale",
                     "--from", "0.5",   "--to",       "0.6",     "--out",      out};
    all.insert(all.end(), more.begin(), more.end());
    return run_sinew(path(), all);
  }
  static Json decision(const std::string& file, const std::string& name) {
    const Json decisions = Json::parse(content_of(path() / file));
    for (const Json& d : decisions["decisions"]) {
      if (d["name"] == name) return d;
    }
    return nullptr;
  }
  static Eigen::Vector3d place(const std::string& file, const std::string& marker) {
    const MusculoskeletalModel model = read_osim(path() / file);
    const int m = model.find_marker(marker);
    EXPECT_GE(m, 0) << marker;
    return m < 0 ? Eigen::Vector3d::Zero() : model.markers[static_cast<std::size_t>(m)].p_BM;
  }
};

TEST_F(LabAttach, MarkersOfForeignNamesAreTrackedWhereTheyStay) {
  const Outcome outcome = run("a");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(decision("a/decisions.json", "attach Band")["value"], "femur_r") << outcome.out;
  EXPECT_EQ(decision("a/decisions.json", "attach Wrap")["value"], "tibia_l");
  EXPECT_GT(decision("a/decisions.json", "attach Band")["confidence"].get<double>(), 0.9);
  EXPECT_EQ(decision("a/decisions.json", "attach Floor")["value"], "");
  // What nobody named is no question.
  EXPECT_TRUE(decision("a/decisions.json", "attach *17").is_null());
  // The body that walked has them there under the names that it knows.
  EXPECT_LT((place("a/model.osim", "Band") - place("model.osim", "RTHI")).norm(), 1e-3);
  EXPECT_LT((place("a/model.osim", "Wrap") - place("model.osim", "LTIB")).norm(), 1e-3);
  EXPECT_NE(content_of(path() / "a/ik_tasks.xml").find("\"Band\""), std::string::npos);
  EXPECT_TRUE(fs::exists(path() / "a/attached_markers.xml"));
  // The same again from what was decided.
  const Outcome again =
      run_sinew(path(), {"run", "--decisions", "a/decisions.json", "--out", "again"});
  ASSERT_EQ(again.exit_code, 0) << again.err;
  EXPECT_EQ(content_of(path() / "again/model.osim"), content_of(path() / "a/model.osim"));
  EXPECT_EQ(content_of(path() / "again/ik.mot"), content_of(path() / "a/ik.mot"));
}

TEST_F(LabAttach, OptionsDecideOtherwise) {
  const Outcome none = run("n", {"--no-attach"});
  ASSERT_EQ(none.exit_code, 0) << none.err;
  EXPECT_EQ(decision("n/decisions.json", "attach")["value"], false);
  EXPECT_EQ(read_osim(path() / "n/model.osim").find_marker("Band"), -1);
  const Outcome said = run("s", {"--attach", "*17=pelvis", "--attach", "Band="});
  ASSERT_EQ(said.exit_code, 0) << said.err;
  EXPECT_EQ(decision("s/decisions.json", "attach *17")["value"], "pelvis");
  const MusculoskeletalModel model = read_osim(path() / "s/model.osim");
  EXPECT_EQ(model.find_marker("Band"), -1);
  EXPECT_GE(model.find_marker("*17"), 0);
  EXPECT_GE(model.find_marker("Wrap"), 0);
  const Outcome wrong = run("w", {"--attach", "Bands=femur_r"});
  EXPECT_EQ(wrong.exit_code, 2);
  EXPECT_NE(wrong.err.find("--attach names 'Bands', which is no recorded marker without a name in "
                           "the model; is it Band?"),
            std::string::npos)
      << wrong.err;
  const Outcome twice = run("w", {"--attach", "Band=femur_r", "--attach", "Band=tibia_r"});
  EXPECT_EQ(twice.exit_code, 2);
  EXPECT_NE(twice.err.find("--attach names 'Band' twice, for femur_r and for tibia_r; give one"),
            std::string::npos)
      << twice.err;
  const Outcome alone = run("a", {"--no-attach", "--attach", "Band=femur_r"});
  ASSERT_EQ(alone.exit_code, 0) << alone.err;
  EXPECT_GE(read_osim(path() / "a/model.osim").find_marker("Band"), 0);
  EXPECT_EQ(read_osim(path() / "a/model.osim").find_marker("Wrap"), -1);
  const Outcome body = run("w", {"--attach", "Band=femurr"});
  EXPECT_EQ(body.exit_code, 2);
  EXPECT_NE(body.err.find("has no body 'femurr', which 'Band' is to be attached to; expected "
                          "femur_r. Correct --attach."),
            std::string::npos)
      << body.err;
}

TEST_F(LabAttach, WhatAMapLeavesOutStaysOut) {
  trial_->write("map.csv", "recorded,model\nBand,\n");
  ASSERT_EQ(run("m", {"--map", "map.csv"}).exit_code, 0);
  EXPECT_EQ(decision("m/decisions.json", "attach Band")["value"], "");
  EXPECT_EQ(decision("m/decisions.json", "attach Wrap")["value"], "tibia_l");
  EXPECT_EQ(read_osim(path() / "m/model.osim").find_marker("Band"), -1);
  const Outcome again =
      run_sinew(path(), {"run", "--decisions", "m/decisions.json", "--out", "m2"});
  ASSERT_EQ(again.exit_code, 0) << again.err;
  EXPECT_EQ(content_of(path() / "m2/ik.mot"), content_of(path() / "m/ik.mot"));
}

// All markers of a thigh have names that the model does not know, and the walk has none of the
// knee's: what tells the thigh is a cluster whose place the static trial gives.
TEST_F(LabAttach, AClusterIsCarriedFromTheStaticTrial) {
  const auto rename = [](const char* from, const char* to, bool knee) {
    MarkerTrajectories markers = read_trc(path() / from).markers;
    for (std::string& name : markers.names) {
      if (name == "RTHI") name = "Plate1";
      if (name == "RTH2") name = "Plate2";
      if (name == "RTH3") name = "Plate3";
      if (!knee && (name == "RKNE" || name == "RKNM" || name == "RGTR")) name = "*" + name;
    }
    if (!knee) {
      for (int m = 0; m < markers.marker_count(); ++m) {
        if (markers.names[static_cast<std::size_t>(m)][0] != '*') continue;
        markers.p_WM.middleCols<3>(3 * m).setConstant(std::nan(""));
      }
    }
    write_trc(path() / to, markers);
  };
  rename("static.trc", "cast_static.trc", true);
  rename("walk.trc", "cast_walk.trc", false);
  const Outcome outcome = run_sinew(
      path(), {"run", "--c3d", "cast_walk.trc", "--static", "cast_static.trc", "--model",
               "model.osim", "--no-scale", "--from", "0.5", "--to", "0.6", "--out", "cast"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  for (const auto& [plate, truth] :
       {std::pair{"Plate1", "RTHI"}, std::pair{"Plate2", "RTH2"}, std::pair{"Plate3", "RTH3"}}) {
    EXPECT_EQ(decision("cast/decisions.json", std::string("attach ") + plate)["value"], "femur_r")
        << outcome.out;
    EXPECT_LT((place("cast/model.osim", plate) - place("model.osim", truth)).norm(), 0.005)
        << plate;
  }
}

// ../shared/cases/coordinates-nothing-measures: pelvis and trunk are marked, the legs are not.
TEST(Undetermined, CoordinatesThatNothingMeasuresAreNamedAndMarked) {
  const fs::path shared = fs::absolute("../shared/cases/coordinates-nothing-measures");
  if (!fs::exists(shared)) GTEST_SKIP() << "no ../shared/cases";
  const TemporaryFolder folder;
  const std::string model = (shared / "toy.osim").string();
  const Outcome ik = run_sinew(folder.path(), {"ik", "--model", model, "--markers",
                                               (shared / "pel.trc").string(), "--out", "q.mot"});
  ASSERT_EQ(ik.exit_code, 0) << ik.err;
  EXPECT_NE((ik.out + ik.err).find("have no marker: no measurement tells"), std::string::npos)
      << ik.out << ik.err;
  const TimeTable motion = read_storage(folder.path() / "q.mot").table;
  ASSERT_TRUE(motion.header.contains("undetermined"));
  const std::string names = "," + motion.header.at("undetermined") + ",";
  for (const std::string& label : motion.labels) {
    const bool leg =
        label.starts_with("hip") || label.starts_with("knee") || label.starts_with("ankle");
    EXPECT_EQ(names.find("," + label + ",") != std::string::npos, leg) << label << names;
  }
  const Outcome id = run_sinew(folder.path(), {"id", "--model", model, "--coordinates", "q.mot",
                                               "--cutoff", "-1", "--out", "id.sto"});
  ASSERT_EQ(id.exit_code, 0) << id.err;
  EXPECT_NE(id.err.find("cannot be used"), std::string::npos) << id.err;
  const TimeTable torques = read_storage(folder.path() / "id.sto").table;
  const int column = torques.find_column("knee_angle_r_determined");
  ASSERT_GE(column, 0);
  EXPECT_TRUE((torques.values.col(column).array() == 0.0).all());
  EXPECT_EQ(torques.find_column("pelvis_tilt_determined"), -1);
}

// ../shared/cases/fit-of-a-metre-without-a-word: every marker of the model is on ground.
TEST(Undetermined, AModelWhoseMarkersAllStandIsToldOf) {
  const fs::path shared = fs::absolute("../shared/cases/fit-of-a-metre-without-a-word");
  if (!fs::exists(shared)) GTEST_SKIP() << "no ../shared/cases";
  const TemporaryFolder folder;
  const std::string model = (shared / "gm.osim").string();
  const Outcome check = run_sinew(folder.path(), {"model", "check", model});
  EXPECT_NE(check.exit_code, 0);
  EXPECT_NE((check.out + check.err).find("no marker is on a body that moves"), std::string::npos)
      << check.out;
  const Outcome ik = run_sinew(folder.path(), {"ik", "--model", model, "--markers",
                                               (shared / "walk.trc").string(), "--out", "q.mot"});
  EXPECT_NE((ik.out + ik.err).find("none that is tracked is on a body that moves"),
            std::string::npos)
      << ik.out << ik.err;
}

}  // namespace
}  // namespace sinew
