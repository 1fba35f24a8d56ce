#include <gtest/gtest.h>

#include <chrono>
#include <nlohmann/json.hpp>

#include "data/trc_file.h"
#include "tests/pipeline/command_line.h"
#include "tests/pipeline/small_trial.h"

namespace sinew {
namespace {

namespace fs = std::filesystem;

class Check : public ::testing::Test {
 protected:
  Check() { SmallTrial::write(folder_); }

  Outcome check(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), "check");
    return run_sinew(folder_.path(), arguments);
  }
  nlohmann::json findings(std::vector<std::string> arguments) const {
    arguments.insert(arguments.end(), {"--json", "found.json"});
    const Outcome outcome = check(arguments);
    EXPECT_NE(outcome.exit_code, 2) << outcome.err;
    return nlohmann::json::parse(content_of(folder_.path() / "found.json"));
  }

  const TemporaryFolder folder_;
};

TEST_F(Check, ReadsEveryKindOfFileAndExitsWithOneOnErrors) {
  const Outcome fine =
      check({"walk.trc", "grf.mot", "model.osim", "grf.xml", "tasks.xml", "--json", "found.json"});
  EXPECT_EQ(fine.exit_code, 0) << fine.out << fine.err;
  for (const char* line :
       {"walk.trc: 6 markers, 151 frames at 100 Hz", "grf.mot: 9 columns, 301 rows",
        "model.osim: a model", "grf.xml: a setup"}) {
    EXPECT_NE(fine.out.find(line), std::string::npos) << fine.out;
  }
  const nlohmann::json document = nlohmann::json::parse(content_of(folder_.path() / "found.json"));
  EXPECT_EQ(document["errors"], 0);
  EXPECT_EQ(document["files"].size(), 5u);
  ASSERT_EQ(document["gaps"].size(), 1u);
  EXPECT_EQ(document["gaps"][0]["frames"], 5);

  MarkerTrajectories dwarf = SmallTrial::recording();
  dwarf.p_WM *= 1e-3;
  write_trc(folder_.path() / "dwarf.trc", dwarf);
  const Outcome outcome = check({"dwarf.trc"});
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_NE(outcome.out.find("error    unit"), std::string::npos) << outcome.out;
  EXPECT_NE(outcome.out.find("sinew convert dwarf.trc --unit m"), std::string::npos) << outcome.out;
  EXPECT_NE(outcome.out.find("1 errors"), std::string::npos) << outcome.out;
}

TEST_F(Check, WhatCannotBeReadIsAFindingOfItsFile) {
  folder_.write("torn.trc", "PathFileType\t4\n");
  folder_.write("empty.c3d", "");
  folder_.write("other.xml", "<Whatever/>");
  folder_.write("broken.xml", "<IKTaskSet>");
  const nlohmann::json document =
      findings({"torn.trc", "empty.c3d", "other.xml", "broken.xml", "walk.trc"});
  EXPECT_EQ(document["errors"], 4);
  for (const auto& finding : document["findings"]) {
    if (finding["severity"] != "error") continue;
    EXPECT_EQ(finding["kind"], "reading");
    EXPECT_NE(finding["file"], "walk.trc");
    EXPECT_EQ(finding["confidence"], 1.0);
  }
}

TEST_F(Check, SetupsNameWhatIsNotThere) {
  const std::string tasks = SmallTrial::tasks();
  folder_.write("ik.xml",
                "<OpenSimDocument Version=\"40000\"><InverseKinematicsTool>"
                "<model_file>model.osim</model_file><marker_file>run.trc</marker_file>" +
                    tasks + "</InverseKinematicsTool></OpenSimDocument>");
  const nlohmann::json document = findings({"ik.xml"});
  ASSERT_EQ(document["errors"], 1) << document.dump(1);
  EXPECT_EQ(document["findings"][0]["kind"], "setup");
  EXPECT_NE(document["findings"][0]["text"].get<std::string>().find("run.trc, which is not there"),
            std::string::npos);
}

TEST_F(Check, RefusesWrongUsage) {
  const auto refused = [&](const std::vector<std::string>& arguments, const std::string& message) {
    const Outcome outcome = check(arguments);
    EXPECT_EQ(outcome.exit_code, 2);
    EXPECT_EQ(error_line(outcome, folder_.path()), message);
  };
  refused({}, "files is required");
  refused({"nothing.trc"}, "nothing.trc: there is no such file. Check the path.");
  refused({"walk.trc", "--model", "nothing.osim"},
          "nothing.osim: there is no such file. Check --model.");
  folder_.write("notes.txt", "");
  EXPECT_EQ(check({"notes.txt"}).exit_code, 2);
  refused({"walk.trc", "--threshold", "-1"}, "--threshold: -1 is not a number, 0 or more");
  EXPECT_EQ(check({"walk.trc", "--json", "walk.trc"}).exit_code, 2);
}

TEST_F(Check, EditsThatDoNotFitAreRefusedAndWriteNothing) {
  const auto refused = [&](const std::string& input, const std::vector<std::string>& options,
                           const std::string& message) {
    std::vector<std::string> arguments = {"convert", input, "--out", "out.trc"};
    if (input.ends_with(".mot")) arguments.back() = "out.mot";
    arguments.insert(arguments.end(), options.begin(), options.end());
    const auto before = tree_of(folder_.path());
    const Outcome outcome = run_sinew(folder_.path(), arguments);
    EXPECT_EQ(outcome.exit_code, 2) << message;
    EXPECT_EQ(error_line(outcome, folder_.path()), message);
    EXPECT_EQ(tree_of(folder_.path()), before);
  };
  refused("walk.trc", {"--swap", "T1"}, "--swap: T1 is not A,B or A,B@FROM-TO with FROM before TO");
  refused("walk.trc", {"--drop", "T1@2-1"},
          "--drop: T1@2-1 is not NAME or NAME@FROM-TO with FROM before TO");
  refused("walk.trc", {"--rename", "T1"}, "--rename: T1 is not OLD=NEW");
  refused("walk.trc", {"--zero-plates", "1"},
          "--zero-plates: 1 is not FROM-TO or PLATE@FROM-TO, in seconds");
  refused("walk.trc", {"--unit", "km"}, "--unit: km not in {mm,cm,m,in,ft}");
  refused("walk.trc", {"--shift-forces", "nan"}, "--shift-forces: nan is not a time in seconds");
  refused("walk.trc", {"--drop", "T9"}, "--drop names 'T9', which is no marker of the recording");
  refused("walk.trc", {"--swap", "T1,T2@9-10"}, "--swap: no frame lies between 9 s and 10 s");
  refused("walk.trc", {"--shift-forces", "0.1"},
          "--shift-forces does not apply to walk.trc, which holds markers");
  refused("walk.trc", {"--zero-plates", "0-1"},
          "--zero-plates does not apply to walk.trc, which holds no channels of force platforms");
  refused(
      "grf.mot", {"--drop", "T1"},
      "--unit, --swap, --drop, --swap-sides and --rename do not apply to grf.mot, which holds a "
      "table");
  refused("walk.trc", {"--events", "all"},
          "--events goes from one C3D file into another: give FILE.c3d --out NEW.c3d, or --what "
          "events --out NAME.csv");
}

}  // namespace
}  // namespace sinew
