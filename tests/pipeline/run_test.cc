#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "tests/pipeline/command_line.h"
#include "tests/pipeline/small_trial.h"

namespace sinew {
namespace {

using Arguments = std::vector<std::string>;
using Json = nlohmann::json;

constexpr double kDegree = std::numbers::pi / 180.0;

class Run : public ::testing::Test {
 protected:
  Run() { SmallTrial::write(folder_); }

  const std::filesystem::path& path() const { return folder_.path(); }

  Outcome run(const Arguments& more = {}) const {
    Arguments all = {"run", "--model", "model.osim", "--markers", "walk.trc"};
    all.insert(all.end(), more.begin(), more.end());
    return run_sinew(path(), all);
  }

  Json summary(const std::string& folder) const {
    return Json::parse(content_of(path() / folder / "summary.json"));
  }

  TemporaryFolder folder_;
};

std::string sha256sum(const std::filesystem::path& file) {
  const std::string command = "sha256sum '" + file.string() + "'";
  std::string text(64, ' ');
  FILE* pipe = ::popen(command.c_str(), "r");
  const std::size_t read = ::fread(text.data(), 1, text.size(), pipe);
  ::pclose(pipe);
  return text.substr(0, read);
}

TEST_F(Run, WritesTablesThatOpenSimReads) {
  const Outcome outcome = run({"--loads", "grf.xml", "--out", "r"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(tree_of(path() / "r"),
            (Arguments{"frame_errors.csv", "id.sto", "ik.mot", "marker_errors.csv", "summary.json",
                       "verdict.json"}));
  const TimeTableFile ik = read_storage(path() / "r/ik.mot");
  EXPECT_TRUE(ik.warnings.empty());
  EXPECT_EQ(ik.table.labels, (Arguments{"tilt", "x", "y", "flexion"}));
  EXPECT_EQ(ik.table.in_degrees, true);
  ASSERT_EQ(ik.table.time.size(), SmallTrial::kFrames);
  for (int i = 0; i < SmallTrial::kFrames; ++i) {
    const SmallTrial::Pose q = SmallTrial::pose(i * SmallTrial::kStep);
    EXPECT_NEAR(ik.table.time[i], i * SmallTrial::kStep, 1e-12);
    EXPECT_NEAR(ik.table.values(i, 0) * kDegree, q.tilt, 1e-6);
    EXPECT_NEAR(ik.table.values(i, 1), q.x, 1e-6);
    EXPECT_NEAR(ik.table.values(i, 2), q.y, 1e-6);
    EXPECT_NEAR(ik.table.values(i, 3) * kDegree, q.hip, 1e-6);
  }
  const TimeTableFile id = read_storage(path() / "r/id.sto");
  EXPECT_EQ(id.table.labels, (Arguments{"tilt_moment", "x_force", "y_force", "flexion_moment"}));
  EXPECT_EQ(id.table.in_degrees, false);
  EXPECT_EQ(id.table.time, ik.table.time);
}

TEST_F(Run, SummaryHoldsWhatTheResultDependsOn) {
  const Outcome outcome = run({"--loads", "grf.xml", "--tasks", "tasks.xml", "--cutoff", "12",
                               "--from", "0.25", "--to", "1", "--method", "lbfgs", "--out", "r"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const Json json = summary("r");
  for (const char* name : {"sinew", "compiler", "simbody", "eigen", "tbb"}) {
    EXPECT_FALSE(json["versions"][name].get<std::string>().empty()) << name;
  }
  const std::vector<std::pair<std::string, std::string>> inputs = {{"model", "model.osim"},
                                                                   {"markers", "walk.trc"},
                                                                   {"tasks", "tasks.xml"},
                                                                   {"loads", "grf.xml"},
                                                                   {"load_data", "grf.mot"}};
  EXPECT_EQ(json["inputs"].size(), inputs.size());
  for (const auto& [role, file] : inputs) {
    EXPECT_EQ(json["inputs"][role]["sha256"], sha256sum(path() / file)) << role;
    EXPECT_TRUE(json["inputs"][role]["path"].get<std::string>().ends_with(file)) << role;
  }
  const Json options = json["options"];
  EXPECT_EQ(options["method"], "lbfgs");
  EXPECT_EQ(options["cutoff_hz"], 12.0);
  EXPECT_EQ(options["from_s"], 0.25);
  EXPECT_EQ(options["to_s"], 1.0);
  EXPECT_EQ(options["project_couplers"], false);
  EXPECT_EQ(options["exact_custom_joints"], false);
  EXPECT_EQ(options["gradient_tolerance"], 1e-9);
  EXPECT_EQ(json["inverse_kinematics"]["frames"], 76);
  EXPECT_EQ(json["inverse_dynamics"]["frames"], 76);
  EXPECT_EQ(json["warnings"], Json::array());
  EXPECT_EQ(outcome.err, "");
}

TEST_F(Run, RootResidualsAreThoseOfTheTable) {
  ASSERT_EQ(run({"--loads", "grf.xml", "--out", "r"}).exit_code, 0);
  const TimeTable id = read_storage(path() / "r/id.sto").table;
  const Json residuals = summary("r")["inverse_dynamics"]["root_residuals"];
  ASSERT_EQ(residuals.size(), 3u);
  for (const Json& residual : residuals) {
    const int column = id.find_column(residual["column"]);
    ASSERT_GE(column, 0);
    const auto values = id.values.col(column);
    EXPECT_NEAR(residual["rms"].get<double>(), std::sqrt(values.squaredNorm() / values.size()),
                1e-9);
    EXPECT_NEAR(residual["max"].get<double>(), values.cwiseAbs().maxCoeff(), 1e-9);
    EXPECT_EQ(residual["unit"], residual["column"] == "tilt_moment" ? "N m" : "N");
  }
}

// The two tables of errors and the summary say the same of the same frames and markers.
TEST_F(Run, ErrorTablesAgree) {
  MarkerTrajectories noisy = SmallTrial::recording();
  for (int frame = 0; frame < noisy.frame_count(); ++frame) {
    for (int k = 0; k < 18; ++k) noisy.p_WM(frame, k) += 0.003 * std::sin(7.0 * frame + 3.0 * k);
  }
  write_trc(path() / "walk.trc", noisy);
  ASSERT_EQ(run({"--loads", "grf.xml", "--out", "r"}).exit_code, 0);
  const auto markers = csv_rows(path() / "r/marker_errors.csv");
  const auto frames = csv_rows(path() / "r/frame_errors.csv");
  ASSERT_EQ(markers.size(), 7u);
  ASSERT_EQ(frames.size(), 1u + SmallTrial::kFrames);
  EXPECT_EQ(markers[0],
            (Arguments{"marker", "weight", "frames_measured", "rms_m", "max_m", "time_of_max_s"}));
  const std::size_t first = 7;  // columns before those of markers
  EXPECT_EQ(
      Arguments(frames[0].begin(), frames[0].begin() + first),
      (Arguments{"time_s", "cost", "rms_m", "max_m", "worst_marker", "iterations", "termination"}));
  double worst_rms = 0.0, total = 0.0;
  int count = 0;
  std::string worst;
  for (std::size_t m = 1; m < markers.size(); ++m) {
    EXPECT_EQ(frames[0][first + m - 1], markers[m][0]);
    double sum = 0.0, largest = -1.0, time = 0.0;
    int measured = 0;
    for (std::size_t f = 1; f < frames.size(); ++f) {
      ASSERT_EQ(frames[f].size(), frames[0].size());
      const std::string& cell = frames[f][first + m - 1];
      if (cell.empty()) continue;
      const double error = std::stod(cell);
      ++measured;
      sum += error * error;
      if (error > largest) {
        largest = error;
        time = std::stod(frames[f][0]);
      }
    }
    EXPECT_EQ(std::stoi(markers[m][2]), measured) << markers[m][0];
    EXPECT_EQ(measured, markers[m][0] == "L,2" ? SmallTrial::kFrames - 5 : SmallTrial::kFrames);
    EXPECT_NEAR(std::stod(markers[m][3]), std::sqrt(sum / measured), 1e-12);
    EXPECT_EQ(std::stod(markers[m][4]), largest);
    EXPECT_EQ(std::stod(markers[m][5]), time);
    total += sum;
    count += measured;
    if (std::sqrt(sum / measured) > worst_rms) {
      worst_rms = std::sqrt(sum / measured);
      worst = markers[m][0];
    }
  }
  const Json ik = summary("r")["inverse_kinematics"];
  EXPECT_EQ(ik["worst_marker"]["name"], worst);
  EXPECT_NEAR(ik["worst_marker"]["rms_m"].get<double>(), worst_rms, 1e-12);
  EXPECT_NEAR(ik["marker_rms_m"].get<double>(), std::sqrt(total / count), 1e-12);
  double worst_frame = 0.0;
  for (std::size_t f = 1; f < frames.size(); ++f) {
    double sum = 0.0, largest = 0.0;
    int measured = 0;
    for (std::size_t c = first; c < frames[f].size(); ++c) {
      if (frames[f][c].empty()) continue;
      const double error = std::stod(frames[f][c]);
      sum += error * error;
      ++measured;
      if (error > largest) {
        largest = error;
        EXPECT_LE(error, std::stod(frames[f][3]));
      }
    }
    EXPECT_NEAR(std::stod(frames[f][2]), std::sqrt(sum / measured), 1e-12);
    EXPECT_EQ(std::stod(frames[f][3]), largest);
    EXPECT_NEAR(std::stod(frames[f][1]), 0.5 * sum, 1e-12);  // every weight is 1
    if (std::stod(frames[f][2]) > worst_frame) worst_frame = std::stod(frames[f][2]);
  }
  EXPECT_EQ(ik["worst_frame"]["rms_m"].get<double>(), worst_frame);
}

TEST_F(Run, SameBytesForAnyNumberOfThreads) {
  ASSERT_EQ(run({"--loads", "grf.xml", "--threads", "1", "--out", "1"}).exit_code, 0);
  for (const std::string threads : {"2", "5"}) {
    const Outcome outcome = run({"--loads", "grf.xml", "--threads", threads, "--out", threads});
    ASSERT_EQ(outcome.exit_code, 0);
    EXPECT_EQ(outcome.err, "");
    for (const char* file : {"ik.mot", "id.sto", "marker_errors.csv", "frame_errors.csv"}) {
      EXPECT_EQ(content_of(path() / "1" / file), content_of(path() / threads / file)) << file;
    }
  }
}

TEST_F(Run, SolvesTheRangeThatWasAskedFor) {
  ASSERT_EQ(run({"--from", "0.3", "--to", "0.6", "--out", "r"}).exit_code, 0);
  for (const char* file : {"r/ik.mot", "r/id.sto"}) {
    const Eigen::VectorXd time = read_storage(path() / file).table.time;
    EXPECT_EQ(time.size(), 31);
    EXPECT_NEAR(time[0], 0.3, 1e-9);
    EXPECT_NEAR(time[time.size() - 1], 0.6, 1e-9);
  }
  const Outcome beyond = run({"--from", "-1", "--to", "9", "--out", "all"});
  EXPECT_EQ(beyond.exit_code, 0);
  EXPECT_NE(beyond.err.find("warning: walk.trc: the time range, -1 s to 9 s, goes beyond the "
                            "record; walk.trc has 0 s to 1.5 s, and only that is solved\n"),
            std::string::npos)
      << beyond.err;
  EXPECT_EQ(read_storage(path() / "all/ik.mot").table.time.size(), SmallTrial::kFrames);
}

// A filter that ended with the range would bend the motion there.
TEST_F(Run, TorquesOfARangeAreThoseOfTheWholeRecord) {
  write_trc(path() / "walk.trc", SmallTrial::recording(200));
  write_storage(path() / "grf.mot", SmallTrial::loads(0.0, 199 * SmallTrial::kStep));
  ASSERT_EQ(run({"--loads", "grf.xml", "--accept", "--out", "all"}).exit_code, 0);
  ASSERT_EQ(run({"--loads", "grf.xml", "--accept", "--from", "0.8", "--to", "1.0", "--out", "part"})
                .exit_code,
            0);
  const TimeTable all = read_storage(path() / "all/id.sto").table,
                  part = read_storage(path() / "part/id.sto").table;
  const auto first = static_cast<Eigen::Index>(std::round(0.8 / SmallTrial::kStep));
  ASSERT_EQ(part.time.size(), static_cast<Eigen::Index>(std::round(0.2 / SmallTrial::kStep)) + 1);
  ASSERT_NEAR(part.time[0], 0.8, 1e-9);
  ASSERT_EQ(part.labels, all.labels);
  for (Eigen::Index c = 0; c < part.values.cols(); ++c) {
    const double peak = all.values.col(c).cwiseAbs().maxCoeff();
    EXPECT_NEAR((part.values.col(c) - all.values.col(c).segment(first, part.time.size()))
                    .cwiseAbs()
                    .maxCoeff(),
                0.0, 0.01 * peak)
        << part.labels[static_cast<std::size_t>(c)];
  }
}

TEST_F(Run, WithoutLoadsTheRootCarriesTheWeight) {
  const Outcome outcome = run({"--out", "r"});
  EXPECT_EQ(outcome.exit_code, 0);
  const std::string warning =
      "inverse dynamics: no external loads are given: whatever carries the body is missing, and "
      "the root's residuals hold its weight; --loads FILE.xml gives them";
  EXPECT_EQ(outcome.err, "warning: " + warning + "\n");
  EXPECT_EQ(summary("r")["warnings"], Json::array({warning}));
  const TimeTable id = read_storage(path() / "r/id.sto").table;
  // Over whole periods of the motion the mean force is the weight of 48 kg.
  EXPECT_NEAR(id.values.col(id.find_column("y_force")).head(100).mean(), 48.0 * 9.80665, 5.0);
}

TEST_F(Run, ReplacesResultsAndLeavesOthersAlone) {
  std::filesystem::create_directory(path() / "r");
  folder_.write("r/ik.mot", "old");
  folder_.write("r/notes.txt", "mine");
  ASSERT_EQ(run({"--out", "r"}).exit_code, 0);
  EXPECT_GT(content_of(path() / "r/ik.mot").size(), 1000u);
  EXPECT_EQ(content_of(path() / "r/notes.txt"), "mine");
  EXPECT_EQ(tree_of(path() / "r").size(), 7u);
}

TEST_F(Run, NamesFramesThatDidNotConverge) {
  // So small that rounding alone is larger: frames stall, or run into the limit.
  const Outcome outcome = run({"--method", "steepest-descent", "--gradient-tolerance", "1e-300",
                               "--from", "0", "--to", "0.2", "--out", "r"});
  const Json ik = summary("r")["inverse_kinematics"];
  const auto unconverged = ik["frames_not_converged"].get<std::size_t>();
  ASSERT_EQ(ik["not_converged"].size(), unconverged);
  EXPECT_EQ(outcome.exit_code, unconverged > 0 ? 1 : 0);
  EXPECT_EQ(outcome.err.find("did not converge") != std::string::npos, unconverged > 0);
  EXPECT_EQ(read_storage(path() / "r/ik.mot").table.time.size(), 21);
}

TEST_F(Run, NamesFramesWithoutAnyMarker) {
  MarkerTrajectories gap = SmallTrial::recording();
  gap.p_WM.middleRows(50, 10).setConstant(std::numeric_limits<double>::quiet_NaN());
  write_trc(path() / "walk.trc", gap);
  const Outcome outcome = run({"--loads", "grf.xml", "--out", "r"});
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_NE(outcome.err.find("warning: walk.trc: no tracked marker is measured in 10 of 151 "
                             "frames, where angles go on from what is known beside them: 0.5 s, "
                             "0.51 s, 0.52 s, 0.53 s, "
                             "0.54 s, 0.55 s, 0.56 s, 0.57 s and 2 more\n"),
            std::string::npos)
      << outcome.err;
  const TimeTable ik = read_storage(path() / "r/ik.mot").table;
  EXPECT_TRUE(ik.values.allFinite());
  // From what is known before to what is known behind, and nowhere beyond.
  const auto low = ik.values.row(49).cwiseMin(ik.values.row(60));
  const auto high = ik.values.row(49).cwiseMax(ik.values.row(60));
  for (int f = 50; f < 60; ++f) {
    EXPECT_TRUE((ik.values.row(f).array() >= low.array() - 1e-6).all()) << f;
    EXPECT_TRUE((ik.values.row(f).array() <= high.array() + 1e-6).all()) << f;
  }
  EXPECT_EQ(csv_rows(path() / "r/frame_errors.csv")[1 + 55][2], "");
}

TEST_F(Run, InverseDynamicsOfItsOwnMotionIsTheSame) {
  ASSERT_EQ(run({"--loads", "grf.xml", "--cutoff", "-1", "--out", "r"}).exit_code, 0);
  const Outcome id = run_sinew(path(), {"id", "--model", "model.osim", "--coordinates", "r/ik.mot",
                                        "--loads", "grf.xml", "--cutoff", "-1", "--out", "id.sto"});
  ASSERT_EQ(id.exit_code, 0) << id.err;
  EXPECT_TRUE(id.out.starts_with("151 frames, coordinates not filtered\n")) << id.out;
  EXPECT_TRUE(id.out.ends_with("\nid.sto\n")) << id.out;
  const TimeTable one = read_storage(path() / "r/id.sto").table;
  const TimeTable two = read_storage(path() / "id.sto").table;
  EXPECT_EQ(one.labels, two.labels);
  // Degrees in the file round once.
  EXPECT_LT((one.values - two.values).cwiseAbs().maxCoeff(), 1e-6);
}

TEST_F(Run, InverseKinematicsAloneWritesTheSameMotion) {
  ASSERT_EQ(run({"--out", "r"}).exit_code, 0);
  const Outcome ik = run_sinew(path(), {"ik", "--model", "model.osim", "--markers", "walk.trc",
                                        "--out", "new/folder/q.mot"});
  ASSERT_EQ(ik.exit_code, 0) << ik.err;
  EXPECT_EQ(content_of(path() / "new/folder/q.mot"), content_of(path() / "r/ik.mot"));
}

TEST_F(Run, SetupsWriteBesideThemselvesWhereverTheyAreCalledFrom) {
  std::filesystem::create_directory(path() / "study");
  folder_.write("study/ik.xml",
                "<OpenSimDocument Version=\"40000\">\n<InverseKinematicsTool name=\"t\">\n"
                "<results_directory>tables</results_directory>\n"
                "<model_file>..\\model.osim</model_file>\n<marker_file>../walk.trc</marker_file>\n"
                "<IKTaskSet file=\"../tasks.xml\"/>\n<time_range>0.1 0.4</time_range>\n"
                "<output_motion_file>out/q.mot</output_motion_file>\n"
                "</InverseKinematicsTool>\n</OpenSimDocument>\n");
  folder_.write("study/id.xml",
                "<OpenSimDocument Version=\"40000\">\n<InverseDynamicsTool name=\"t\">\n"
                "<results_directory>out</results_directory>\n"
                "<model_file>../model.osim</model_file>\n"
                "<coordinates_file>out/q.mot</coordinates_file>\n"
                "<external_loads_file>../grf.xml</external_loads_file>\n"
                "<lowpass_cutoff_frequency_for_coordinates>8</"
                "lowpass_cutoff_frequency_for_coordinates>\n"
                "<output_gen_force_file>torques</output_gen_force_file>\n"
                "</InverseDynamicsTool>\n</OpenSimDocument>\n");
  const Outcome ik = run_sinew(path(), {"ik", "--setup", "study/ik.xml"});
  ASSERT_EQ(ik.exit_code, 0) << ik.err;
  EXPECT_EQ(read_storage(path() / "study/out/q.mot").table.time.size(), 31);
  // Its forces hold the weight alone, while its trunk is pushed to and fro.
  const Outcome id = run_sinew(path(), {"id", "--setup", "study/id.xml", "--accept"});
  ASSERT_EQ(id.exit_code, 0) << id.err;
  EXPECT_NE(id.out.find("31 frames, coordinates low-passed at 8 Hz\n"), std::string::npos);
  EXPECT_EQ(tree_of(path() / "study"),
            (Arguments{"id.xml", "ik.xml", "out", "out/q.mot", "out/q_verdict.json",
                       "out/torques.sto", "out/torques_verdict.json"}));
  // Options go before the setup.
  const Outcome other = run_sinew(path(), {"id", "--setup", "study/id.xml", "--cutoff", "-1",
                                           "--from", "0.2", "--accept", "--out", "here.sto"});
  ASSERT_EQ(other.exit_code, 0) << other.err;
  EXPECT_TRUE(other.out.starts_with("21 frames, coordinates not filtered\n")) << other.out;
  EXPECT_TRUE(other.out.ends_with("\nhere.sto\n")) << other.out;
}

TEST_F(Run, ValidatePassesAndFailsByExitCode) {
  const Arguments trial = {"validate", "--model", "model.osim", "--markers",
                           "walk.trc", "--every", "25"};
  Arguments json = trial;
  json.insert(json.end(), {"--json", "v.json"});
  const Outcome pass = run_sinew(path(), json);
  EXPECT_EQ(pass.exit_code, 0) << pass.out;
  EXPECT_NE(pass.out.find("\nPASS: Sinew is worse than the Assembler in 0 of 7 frames"),
            std::string::npos)
      << pass.out;
  const Json report = Json::parse(content_of(path() / "v.json"));
  EXPECT_EQ(report["passed"], true);
  EXPECT_EQ(report["frames"].size(), 7u);
  EXPECT_EQ(report["frames_not_converged"], 0);
  EXPECT_EQ(report["inputs"]["model"]["sha256"], sha256sum(path() / "model.osim"));
  EXPECT_EQ(report["differences_rad_or_m"].size(), 4u);
  EXPECT_EQ(report["options"]["tolerance"], 1e-6);
  // A tolerance so wide that Sinew stops where it starts.
  Arguments lazy = trial;
  lazy.insert(lazy.end(), {"--gradient-tolerance", "1e3"});
  const Outcome fail = run_sinew(path(), lazy);
  EXPECT_EQ(fail.exit_code, 1);
  EXPECT_NE(fail.out.find("\nFAIL: Sinew is worse than the Assembler in 7 of 7 frames"),
            std::string::npos)
      << fail.out;
  EXPECT_NE(fail.out.find("Sinew worse"), std::string::npos);
}

}  // namespace
}  // namespace sinew
