#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "data/c3d_reader.h"
#include "data/c3d_writer.h"
#include "data/trc_file.h"
#include "tests/pipeline/command_line.h"
#include "tests/pipeline/lab_trial.h"

namespace sinew {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;
using Arguments = std::vector<std::string>;

class LabRun : public WithLabTrial {
 protected:
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
};

// Measured in three frames from the sixtieth on, and in no other.
void hide_but_three(MarkerTrajectories& markers, int marker) {
  for (int f = 0; f < markers.frame_count(); ++f) {
    if (f >= 60 && f < 63) continue;
    markers.p_WM.block<1, 3>(f, 3 * marker).setConstant(std::nan(""));
  }
}

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
  EXPECT_TRUE(holds(outcome.out, "elsewhere the torques of a leg lack them")) << outcome.out;
  // An option of today goes before the file.
  const Outcome said =
      run({"--decisions", "edit/decisions.json", "--marker-cutoff", "-1", "--out", "said"});
  ASSERT_EQ(said.exit_code, 0) << said.err;
  EXPECT_EQ(decision(json("said/decisions.json"), "marker cutoff")["value"], -1.0);
}

// A recording that is wrong in every way an option mends: names exchanged for a while, a stray
// marker, channels with an offset and early.
TEST_F(LabRun, OptionsPutARecordingRight) {
  constexpr double kOffset = 25.0, kEarly = 0.02;  // [N or N m], [s]
  C3dFile file = read_c3d(path() / "walk.c3d");
  const auto marker = [&](const char* name) { return file.markers.find_marker(name); };
  const int knee = marker("RKNE"), other = marker("LKNE"), thigh = marker("RTHI");
  ASSERT_TRUE(knee >= 0 && other >= 0 && thigh >= 0);
  for (int f = 60; f <= 65; ++f) {
    const Eigen::RowVector3d kept = file.markers.p_WM.block<1, 3>(f, 3 * knee);
    file.markers.p_WM.block<1, 3>(f, 3 * knee) = file.markers.p_WM.block<1, 3>(f, 3 * other);
    file.markers.p_WM.block<1, 3>(f, 3 * other) = kept;
  }
  file.markers.p_WM.block<3, 3>(70, 3 * thigh).array() += 0.3;
  const auto early = static_cast<Eigen::Index>(std::lround(kEarly * file.analog.rate));
  const Eigen::Index rows = file.analog.values.rows();
  const RowMatrix channels = file.analog.values;
  file.analog.values.topRows(rows - early) = channels.bottomRows(rows - early);
  file.analog.values.array() += kOffset;
  write_c3d(path() / "spoiled.c3d", file);

  // The step in the middle of the range, of which the platform is free before it.
  const Arguments range = {"--model", "model.osim", "--no-scale", "--from", "0.55", "--to", "0.75"};
  const auto run_range = [&](Arguments arguments) {
    arguments.insert(arguments.end(), range.begin(), range.end());
    return run(arguments);
  };
  ASSERT_EQ(run_range({"--c3d", "walk.c3d", "--out", "right"}).exit_code, 0);
  // Where nothing stands, in the spoiled file's time.
  std::map<int, std::string> unloaded;
  for (int plate = 1; plate <= 6; ++plate) unloaded[plate] = fmt::format("{}@0-2.15", plate);
  for (const auto& row : csv_rows(path() / "right/grf_contacts.csv")) {
    if (row[0] == "platform") continue;
    const double strike = std::stod(row[1]), off = std::stod(row[2]);
    unloaded[std::stoi(row[0])] = strike > 0.3 ? fmt::format("{}@0-{}", row[0], strike - 0.1)
                                               : fmt::format("{}@{}-2.15", row[0], off + 0.1);
  }
  Arguments mended = {"--c3d",  "spoiled.c3d",   "--swap",         "RKNE,LKNE@0.6-0.65",
                      "--drop", "RTHI@0.7-0.72", "--shift-forces", "0.02",
                      "--out",  "mended"};
  for (const auto& [plate, time] : unloaded) {
    mended.push_back("--zero-plates");
    mended.push_back(time);
  }
  const Outcome outcome = run_range(mended);
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_TRUE(holds(outcome.out, "swap: RKNE,LKNE@0.6-0.65 (said by --swap) [--swap]"));
  EXPECT_TRUE(holds(outcome.out, "shift forces: 0.02 (said by --shift-forces) [--shift-forces]"));
  // What was mended is not complained about.
  EXPECT_FALSE(holds(outcome.err, "--swap")) << outcome.err;
  EXPECT_FALSE(holds(outcome.err, "--zero-plates")) << outcome.err;
  const TimeTable torques = read_storage(path() / "mended/id.sto").table;
  const TimeTable expected = read_storage(path() / "right/id.sto").table;
  ASSERT_EQ(torques.labels, expected.labels);
  // Three filled samples shake the thigh with 3 N; the offset left would be 25 N, forces early
  // more.
  EXPECT_LT((torques.values - expected.values).cwiseAbs().maxCoeff(), 4.0);
  const Outcome again = run({"--decisions", "mended/decisions.json", "--out", "mended_again"});
  ASSERT_EQ(again.exit_code, 0) << again.err;
  EXPECT_EQ(content_of(path() / "mended_again/id.sto"), content_of(path() / "mended/id.sto"));

  Json decisions = json("mended/decisions.json");
  for (Json& d : decisions["decisions"]) {
    if (d["name"] == "swap") d["value"] = 7;
  }
  std::ofstream(path() / "mended/decisions.json") << decisions.dump(2);
  const Outcome wrong = run({"--decisions", "mended/decisions.json", "--out", "wrong"});
  EXPECT_EQ(wrong.exit_code, 2);
  EXPECT_EQ(error_line(wrong, path()),
            "mended/decisions.json: the value of decision 'swap' is of the wrong kind; expected a "
            "list of texts, found 7. Correct the value.");
}

TEST_F(LabRun, LateForcesAreRemarkedOn) {
  const Outcome late =
      run_sinew(path(), {"convert", "walk.c3d", "--shift-forces", "0.08", "--out", "late.c3d"});
  ASSERT_EQ(late.exit_code, 0) << late.err;
  run({"--c3d", "late.c3d", "--model", "model.osim", "--no-scale", "--out", "late"});
  const Json verdict = json("late/verdict.json");
  Json found;
  for (const Json& r : verdict["reasons"]) {
    if (r["code"] == "forces-clock") found = r;
  }
  ASSERT_FALSE(found.is_null()) << verdict;
  const std::string remedy = found["remedy"], option = "--shift-forces ";
  ASSERT_TRUE(remedy.starts_with(option)) << remedy;
  EXPECT_NEAR(std::stod(remedy.substr(option.size())), -0.08, 0.015);
}

TEST_F(LabRun, ExchangedNamesAreFoundInTablesToo) {
  MarkerTrajectories markers = read_trc(path() / "walk.trc").markers;
  for (std::string& name : markers.names) {
    name = name == "RKNE" ? "LKNE" : name == "LKNE" ? "RKNE" : name;
  }
  write_trc(path() / "knees.trc", markers);
  const Outcome outcome =
      run_sinew(path(), {"ik", "--model", "model.osim", "--markers", "knees.trc", "--from", "0.5",
                         "--to", "0.6", "--out", "knees.mot"});
  EXPECT_EQ(outcome.exit_code, 1) << outcome.err;
  const Json verdict = json("knees_verdict.json");
  EXPECT_EQ(verdict["reasons"][0]["code"], "exchanged-markers");
  EXPECT_EQ(verdict["reasons"][0]["remedy"],
            "sinew convert knees.trc --swap LKNE,RKNE --out mended.trc");
}

// A turned recording is met as well as any: only where the feet are tells.
TEST_F(LabRun, FeetAboveThePelvisAreRemarkedOn) {
  MarkerTrajectories markers = read_trc(path() / "walk.trc").markers;
  for (int m = 0; m < markers.marker_count(); ++m) {
    markers.p_WM.middleCols(3 * m + 1, 2) *= -1.0;  // half a turn about x
  }
  write_trc(path() / "upside.trc", markers);
  for (const char* name : {"walk", "upside"}) {
    const Outcome outcome =
        run_sinew(path(), {"ik", "--model", "model.osim", "--markers", std::string(name) + ".trc",
                           "--from", "0.5", "--to", "0.6", "--out", std::string(name) + "_q.mot"});
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    const std::string verdict = content_of(path() / (std::string(name) + "_q_verdict.json"));
    EXPECT_EQ(holds(verdict, "not-upright"), name == std::string("upside")) << verdict;
  }
}

// Names exchanged all the time, which a fit hides, and for longer than a spike.
TEST_F(LabRun, ExchangedNamesAreReasonsOfTheVerdict) {
  MarkerTrajectories markers = read_trc(path() / "walk.trc").markers, moment = markers;
  const int right = markers.find_marker("RKNE"), left = markers.find_marker("LKNE");
  ASSERT_TRUE(right >= 0 && left >= 0);
  std::swap(markers.names[static_cast<std::size_t>(right)],
            markers.names[static_cast<std::size_t>(left)]);
  write_trc(path() / "exchanged.trc", markers);
  for (int f = 60; f <= 85; ++f) {
    const Eigen::RowVector3d kept = moment.p_WM.block<1, 3>(f, 3 * right);
    moment.p_WM.block<1, 3>(f, 3 * right) = moment.p_WM.block<1, 3>(f, 3 * left);
    moment.p_WM.block<1, 3>(f, 3 * left) = kept;
  }
  write_trc(path() / "moment.trc", moment);
  const auto reason = [&](const Arguments& more, const std::string& out, int exit_code) -> Json {
    Arguments all = {"--model", "model.osim", "--no-scale", "--from", "0.5",
                     "--to",    "0.8",        "--out",      out};
    all.insert(all.end(), more.begin(), more.end());
    const Outcome outcome = run(all);
    EXPECT_EQ(outcome.exit_code, exit_code) << outcome.err;
    const Json verdict = json(out + "/verdict.json");
    for (const Json& r : verdict["reasons"]) {
      if (r["code"] == "exchanged-markers") return r;
    }
    return nullptr;
  };
  const Json all = reason({"--c3d", "exchanged.trc"}, "exchanged", 1);
  ASSERT_FALSE(all.is_null());
  EXPECT_EQ(all["weight"], "unusable");
  EXPECT_EQ(all["remedy"], "--swap LKNE,RKNE");
  EXPECT_TRUE(reason({"--c3d", "exchanged.trc", "--swap", "LKNE,RKNE"}, "back", 0).is_null());
  const Json some = reason({"--c3d", "moment.trc"}, "moment", 1);
  ASSERT_FALSE(some.is_null());
  EXPECT_EQ(some["weight"], "unusable");
  EXPECT_EQ(some["remedy"], "--swap RKNE,LKNE@0.6-0.85");
}

// The walk's body has 75 kg; that of another height, taken as it is, has 60.
TEST_F(LabRun, PlatformsContradictAModelOfAnotherMass) {
  const Arguments short_walk = {"--c3d", "walk.c3d", "--from", "0.6", "--to", "0.65"};
  const auto carried = [&](const char* model, const char* out) -> Json {
    Arguments arguments = short_walk;
    arguments.insert(arguments.end(), {"--model", model, "--no-scale", "--out", out});
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    const Json verdict = json(std::string(out) + "/verdict.json");
    for (const Json& reason : verdict["reasons"]) {
      if (reason["code"] == "mass-carried") return reason;
    }
    return nullptr;
  };
  const Json other = carried("other.osim", "light");
  ASSERT_FALSE(other.is_null());
  const std::string text = other["text"], before = "the ground carries ";
  ASSERT_TRUE(text.starts_with(before)) << text;
  EXPECT_NEAR(std::stod(text.substr(before.size())), 75.0, 0.75);
  EXPECT_TRUE(text.ends_with(" kg, the model has 60.0 kg")) << text;
  EXPECT_NEAR(other["figure"].get<double>(), 20.0, 0.8);  // 15 kg of 75
  EXPECT_TRUE(other["remedy"].get<std::string>().starts_with("--mass 75.")) << other;
  EXPECT_TRUE(carried("model.osim", "true_mass").is_null());
}

// Two people in one trial, of whom one wears fewer markers.
TEST_F(LabRun, OneOfSeveralSubjectsIsTaken) {
  MarkerTrajectories anna = read_trc(path() / "walk.trc").markers, both = anna;
  for (std::string& name : both.names) name = "Anna:" + name;
  for (int m = 0; m < anna.marker_count(); ++m) {
    const std::string& name = anna.names[static_cast<std::size_t>(m)];
    if (name == "C7" || name == "CLAV") continue;
    both.names.push_back("Bert:" + name);
    both.p_WM.conservativeResize(Eigen::NoChange, both.p_WM.cols() + 3);
    both.p_WM.rightCols<3>() = anna.p_WM.middleCols<3>(3 * m);
    both.p_WM.rightCols<1>().array() += 1.0;  // a metre to the right
  }
  write_trc(path() / "both.trc", both);
  const auto pelvis_tz = [&](const Arguments& more, const char* out, const std::string& subject) {
    Arguments arguments = {"--c3d", "both.trc", "--model", "model.osim", "--no-scale", "--from",
                           "0.5",   "--to",     "0.55",    "--out",      out};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_EQ(decision(json(std::string(out) + "/decisions.json"), "subject")["value"], subject);
    const TimeTable motion = read_storage(path() / out / "ik.mot").table;
    return motion.values(0, motion.find_column("pelvis_tz"));
  };
  const double first = pelvis_tz({}, "anna", "Anna");
  const double second = pelvis_tz({"--subject", "Bert"}, "bert", "Bert");
  EXPECT_NEAR(second - first, 1.0, 1e-3);
}

// Against the times that the walk was made with, which are also the file's events. Forces rise and
// fall smoothly, so that the threshold is crossed 2 % of a stride late and early; Zeni et al.
// (2008) find markers and forces one or two frames of 60 Hz apart.
TEST_F(LabRun, EachSourceFindsTheFeetsEvents) {
  ASSERT_EQ(
      run_sinew(path(), {"convert", "walk.c3d", "--what", "events", "--out", "e.csv"}).exit_code,
      0);
  int by_forces = 0, by_markers = 0;
  const auto rows = csv_rows(path() / "e.csv");
  ASSERT_EQ(rows.size(), 10u);
  for (const auto& row : rows) {
    if (row[0] == "time") continue;
    ASSERT_EQ(row.size(), 8u);
    const double truth = std::stod(row[6]);
    // Strikes every half stride of 1.1 s, the feet leave after 62 % of it.
    const double phase = row[3] == "toe off" ? 0.62 * 1.1 : 0.0;
    EXPECT_NEAR(std::remainder(truth - phase, 0.55), 0.0, 1e-6) << row[0];
    for (const std::string& source : {row[5], row[7]}) {
      if (source.empty()) continue;
      EXPECT_NEAR(std::stod(source), truth, 0.022) << row[0];
    }
    by_forces += row[5].empty() ? 0 : 1;
    by_markers += row[7].empty() ? 0 : 1;
  }
  EXPECT_EQ(by_forces, 8);   // not the strike with which the record ends
  EXPECT_EQ(by_markers, 7);  // nor that with which it begins
}

// What check proposes for a model of another size is a command that works.
TEST_F(LabRun, ModelsOfAnotherSizeAreScaledAsCheckSays) {
  const Outcome check =
      run_sinew(path(), {"check", "walk.trc", "--model", "other.osim", "--json", "findings.json"});
  const Json document = json("findings.json");
  Arguments command;
  for (const Json& finding : document["findings"]) {
    if (finding["kind"] == "size") command = finding["flags"].get<Arguments>();
  }
  EXPECT_EQ(command, (Arguments{"--auto", "--model", "other.osim", "--markers", "walk.trc", "--out",
                                "scaled.osim"}));
  EXPECT_TRUE(holds(check.out,
                    "sinew scale --auto --model other.osim --markers walk.trc --out "
                    "scaled.osim\n"))
      << check.out;
  command.insert(command.begin(), "scale");
  command.insert(command.end(), {"--frames", "4", "--uniform"});  // for time
  const Outcome scaled = run_sinew(path(), command);
  ASSERT_EQ(scaled.exit_code, 0) << scaled.err;
  run_sinew(path(), {"check", "walk.trc", "--model", "scaled.osim", "--json", "after.json"});
  const Json after = json("after.json");
  for (const Json& finding : after["findings"]) EXPECT_NE(finding["kind"], "size");
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
                    "1 recorded markers have no name that the model knows: "
                    "Anna:C7"))
      << outcome.err;
  EXPECT_TRUE(holds(outcome.err,
                    "has no force platform that can be used: torques lack whatever "
                    "the ground does"));
  // Markers are spoken of as the user knows them.
  hide_but_three(markers, markers.find_marker("Anna:Shoe tip"));
  write_trc(path() / "hidden.trc", markers);
  const Outcome hidden = run({"--c3d", "hidden.trc", "--model", "model.osim", "--no-scale", "--map",
                              "map.csv", "--from", "0.5", "--to", "0.8", "--out", "h"});
  EXPECT_TRUE(holds(content_of(path() / "h/verdict.json"), "Shoe tip (the model's RTOE) (3 of 31"))
      << content_of(path() / "h/verdict.json");
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
            "--mass belongs to a laboratory's trial: give it with --c3d FILE.c3d, or leave it out");
  EXPECT_EQ(error({"--model", "model.osim", "--markers", "walk.trc", "--swap", "A,B", "--up", "z"}),
            "--swap, --up belong to a laboratory's trial: give it with --c3d FILE.c3d, or leave "
            "them out");
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
  EXPECT_EQ(error({"--c3d", "walk.c3d", "--model", "model.osim", "--no-scale", "--assign",
                   "1:right", "--assign", "1:left"}),
            "--assign 1:left contradicts another one, which says right for the same time: give one "
            "of them");
  EXPECT_EQ(
      error({"--c3d", "grf.mot", "--model", "model.osim", "--no-scale"}),
      "grf.mot: is no recording of markers; expected a .c3d or .trc file, found .mot. Convert "
      "it with `sinew convert`.");
  EXPECT_EQ(error({"--c3d", "walk.c3d", "--model", "model.osim", "--no-scale", "--subject", "Eva"}),
            "walk.c3d: has no subject 'Eva'; expected names of markers that begin with their "
            "subject's and a colon, found RASI. Leave --subject out.");
  EXPECT_EQ(error({"--c3d", "walk.c3d", "--model", "model.osim", "--no-scale", "--from", "9"})
                .substr(0, 72),
            "sinew-results/markers.trc: no frame lies in the time range, 9 s to 2.2 s");
  trial_->write(
      "scaling.json",
      R"({"version": 1, "inputs": {}, "options": {}, "decisions": [{"name": "scaling", "value": "sideways", "found": "mass", "by": "option"}]})");
  EXPECT_EQ(error({"--c3d", "walk.c3d", "--model", "model.osim", "--decisions", "scaling.json",
                   "--out", "scaling"}),
            "scaling is 'sideways'; expected both, static, walk, setup, mass or none: correct "
            "--scale or the decision 'scaling'");
  for (const auto& [decision, value, message] :
       {std::tuple{"mass", "\"heavy\"", "is of the wrong kind; expected a number, found \"heavy\""},
        std::tuple{"mass", "-5", "is out of its range; expected a number above 0, found -5"},
        std::tuple{"marker cutoff", "0",
                   "is out of its range; expected a frequency above 0 Hz, or a negative number for "
                   "no filter, found 0"}}) {
    trial_->write("edited.json", fmt::format(R"({{"version": 1, "inputs": {{}}, "options": {{}},
"decisions": [{{"name": "{}", "value": {}, "found": 1, "by": "recording"}}]}})",
                                             decision, value));
    EXPECT_EQ(error({"--c3d", "walk.c3d", "--model", "model.osim", "--no-scale", "--decisions",
                     "edited.json", "--out", "edited"}),
              fmt::format("edited.json: the value of decision '{}' {}. Correct the value.",
                          decision, message));
  }
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
