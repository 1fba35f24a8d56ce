#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "data/trc_file.h"
#include "tests/pipeline/command_line.h"
#include "tests/pipeline/lab_trial.h"

namespace sinew {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;
using Arguments = std::vector<std::string>;

class LabRun : public ::testing::Test {
 protected:
  static void SetUpTestSuite() { trial_ = new LabTrialFiles; }
  static void TearDownTestSuite() {
    delete trial_;
    trial_ = nullptr;
  }

  const fs::path& path() const { return trial_->path(); }

  Outcome run(Arguments arguments) const {
    arguments.insert(arguments.begin(), "run");
    return run_sinew(path(), arguments);
  }
  // The walk with the body that walked, from 0.5 s to 0.8 s, unless something else is said.
  Outcome run_true(const std::string& out, const Arguments& more = {}) const {
    Arguments all = {"--c3d", "walk.c3d", "--model", "model.osim", "--no-scale", "--from",
                     "0.5",   "--to",     "0.8",     "--out",      out};
    all.insert(all.end(), more.begin(), more.end());
    return run(all);
  }
  Json json(const std::string& file) const { return Json::parse(content_of(path() / file)); }

  static Json decision(const Json& decisions, const std::string& name) {
    for (const Json& d : decisions["decisions"]) {
      if (d["name"] == name) return d;
    }
    return nullptr;
  }

  static LabTrialFiles* trial_;
};

LabTrialFiles* LabRun::trial_ = nullptr;

bool holds(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST_F(LabRun, SaysWhatItDecidesAndWritesEverythingInBetween) {
  const Outcome outcome = run_true("r");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  for (const char* line :
       {"up: z (the forces that carry the subject, ", " % sure) [--up]", "forward: y (",
        "scaling: none (said by --scale", "marker cutoff: 6 (walking at ", "[--marker-cutoff]",
        "from: 0.5 (said by --from", "contact 1.1: ", "markers: 70 entries (70 same name) [--map]",
        "force cutoff: 6 ([Hz] as the markers') [--force-cutoff]"}) {
    EXPECT_TRUE(holds(outcome.out, line)) << line << "\n" << outcome.out;
  }
  for (const char* file :
       {"model.osim", "markers.trc", "filled.csv", "grf.mot", "grf.xml", "grf_contacts.csv",
        "load_coverage.csv", "ik_tasks.xml", "ik_setup.xml", "id_setup.xml", "ik.mot", "id.sto",
        "marker_errors.csv", "frame_errors.csv", "summary.json", "decisions.json"}) {
    EXPECT_TRUE(fs::exists(path() / "r" / file)) << file;
  }
  // The model was taken as it is.
  EXPECT_EQ(content_of(path() / "r/model.osim"), content_of(path() / "model.osim"));
  const TimeTable id = read_storage(path() / "r/id.sto").table;
  EXPECT_EQ(id.labels[id.labels.size() - 2], "right_loads_complete");
  EXPECT_EQ(id.labels.back(), "left_loads_complete");
  EXPECT_EQ(id.values.rightCols(2).minCoeff(), 1.0);
  EXPECT_TRUE(holds(outcome.out,
                    "loads of the right foot are known in 31 of 31 frames: 0.50 s to "
                    "0.80 s"));
}

// What was decided, whether found or said, gives the same bytes again.
TEST_F(LabRun, DecisionsRepeatTheRun) {
  const Outcome first = run({"--c3d",      "walk.c3d", "--scale",   "mass",   "--model",
                             "other.osim", "--mass",   "75",        "--from", "0.6",
                             "--to",       "0.7",      "--max-gap", "0.05",   "--no-fill-rigid",
                             "--up",       "z",        "--assign",  "1:none", "--out",
                             "once"});
  ASSERT_EQ(first.exit_code, 0) << first.err;
  const Outcome again =
      run({"--decisions", "once/decisions.json", "--threads", "1", "--out", "again"});
  ASSERT_EQ(again.exit_code, 0) << again.err;
  EXPECT_EQ(tree_of(path() / "once"), tree_of(path() / "again"));
  for (const std::string& file : tree_of(path() / "once")) {
    if (file == "summary.json") continue;  // times
    EXPECT_EQ(content_of(path() / "once" / file), content_of(path() / "again" / file)) << file;
  }
  EXPECT_EQ(first.out.substr(0, first.out.find("inverse kinematics: ")),
            again.out.substr(0, again.out.find("inverse kinematics: ")));
  const Json decisions = json("once/decisions.json");
  EXPECT_EQ(decision(decisions, "contact 1.1")["value"], "none");
  EXPECT_EQ(decision(decisions, "contact 1.1")["by"], "option");
  EXPECT_EQ(decision(decisions, "fill rigid")["value"], false);
  EXPECT_EQ(decision(decisions, "forward")["by"], "recording");
}

TEST_F(LabRun, EditedDecisionsHold) {
  ASSERT_EQ(run_true("edit").exit_code, 0);
  Json decisions = json("edit/decisions.json");
  std::string contact;
  for (Json& d : decisions["decisions"]) {
    if (d["name"] == "marker cutoff") d["value"] = 8.0;
    const std::string name = d["name"];
    if (name.starts_with("contact ") && holds(d["why"], "to 0.")) {
      d["value"] = "none";
      contact = name;
    }
  }
  ASSERT_FALSE(contact.empty());
  std::ofstream(path() / "edit/decisions.json") << decisions.dump(2);
  // Results go beside the edited file.
  const Outcome outcome = run({"--decisions", "edit/decisions.json"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_TRUE(holds(outcome.out, "marker cutoff: 8 (as decisions.json says; ")) << outcome.out;
  // What follows from it follows.
  EXPECT_TRUE(holds(outcome.out, "force cutoff: 8 ([Hz] as the markers')")) << outcome.out;
  const Json after = json("edit/decisions.json");
  EXPECT_EQ(decision(after, contact)["value"], "none");
  EXPECT_EQ(decision(after, contact)["by"], "decisions.json");
  EXPECT_TRUE(holds(outcome.out, "elsewhere torques of that leg")) << outcome.out;
  // An option of today goes before the file.
  const Outcome said =
      run({"--decisions", "edit/decisions.json", "--marker-cutoff", "-1", "--out", "said"});
  ASSERT_EQ(said.exit_code, 0) << said.err;
  EXPECT_EQ(decision(json("said/decisions.json"), "marker cutoff")["value"], -1.0);
}

TEST_F(LabRun, SetupsRepeatTheSteps) {
  ASSERT_EQ(run_true("setups").exit_code, 0);
  Outcome outcome = run_sinew(path(), {"ik", "--setup", "setups/ik_setup.xml", "--filled",
                                       "setups/filled.csv", "--out", "setups/ik_again.mot"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(content_of(path() / "setups/ik_again.mot"), content_of(path() / "setups/ik.mot"));
  outcome =
      run_sinew(path(), {"id", "--setup", "setups/id_setup.xml", "--out", "setups/again.sto"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const TimeTable id = read_storage(path() / "setups/id.sto").table;
  const TimeTable again = read_storage(path() / "setups/again.sto").table;
  ASSERT_EQ(again.values.cols() + 2, id.values.cols());
  // Degrees are printed in between.
  EXPECT_LT((id.values.leftCols(again.values.cols()) - again.values).cwiseAbs().maxCoeff(), 1e-6);
}

// Names as another laboratory has them, a subject before each, and TRC for C3D.
TEST_F(LabRun, ForeignNamesFindTheirMarkers) {
  MarkerTrajectories markers = read_trc(path() / "walk.trc").markers;
  for (std::string& name : markers.names) {
    if (name == "RKNE") name = "R.Knee.Lat";
    if (name == "LHEE") name = "l heel";
    if (name == "RTOE") name = "Shoe tip";
    name = "Anna:" + name;
  }
  write_trc(path() / "foreign.trc", markers);
  std::ofstream(path() / "map.csv") << "recorded,model\nShoe tip,RTOE\nC7,\n";
  const Outcome outcome = run({"--c3d", "foreign.trc", "--model", "model.osim", "--no-scale",
                               "--map", "map.csv", "--from", "0.5", "--to", "0.55", "--out", "f"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const Json decisions = json("f/decisions.json");
  EXPECT_EQ(decision(decisions, "subject")["value"], "Anna");
  const Json map = decision(decisions, "markers")["value"];
  EXPECT_EQ(map["Anna:R.Knee.Lat"], "RKNE");
  EXPECT_EQ(map["Anna:l heel"], "LHEE");
  EXPECT_EQ(map["Anna:Shoe tip"], "RTOE");
  EXPECT_FALSE(map.contains("Anna:C7"));
  EXPECT_TRUE(holds(outcome.err,
                    "1 recorded markers are not the model's and are not tracked: "
                    "Anna:C7"))
      << outcome.err;
  EXPECT_TRUE(holds(outcome.err,
                    "has no force platform that can be used: torques lack whatever "
                    "the ground does"));
}

TEST_F(LabRun, FilledSamplesAreListedAndWeighLess) {
  MarkerTrajectories markers = read_trc(path() / "walk.trc").markers;
  const int knee = markers.find_marker("RKNE");
  markers.p_WM.block(60, 3 * knee, 8, 3).setConstant(std::nan(""));
  write_trc(path() / "gap.trc", markers);
  const Outcome outcome = run({"--c3d", "gap.trc", "--model", "model.osim", "--no-scale", "--from",
                               "0.5", "--to", "0.8", "--out", "gap"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const auto rows = csv_rows(path() / "gap/filled.csv");
  ASSERT_EQ(rows.size(), 2u);
  EXPECT_EQ(rows[1][0], "RKNE");
  EXPECT_EQ(rows[1][5], "8");
  // Filled samples are no measurement that could be met.
  for (const auto& row : csv_rows(path() / "gap/marker_errors.csv")) {
    if (row[0] == "RKNE") {
      EXPECT_EQ(row[2], "23");
    } else if (row[0] == "LKNE") {
      EXPECT_EQ(row[2], "31");
    }
  }
}

TEST_F(LabRun, WrongUsageIsTold) {
  const auto error = [&](const Arguments& arguments) {
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.exit_code, 2) << outcome.out << outcome.err;
    return error_line(outcome, path());
  };
  EXPECT_EQ(error({"--c3d", "walk.c3d"}),
            "no model: give --model FILE.osim, or one of the built-in bodies, whole-body and "
            "whole-body-detailed");
  EXPECT_EQ(error({"--c3d", "walk.c3d", "--markers", "walk.trc", "--model", "model.osim"}),
            "--c3d and --markers are two ways to give the same: leave one of them out");
  EXPECT_EQ(error({"--model", "model.osim", "--markers", "walk.trc", "--mass", "70"}),
            "--static, --mass, --height, --scale, --scale-setup, --no-scale, --map and --assign "
            "belong to a laboratory's trial: give it with --c3d FILE.c3d");
  EXPECT_EQ(error({"--c3d", "walk.c3d", "--model", "model.osim", "--no-scale", "--mass", "70"}),
            "--no-scale takes the model's masses as they are: leave --mass out, or --no-scale");
  EXPECT_EQ(
      error({"--c3d", "walk.c3d", "--model", "model.osim", "--no-scale", "--scale-setup", "s.xml"}),
      "--no-scale and --scale-setup contradict each other: give one");
  EXPECT_EQ(error({"--c3d", "walk.c3d", "--model", "model.osim", "--height", "1.7"}),
            "--height and --sex are for the built-in bodies; 'model.osim' is a file");
  EXPECT_EQ(error({"--c3d", "walk.c3d", "--model", "model.osim", "--scale", "static"}),
            "scaling by the static trial needs --static FILE");
  EXPECT_EQ(
      error({"--c3d", "walk.c3d", "--model", "model.osim", "--no-scale", "--assign", "99:right"})
          .substr(0, 39),
      "--assign names platform 99; the file ha");
  EXPECT_EQ(
      error({"--c3d", "walk.c3d", "--model", "model.osim", "--no-scale", "--assign", "1-right"}),
      "--assign 1-right is not PLATE:FOOT or PLATE:FOOT@FROM-TO, such as 1:right or "
      "2:none@0.5-1.2");
  EXPECT_EQ(
      error({"--c3d", "grf.mot", "--model", "model.osim", "--no-scale"}),
      "grf.mot: is no recording of markers; expected a .c3d or .trc file, found .mot. Convert "
      "it with `sinew convert`.");
  trial_->write("no.json", "{}");
  EXPECT_TRUE(error({"--decisions", "no.json"}).starts_with("no.json: is no file of decisions: "));
  EXPECT_EQ(error({"--c3d", "walk.c3d", "--model", "model.osim", "--filled-weight", "2"}),
            "--filled-weight: Value 2 not in range 0.000000 to 1.000000");
}

TEST_F(LabRun, StrangersNamesAreListedWithTheNearest) {
  MarkerTrajectories markers = read_trc(path() / "walk.trc").markers;
  for (std::size_t i = 0; i < markers.names.size(); ++i) markers.names[i] = "m" + std::to_string(i);
  markers.names[0] = "RASI_";
  markers.names[1] = "RKNEEX";
  write_trc(path() / "strange.trc", markers);
  const Outcome outcome = run({"--c3d", "strange.trc", "--model", "model.osim", "--no-scale"});
  EXPECT_EQ(outcome.exit_code, 2);
  const std::string error = error_line(outcome, path());
  EXPECT_TRUE(holds(error,
                    "only 1 of 70 recorded markers have a name that the model knows; not "
                    "used: RKNEEX (RKNE?), "))
      << error;
  EXPECT_TRUE(holds(error, "Give --map MAP.csv with lines `recorded,model`")) << error;
}

}  // namespace
}  // namespace sinew
