// What gaps and outliers of a laboratory's trial do to the results.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "data/c3d_reader.h"
#include "data/c3d_writer.h"
#include "data/conditioning.h"
#include "data/gap_filling.h"
#include "data/storage_file.h"
#include "data/tool_setup.h"
#include "data/trc_file.h"
#include "dynamics/inverse_dynamics.h"
#include "ik/filled_weights.h"
#include "model/osim_file.h"
#include "pipeline/ik_job.h"
#include "tests/pipeline/command_line.h"
#include "tests/pipeline/lab_trial.h"

namespace sinew {
namespace {

namespace fs = std::filesystem;
using Arguments = std::vector<std::string>;
using Json = nlohmann::json;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

void hide(MarkerTrajectories& markers, int marker, int first, int count) {
  markers.p_WM.block(first, 3 * marker, count, 3).setConstant(kNaN);
}

// ---- BTKData's trial, step by step as `sinew run --c3d` does it, so that hundreds of blanks take
// seconds.
class BlankedFrame : public ::testing::Test {
 protected:
  void SetUp() override {
    const fs::path shared = shared_data();
    if (shared.empty()) GTEST_SKIP() << "no ../shared/data";
    trial_ = shared / "BTKData/PiG_Motion-FlatFoot-Full.c3d";
    arguments_ = {"run",
                  "--c3d",
                  trial_,
                  "--static",
                  shared / "BTKData/PiG_Calibration-FlatFoot-Full.c3d",
                  "--model",
                  shared / "opensim-models/Rajagopal_run/Rajagopal2016.osim",
                  "--cutoff",
                  "-1"};
  }

  Outcome run(const fs::path& c3d, const std::string& out, Arguments more = {}) const {
    Arguments arguments = arguments_;
    arguments[2] = c3d.string();
    arguments.insert(arguments.end(), more.begin(), more.end());
    arguments.insert(arguments.end(), {"--out", out});
    return run_sinew(folder_.path(), arguments);
  }

  // Named, turned, neither filled nor filtered markers, and everything else of the run.
  void prepare() {
    // The verdict is another matter.
    run(trial_, "whole");
    run(trial_, "raw", {"--max-gap", "0", "--no-fill-rigid", "--marker-cutoff", "-1"});
    raw_ = read_trc(folder_.path() / "raw/markers.trc");
    model_ = read_osim(folder_.path() / "whole/model.osim");
    tree_ = compile_tree(model_);
    tasks_ = read_ik_task_set(folder_.path() / "whole/ik_tasks.xml");
    const ExternalLoadsSetup setup = read_external_loads(folder_.path() / "whole/grf.xml");
    loads_.emplace(model_, setup, read_storage(folder_.path() / "whole/grf.mot"));
    compiled_.emplace(model_);
    fill_.max_gap = 0.1;
    fill_.rigid = true;
    std::map<int, std::vector<int>> by_body;
    for (const Marker& marker : model_.markers) {
      const int index = raw_.markers.find_marker(marker.name);
      if (index >= 0) by_body[marker.body].push_back(index);
    }
    for (const auto& [body, indices] : by_body) fill_.segments.push_back(indices);
  }

  TimeTable torques(MarkerTrajectories markers) const {
    const GapFillResult filled = fill_gaps(markers, fill_);
    lowpass(markers, 6.0);
    MarkerFile recording{"markers", markers, {}};
    TrackingProblem tracking = bind_recording(model_, tree_, recording, &tasks_, nullptr);
    std::vector<FilledStretch> stretches;
    const auto add = [&](const MarkerGap& gap, double error) {
      stretches.push_back(
          {markers.names[static_cast<std::size_t>(gap.marker)], gap.first, gap.count, error});
    };
    for (const FilledGap& gap : filled.filled) add(gap.gap, gap.error);
    for (const MarkerGap& gap : filled.left) add(gap, std::numeric_limits<double>::infinity());
    weigh_filled_samples(tracking, markers, stretches);
    TrackingOptions options;
    const TrackingResult solved = track(model_, tree_, tracking, markers, options);
    return inverse_dynamics(model_, *compiled_, coordinate_table(model_, solved), *loads_, {})
        .forces;
  }

  // The largest change of a torque, as a part of its peak.
  static std::pair<double, std::string> worst(const TimeTable& a, const TimeTable& b) {
    std::pair<double, std::string> result{0.0, ""};
    for (Eigen::Index c = 0; c < a.values.cols(); ++c) {
      const double peak = a.values.col(c).cwiseAbs().maxCoeff();
      const double part = (a.values.col(c) - b.values.col(c)).cwiseAbs().maxCoeff() / peak;
      if (peak > 0.0 && part > result.first) {
        result = {part, a.labels[static_cast<std::size_t>(c)]};
      }
    }
    return result;
  }

  const TemporaryFolder folder_;
  fs::path trial_;
  Arguments arguments_;
  MarkerFile raw_;
  MusculoskeletalModel model_;
  KinematicTree tree_;
  IkTaskSet tasks_;
  std::optional<ExternalLoads> loads_;
  std::optional<SimbodyModel> compiled_;
  GapFillOptions fill_;
};

// Filled to microns, a single frame once changed a hip's moment by four times its peak: its weight
// stepped from 1 to 0.1 and back.
TEST_F(BlankedFrame, ChangesNoTorqueByAHundredthOfItsPeak) {
  prepare();
  const TimeTable whole = torques(raw_.markers);
  // What the steps here give is what the command gives.
  const TimeTable written = read_storage(folder_.path() / "whole/id.sto").table;
  for (Eigen::Index c = 0; c < whole.values.cols(); ++c) {
    ASSERT_EQ(written.labels[static_cast<std::size_t>(c)],
              whole.labels[static_cast<std::size_t>(c)]);
    EXPECT_LT((written.values.col(c) - whole.values.col(c)).cwiseAbs().maxCoeff(),
              1e-3 * whole.values.col(c).cwiseAbs().maxCoeff() + 1e-6);
  }
  const int frames = raw_.markers.frame_count();
  int blanks = 0;
  for (int m = 0; m < raw_.markers.marker_count(); ++m) {
    const std::string name = raw_.markers.names[static_cast<std::size_t>(m)];
    if (model_.find_marker(name) < 0) continue;
    // Frames of all phases of a step. Within 0.1 s of the record's ends nothing tells
    // accelerations, and torques hang on the noise of the last samples whether they are measured or
    // filled.
    for (const int start : {31 + 7 * m, 151 + 11 * m}) {
      const int frame = std::clamp(start % frames, 10, frames - 11);
      MarkerTrajectories markers = raw_.markers;
      hide(markers, m, frame, 1);
      const auto [part, column] = worst(whole, torques(markers));
      EXPECT_LE(part, 0.01) << name << " in frame " << frame << ": " << column;
      ++blanks;
    }
  }
  EXPECT_GE(blanks, 2 * 15);
}

// The same through the command, scaling and all.
TEST_F(BlankedFrame, ChangesNoTorqueOfTheCommandEither) {
  run(trial_, "whole");
  const TimeTable whole = read_storage(folder_.path() / "whole/id.sto").table;
  const C3dFile file = read_c3d(trial_);
  for (const auto& [name, frame] : {std::pair{"LKNE", 120}, std::pair{"RTOE", 60},
                                    std::pair{"SACR", 200}, std::pair{"RASI", 171}}) {
    C3dFile blanked = file;
    const int marker = blanked.markers.find_marker(name);
    if (marker < 0) continue;
    hide(blanked.markers, marker, frame, 1);
    write_c3d(folder_.path() / "blank.c3d", blanked);
    run(folder_.path() / "blank.c3d", "blank");
    const auto [part, column] = worst(whole, read_storage(folder_.path() / "blank/id.sto").table);
    EXPECT_LE(part, 0.01) << name << " in frame " << frame << ": " << column;
  }
}

// ---- the embedded walk
class LabGaps : public LabTrialFiles, public ::testing::Test {
 protected:
  Outcome run(const std::string& c3d, const std::string& out, Arguments more = {}) const {
    Arguments arguments = {"run",        "--c3d",      c3d,     "--model",
                           "model.osim", "--no-scale", "--out", out};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_sinew(path(), arguments);
  }
  TimeTable table(const std::string& name) const { return read_storage(path() / name).table; }
  Json json(const std::string& name) const { return Json::parse(content_of(path() / name)); }

  // The reasons of one kind that the verdict gives, their texts put together, and what they are
  // for.
  std::string reasons(const std::string& out, const std::string& code) const {
    std::string text;
    const Json verdict = json(out + "/verdict.json");
    for (const Json& reason : verdict["reasons"]) {
      if (reason["code"] == code) text += reason.dump() + "\n";
    }
    return text;
  }

  static Json decision(const Json& decisions, const std::string& name) {
    for (const Json& decision : decisions["decisions"]) {
      if (decision["name"] == name) return decision;
    }
    return {};
  }
  // The largest change of a torque [N m or N].
  static double change(const TimeTable& a, const TimeTable& b) {
    return (a.values - b.values).cwiseAbs().maxCoeff();
  }
};

bool holds(const std::string& text, const std::string& part) {
  return text.find(part) != text.npos;
}

TEST_F(LabGaps, SpikesOfMarkersAndForcesAreGapsByADecision) {
  const C3dFile clean = read_c3d(path() / "walk.c3d");
  C3dFile spoiled = clean;
  const int knee = spoiled.markers.find_marker("LKNE"), toe = spoiled.markers.find_marker("RTOE");
  spoiled.markers.p_WM(100, 3 * knee) += 10.0;
  spoiled.markers.p_WM(140, 3 * toe + 2) -= 0.3;
  spoiled.analog.values(800, 2) = 1e30;
  spoiled.analog.values(900, 2) = -5000.0;
  write_c3d(path() / "spoiled.c3d", spoiled);
  ASSERT_EQ(run("walk.c3d", "clean").exit_code, 0);
  const Outcome outcome = run("spoiled.c3d", "mended");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const Json decisions = json("mended/decisions.json");
  EXPECT_EQ(decision(decisions, "spikes")["value"], (Json{"RTOE@1.4-1.4", "LKNE@1-1"}));
  EXPECT_EQ(decision(decisions, "spikes")["option"], "--spikes");
  EXPECT_EQ(decision(decisions, "force spikes")["value"].size(), 2u);
  EXPECT_TRUE(holds(outcome.out, "spikes: RTOE@1.4-1.4, LKNE@1-1")) << outcome.out;
  const TimeTable whole = table("clean/id.sto"), mended = table("mended/id.sto");
  for (Eigen::Index c = 0; c < whole.values.cols(); ++c) {
    const double peak = whole.values.col(c).cwiseAbs().maxCoeff();
    EXPECT_LE((whole.values.col(c) - mended.values.col(c)).cwiseAbs().maxCoeff(),
              0.01 * peak + 0.05)
        << whole.labels[static_cast<std::size_t>(c)];
  }
  // It repeats, byte for byte, and can be decided otherwise.
  ASSERT_EQ(run_sinew(path(), {"run", "--decisions", "mended/decisions.json", "--out", "again"})
                .exit_code,
            0);
  EXPECT_EQ(content_of(path() / "again/id.sto"), content_of(path() / "mended/id.sto"));
  run("spoiled.c3d", "kept", {"--spikes", "none", "--force-spikes", "none"});
  EXPECT_EQ(decision(json("kept/decisions.json"), "spikes")["value"], "none");
  EXPECT_GT(change(whole, table("kept/id.sto")), 1e3);
  // `check` finds the same, and `convert` mends it as it says.
  const Outcome check = run_sinew(path(), {"check", "spoiled.c3d", "--json", "found.json"});
  std::vector<std::string> flags;
  const Json found = json("found.json");
  for (const Json& finding : found["findings"]) {
    if (finding["kind"] != "spike") continue;
    for (const Json& flag : finding["flags"]) flags.push_back(flag);
  }
  EXPECT_EQ(flags.size(), 8u) << check.out;
  Arguments convert = {"convert", "spoiled.c3d", "--out", "mended.c3d"};
  convert.insert(convert.end(), flags.begin(), flags.end());
  ASSERT_EQ(run_sinew(path(), convert).exit_code, 0);
  run_sinew(path(), {"check", "mended.c3d", "--json", "left.json"});
  const Json left = json("left.json");
  for (const Json& finding : left["findings"]) EXPECT_NE(finding["kind"], "spike");
}

// Setups as OpenSim has them, without a laboratory's decisions.
TEST_F(LabGaps, SpikesAreLeftOutOfTablesToo) {
  MarkerTrajectories markers = read_trc(path() / "walk.trc").markers;
  TimeTable forces = table("grf.mot");
  markers.p_WM(100, 3 * markers.find_marker("LKNE")) += 10.0;
  forces.values(700, 1) = 1e30;
  write_trc(path() / "spoiled.trc", markers);
  write_storage(path() / "spoiled.mot", forces);
  const Arguments arguments = {"run",          "--model", "model.osim", "--tasks",
                               "ik_tasks.xml", "--loads", "grf.xml",    "--markers"};
  const auto run_tables = [&](const std::string& trc, const std::string& mot,
                              const std::string& out) {
    Arguments all = arguments;
    all.insert(all.end(), {trc, "--load-data", mot, "--out", out});
    return run_sinew(path(), all);
  };
  ASSERT_EQ(run_tables("walk.trc", "grf.mot", "a").exit_code, 0);
  const Outcome outcome = run_tables("spoiled.trc", "spoiled.mot", "b");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_TRUE(holds(outcome.err, "LKNE@1-1; --spikes none keeps them")) << outcome.err;
  EXPECT_TRUE(holds(outcome.err, "samples that no force makes are left out: "));
  EXPECT_LT(change(table("a/id.sto"), table("b/id.sto")), 1.0);
}

TEST_F(LabGaps, NothingIsInventedWhereNothingIsSeen) {
  const C3dFile clean = read_c3d(path() / "walk.c3d");
  ASSERT_EQ(run("walk.c3d", "clean").exit_code, 0);
  const TimeTable truth = table("clean/ik.mot");
  // All at once, for a fifth of a second.
  C3dFile blind = clean;
  blind.markers.p_WM.middleRows(100, 20).setConstant(kNaN);
  write_c3d(path() / "blind.c3d", blind);
  const Outcome outcome = run("blind.c3d", "blind");
  ASSERT_TRUE(fs::exists(path() / "blind/verdict.json")) << outcome.err;
  EXPECT_NE(json("blind/verdict.json")["verdict"], "good");
  EXPECT_TRUE(holds(reasons("blind", "gap"),
                    "too few markers are seen to tell the pose, and none at all in a part: "))
      << reasons("blind", "gap");
  // The filters carry what is filled in 0.5 s / 6 beyond it.
  EXPECT_TRUE(holds(reasons("blind", "gap"), "angles and torques of 0.91 s to 1.28 s"))
      << reasons("blind", "gap");
  EXPECT_FALSE(holds(outcome.err, "forces come")) << outcome.err;
  const TimeTable torques = table("blind/id.sto");
  const int told = torques.find_column("knee_angle_r_determined");
  ASSERT_GE(told, 0);
  for (Eigen::Index f = 0; f < torques.values.rows(); ++f) {
    EXPECT_EQ(torques.values(f, told), f >= 91 && f <= 128 ? 0.0 : 1.0) << f;
  }
  const TimeTable motion = table("blind/ik.mot");
  for (Eigen::Index c = 0; c < truth.values.cols(); ++c) {
    // Vertebrae and fingers hang on their posture's tasks all along, which pull there alone.
    const std::string& name = truth.labels[static_cast<std::size_t>(c)];
    if (!name.starts_with("pelvis_") && !name.starts_with("hip_") && !name.starts_with("knee_")) {
      continue;
    }
    const auto column = motion.values.col(c);
    const double low = std::min(column[99], column[120]), high = std::max(column[99], column[120]);
    for (Eigen::Index f = 100; f < 120; ++f) {
      // Between what is known before and behind, and nowhere else.
      EXPECT_GE(column[f], low - 1e-3) << truth.labels[static_cast<std::size_t>(c)];
      EXPECT_LE(column[f], high + 1e-3) << truth.labels[static_cast<std::size_t>(c)];
    }
  }
  // Elsewhere it is the same walk.
  EXPECT_LT((motion.values.topRows(90) - truth.values.topRows(90)).cwiseAbs().maxCoeff(), 0.5);
}

TEST_F(LabGaps, AFootOutOfSightIsNamed) {
  C3dFile file = read_c3d(path() / "walk.c3d");
  int hidden = 0;
  for (int m = 0; m < file.markers.marker_count(); ++m) {
    const std::string& name = file.markers.names[static_cast<std::size_t>(m)];
    for (const char* part : {"LKNE", "LKNM", "LTIB", "LANK", "LMED", "LHFB", "LTTC", "LHEE", "LTOE",
                             "LMT5", "LHLX", "LMT1"}) {
      if (name != part) continue;
      hide(file.markers, m, 120, 30);
      ++hidden;
    }
  }
  ASSERT_GE(hidden, 10);
  write_c3d(path() / "shank.c3d", file);
  const Outcome outcome = run("shank.c3d", "shank");
  const std::string said = reasons("shank", "gap");
  EXPECT_TRUE(holds(said, "too few markers are seen to tell ")) << outcome.err;
  EXPECT_TRUE(holds(said, "1.11 s to 1.58 s")) << said;
  EXPECT_TRUE(holds(said, "ankle_angle_l")) << said;
  EXPECT_FALSE(holds(said, "ankle_angle_r")) << said;
}

// The shank tells where the thigh would be if every joint were what the model says; no marker does.
TEST_F(LabGaps, AThighOutOfSightIsNamed) {
  C3dFile file = read_c3d(path() / "walk.c3d");
  const MusculoskeletalModel model = read_osim(path() / "model.osim");
  const int thigh = model.find_body("femur_l");
  ASSERT_GT(thigh, 0);
  int hidden = 0;
  for (const Marker& marker : model.markers) {
    const int recorded = file.markers.find_marker(marker.name);
    if (marker.body != thigh || recorded < 0) continue;
    hide(file.markers, recorded, 120, 30);
    ++hidden;
  }
  ASSERT_GE(hidden, 1);
  write_c3d(path() / "thigh.c3d", file);
  ASSERT_EQ(run("thigh.c3d", "thigh").exit_code, 0);
  const std::string said = reasons("thigh", "gap");
  EXPECT_TRUE(holds(said, "hip_flexion_l")) << said;
  EXPECT_TRUE(holds(said, "knee_angle_l")) << said;
  EXPECT_FALSE(holds(said, "ankle_angle_l")) << said;
  const TimeTable torques = table("thigh/id.sto");
  const int told = torques.find_column("hip_flexion_l_determined");
  ASSERT_GE(told, 0);
  EXPECT_EQ(torques.values(135, told), 0.0);
  EXPECT_EQ(torques.values(100, told), 1.0);
}

TEST_F(LabGaps, AMarkerOfThreeFramesSaysNothingAndIsNamed) {
  C3dFile file = read_c3d(path() / "walk.c3d");
  C3dFile without = file;
  const int toe = file.markers.find_marker("RTOE");
  // What is there is wrong, too, and must not matter.
  for (const int f : {100, 101, 102}) file.markers.p_WM(f, 3 * toe) += 0.04;
  hide(file.markers, toe, 0, 100);
  hide(file.markers, toe, 103, file.markers.frame_count() - 103);
  hide(without.markers, toe, 0, file.markers.frame_count());
  write_c3d(path() / "three.c3d", file);
  write_c3d(path() / "without.c3d", without);
  const Outcome outcome = run("three.c3d", "three");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_TRUE(holds(reasons("three", "gap"), "RTOE (3 of 221 frames)")) << reasons("three", "gap");
  ASSERT_EQ(run("without.c3d", "without").exit_code, 0);
  const TimeTable a = table("three/id.sto"), b = table("without/id.sto");
  // Force and moment at the root are vectors, of which no component has a size of its own.
  const auto peak = [&b](Eigen::Index c) {
    const Eigen::Index first = c < 6 ? c - c % 3 : c, count = c < 6 ? 3 : 1;
    return b.values.middleCols(first, count).cwiseAbs().maxCoeff();
  };
  ASSERT_EQ(b.labels[2], "pelvis_rotation_moment");
  ASSERT_EQ(b.labels[5], "pelvis_tz_force");
  for (Eigen::Index c = 0; c < a.values.cols(); ++c) {
    EXPECT_LE((a.values.col(c) - b.values.col(c)).cwiseAbs().maxCoeff(), 0.01 * peak(c) + 1e-3)
        << a.labels[static_cast<std::size_t>(c)];
  }
}

// A small volume: the feet are seen first, and two markers of a pelvis tell no pose.
TEST_F(LabGaps, BeginsWhereThePelvisIsSeen) {
  C3dFile file = read_c3d(path() / "walk.c3d");
  for (const char* name : {"RASI", "LASI", "RPSI", "LPSI", "SACR"}) {
    const int marker = file.markers.find_marker(name);
    ASSERT_GE(marker, 0) << name;
    const bool early = name == std::string("RASI") || name == std::string("SACR");
    hide(file.markers, marker, 0, early ? 20 : 45);
    hide(file.markers, marker, 190, file.markers.frame_count() - 190);
  }
  write_c3d(path() / "small.c3d", file);
  const Outcome outcome = run("small.c3d", "small", {"--no-fill-rigid", "--max-gap", "0"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  const TimeTable motion = table("small/ik.mot");
  EXPECT_NEAR(motion.time[0], file.markers.time[45], 1e-9);
  EXPECT_NEAR(motion.time[motion.time.size() - 1], file.markers.time[189], 1e-9);
  const Json from = decision(json("small/decisions.json"), "from");
  EXPECT_TRUE(holds(from["why"].get<std::string>(), "three on the pelvis among them"))
      << from.dump();
  EXPECT_EQ(reasons("small", "jump"), "");
}

// A gap must not switch the filter of everything else.
TEST_F(LabGaps, OneFilterForOneTrial) {
  C3dFile file = read_c3d(path() / "walk.c3d");
  hide(file.markers, file.markers.find_marker("LFRM"), 201, 20);
  write_c3d(path() / "end.c3d", file);
  const Outcome outcome = run("end.c3d", "end", {"--no-fill-rigid"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(decision(json("end/decisions.json"), "coordinate cutoff")["value"], -1.0);
  const auto rows = csv_rows(path() / "end/filled.csv");
  ASSERT_EQ(rows.size(), 2u);
  EXPECT_EQ(rows[1][0], "LFRM");
  EXPECT_EQ(rows[1][6], "none");
}

TEST_F(LabGaps, AMarkerAKilometreOffCostsNoTime) {
  MarkerTrajectories markers = read_trc(path() / "static.trc").markers;
  markers.p_WM.col(3 * markers.find_marker("LKNE")).array() += 1000.0;
  write_trc(path() / "far.trc", markers);
  const auto scale = [&](const std::string& trial) {
    const auto start = std::chrono::steady_clock::now();
    const Outcome outcome =
        run_sinew(path(), {"scale", "--auto", "--model", "other.osim", "--static", trial, "--mass",
                           "70", "--frames", "4", "--uniform", "--out", "scaled.osim"});
    EXPECT_NE(outcome.exit_code, -1) << "killed";
    return std::pair{
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(),
        outcome.err};
  };
  const auto [usual, quiet] = scale("static.trc");
  const auto [far, said] = scale("far.trc");
  EXPECT_FALSE(holds(quiet, "LKNE"));
  EXPECT_TRUE(holds(said, "up to 1e+03 m off, and taken as not measured then: LKNE@0-1")) << said;
  // The machine may be busy with one of the two.
  EXPECT_LT(far, 3.0 * usual + 1.0);
}

}  // namespace
}  // namespace sinew
