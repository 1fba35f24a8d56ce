// A laboratory's static trial: what is fitted to it, and what can be wrong with it.

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "data/c3d_reader.h"
#include "data/c3d_writer.h"
#include "data/storage_file.h"
#include "data/trc_file.h"
#include "tests/pipeline/command_line.h"
#include "tests/pipeline/lab_trial.h"

namespace sinew {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;
using Arguments = std::vector<std::string>;

class LabStatic : public WithLabTrial {
 protected:
  // The walk in a generic body of 1.65 m, from 0.5 s to 0.8 s.
  Outcome run(const std::string& walk, const std::string& standing, const std::string& out,
              const Arguments& more = {}) const {
    Arguments all = {"run",    "--c3d", walk,   "--static", standing, "--model", "other.osim",
                     "--from", "0.5",   "--to", "0.8",      "--out",  out};
    all.insert(all.end(), more.begin(), more.end());
    return run_sinew(path(), all);
  }
  // Kinds of the findings of the static trial.
  std::string kinds(const Arguments& files) const {
    Arguments all = {"check"};
    all.insert(all.end(), files.begin(), files.end());
    all.insert(all.end(), {"--json", "found.json"});
    const Outcome outcome = run_sinew(path(), all);
    EXPECT_NE(outcome.exit_code, 2) << outcome.err;
    std::string kinds;
    const Json document = Json::parse(content_of(path() / "found.json"));
    for (const Json& finding : document["findings"]) {
      const std::string kind = finding["kind"];
      for (const char* known : {"static moves", "trials exchanged", "other person", "mass unit"}) {
        if (kind == known) kinds += kind + ";";
      }
    }
    return kinds;
  }

  // Codes of the verdict's reasons that are about calibration.
  std::string codes(const std::string& out) const {
    const Json document = Json::parse(content_of(path() / out / "verdict.json"));
    std::string codes;
    for (const Json& reason : document["reasons"]) {
      const std::string code = reason["code"];
      for (const char* known :
           {"size-limit", "moved-marker", "static-moves", "trials-exchanged", "other-person",
            "mass-unit", "static-rms", "static-pose", "static-marker"}) {
        if (code == known) codes += code + ";";
      }
    }
    return codes;
  }
};

bool holds(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST_F(LabStatic, SizesAreFittedToItAndTheWalk) {
  const Outcome outcome = run("walk.c3d", "static.c3d", "both", {"--mass", "75"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_TRUE(holds(outcome.out,
                    "scaling: both (segments and marker places are fitted to the static trial and "
                    "the walk) [--scale]"))
      << outcome.out;
  EXPECT_TRUE(holds(outcome.out, " mm in the static trial, ")) << outcome.out;
  EXPECT_EQ(codes("both"), "");
  const Json summary = Json::parse(content_of(path() / "both/summary.json"));
  EXPECT_LT(summary["inverse_kinematics"]["marker_rms_m"].get<double>(), 0.003);
  // Knees as the body that walked.
  const TimeTable ours = read_storage(path() / "both/ik.mot").table,
                  truth = read_storage(path() / "truth_ik.mot").table;
  for (const char* name : {"knee_angle_r", "knee_angle_l"}) {
    const auto at = [&](const TimeTable& table, double time) {
      Eigen::Index row = 0;
      (table.time.array() - time).abs().minCoeff(&row);
      return table.values(row, table.find_column(name));
    };
    EXPECT_NEAR(at(ours, 0.8) - at(ours, 0.5), at(truth, 0.8) - at(truth, 0.5), 2.0) << name;
  }
}

TEST_F(LabStatic, WhatIsChosenAnywayCanBeSaid) {
  const Outcome outcome =
      run("walk.c3d", "static.c3d", "said", {"--mass", "75", "--scale", "both"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_TRUE(holds(outcome.out, "scaling: both (said by --scale")) << outcome.out;
}

// A static trial whose numbers are of another unit than it says is told by the walk's distances.
TEST_F(LabStatic, UnitFollowsFromTheWalk) {
  const MarkerTrajectories standing = read_trc(path() / "static.trc").markers;
  const auto run_with = [&](double factor, const std::string& name) {
    MarkerTrajectories other = standing;
    other.p_WM *= factor;
    write_trc(path() / (name + ".trc"), other);
    return run("walk.c3d", name + ".trc", name, {"--mass", "75"});
  };
  const auto unit = [&](const std::string& out) {
    const Json decisions = Json::parse(content_of(path() / out / "decisions.json"));
    for (const Json& d : decisions["decisions"]) {
      if (d["name"] == "static unit") return d["value"].get<std::string>();
    }
    return std::string();
  };
  ASSERT_EQ(run("walk.c3d", "static.trc", "as_is", {"--mass", "75"}).exit_code, 0);
  EXPECT_EQ(unit("as_is"), "mm");
  const Outcome inches = run_with(1.0 / 25.4, "inches");
  ASSERT_EQ(inches.exit_code, 0) << inches.out << inches.err;
  EXPECT_EQ(unit("inches"), "in");
  const Outcome centimetres = run_with(0.1, "centimetres");
  ASSERT_EQ(centimetres.exit_code, 0) << centimetres.err;
  EXPECT_EQ(unit("centimetres"), "cm");
  // 10 decimals of a millimetre or of an inch.
  const auto angles = [&](const std::string& out) {
    return read_storage(path() / (out + "/ik.mot")).table.values;
  };
  EXPECT_LT((angles("inches") - angles("as_is")).cwiseAbs().maxCoeff(), 0.05);
  const Outcome half = run_with(0.55, "half");
  EXPECT_EQ(half.exit_code, 2);
  EXPECT_TRUE(
      holds(half.err, "half.trc: is of no unit that the walk would be of: its distances are 0.5"))
      << half.err;
  MarkerTrajectories same = standing;
  same.p_WM.setConstant(0.5);
  write_trc(path() / "point.trc", same);
  const Outcome point = run("walk.c3d", "point.trc", "point", {"--mass", "75"});
  EXPECT_EQ(point.exit_code, 2);
  EXPECT_TRUE(holds(point.err, "is no recording of a person: all markers are in one place"))
      << point.err;
}

// What a message proposes helps.
TEST_F(LabStatic, ALargerSubjectsIsLeftOutByScalingToTheWalk) {
  MarkerTrajectories larger = read_trc(path() / "static.trc").markers;
  larger.p_WM *= 1.15;
  write_trc(path() / "larger.trc", larger);
  const Outcome both = run("walk.c3d", "larger.trc", "larger", {"--mass", "75"});
  EXPECT_EQ(both.exit_code, 1) << both.out;
  EXPECT_TRUE(holds(codes("larger"), "other-person")) << codes("larger");
  EXPECT_TRUE(holds(both.out, "--scale walk")) << both.out;
  const Outcome walk =
      run("walk.c3d", "larger.trc", "larger_walk", {"--mass", "75", "--scale", "walk"});
  EXPECT_EQ(walk.exit_code, 0) << walk.out;
  EXPECT_TRUE(holds(codes("larger_walk"), "other-person")) << codes("larger_walk");
}

TEST_F(LabStatic, AMarkerThatWasPutOnAnewIsNamed) {
  const MarkerTrajectories standing = read_trc(path() / "static.trc").markers;
  const auto run_with_moved = [&](const std::string& name, int axis) {
    MarkerTrajectories moved = standing;
    const int m = moved.find_marker(name);
    EXPECT_GE(m, 0) << fmt::format("{}", fmt::join(moved.names, " "));
    moved.p_WM.col(3 * m + axis).array() += 0.06;
    write_trc(path() / "anew.trc", moved);
    return run("walk.c3d", "anew.trc", "anew", {"--mass", "75"});
  };
  const Outcome hip = run_with_moved("LASI", 1);
  EXPECT_TRUE(holds(codes("anew"), "static-marker;")) << codes("anew");
  EXPECT_TRUE(holds(hip.out, "LASI sat elsewhere among the markers of its segment")) << hip.out;
  // Across a segment of three, whose distances hardly tell.
  const Outcome arm = run_with_moved("RUPA", 0);
  EXPECT_EQ(codes("anew"), "static-marker;");
  EXPECT_TRUE(holds(arm.out, "RUPA sat elsewhere on its segment")) << arm.out;
}

TEST_F(LabStatic, AFilterThatTakesTheMovementIsNotUsable) {
  for (const char* option : {"--cutoff", "--marker-cutoff"}) {
    const Outcome outcome =
        run_sinew(path(), {"run", "--c3d", "walk.c3d", "--static", "static.c3d", "--model",
                           "other.osim", "--mass", "75", option, "0.5", "--out", "flat"});
    EXPECT_EQ(outcome.exit_code, 1) << option << outcome.out;
    EXPECT_TRUE(holds(outcome.out, "takes part of the movement away")) << outcome.out;
  }
}

TEST_F(LabStatic, AMirroredOneIsNotUsable) {
  MarkerTrajectories mirrored = read_trc(path() / "static.trc").markers;
  for (int m = 0; m < mirrored.marker_count(); ++m) mirrored.p_WM.col(3 * m + 2) *= -1.0;
  write_trc(path() / "mirrored.trc", mirrored);
  const Outcome outcome = run("walk.c3d", "mirrored.trc", "mirrored", {"--mass", "75"});
  EXPECT_EQ(outcome.exit_code, 1) << outcome.out << outcome.err;
  EXPECT_TRUE(holds(outcome.out, "in the static trial")) << outcome.out;
}

TEST_F(LabStatic, ExchangedTrialsAreNotUsable) {
  const Outcome outcome = run("static.c3d", "walk.c3d", "exchanged", {"--scale", "none"});
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_TRUE(holds(outcome.out + outcome.err, "the two trials seem exchanged: the subject moves "))
      << outcome.out;
  EXPECT_EQ(codes("exchanged"), "trials-exchanged;");
}

TEST_F(LabStatic, CheckHoldsItAgainstTheWalk) {
  EXPECT_EQ(kinds({"walk.c3d", "--static", "static.c3d"}), "");
  EXPECT_EQ(kinds({"static.c3d", "--static", "walk.c3d"}), "trials exchanged;");
  EXPECT_EQ(kinds({"walk.c3d", "static.c3d"}), "");
  C3dFile other = read_c3d(path() / "static.c3d");
  other.markers.p_WM *= 1.1;
  write_c3d(path() / "other.c3d", other);
  EXPECT_EQ(kinds({"walk.c3d", "--static", "other.c3d"}), "other person;");
}

}  // namespace
}  // namespace sinew
