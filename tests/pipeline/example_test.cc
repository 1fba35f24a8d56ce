#include <gtest/gtest.h>

#include <cmath>
#include <iostream>
#include <nlohmann/json.hpp>

#include "data/trc_file.h"
#include "tests/pipeline/command_line.h"

namespace sinew {
namespace {

using Arguments = std::vector<std::string>;

// Largest difference of a leg's column from the truth's, in the table's unit. What markers leave to
// the posture's weights, spine and fingers, differs by more.
double largest_error(const std::filesystem::path& table, const std::filesystem::path& truth) {
  const TimeTable a = read_storage(table).table, b = read_storage(truth).table;
  // Columns that say which torques follow from markers come after those of the truth.
  const std::vector<std::string> theirs(
      a.labels.begin(),
      a.labels.begin() + static_cast<std::ptrdiff_t>(std::min(a.labels.size(), b.labels.size())));
  EXPECT_EQ(theirs, b.labels);
  EXPECT_EQ(a.in_degrees, b.in_degrees);
  if (a.values.rows() != b.values.rows() || a.values.cols() < b.values.cols()) return 1e300;
  double largest = 0.0;
  int compared = 0;
  for (std::size_t c = 0; c < b.labels.size(); ++c) {
    const std::string& name = b.labels[c];
    if (!name.starts_with("hip_") && !name.starts_with("knee_angle") &&
        !name.starts_with("ankle_angle")) {
      continue;
    }
    ++compared;
    const auto column = static_cast<Eigen::Index>(c);
    largest =
        std::max(largest, (a.values.col(column) - b.values.col(column)).cwiseAbs().maxCoeff());
  }
  EXPECT_EQ(compared, 12);
  return largest;
}

TEST(Example, SetupsAndRunGiveBackTheTruth) {
  const TemporaryFolder folder;
  const std::filesystem::path& path = folder.path();
  const Outcome example = run_sinew(path, {"example", "--out", "walk"});
  ASSERT_EQ(example.exit_code, 0) << example.err;
  EXPECT_EQ(example.out, "walk\n");
  const Arguments written = {"grf.mot",      "grf.xml",      "id_setup.xml",
                             "ik_setup.xml", "ik_tasks.xml", "model.osim",
                             "static.c3d",   "static.trc",   "truth_accelerations.sto",
                             "truth_id.sto", "truth_ik.mot", "truth_speeds.sto",
                             "walk.c3d",     "walk.trc"};
  EXPECT_EQ(tree_of(path / "walk"), written);

  ASSERT_EQ(run_sinew(path, {"ik", "--setup", "walk/ik_setup.xml"}).exit_code, 0);
  ASSERT_EQ(run_sinew(path, {"id", "--setup", "walk/id_setup.xml"}).exit_code, 0);
  EXPECT_GT(tree_of(path / "walk").size(), written.size());

  // Markers without noise and no filter: the truth to 1e-4 rad, by which tendons and posture draw.
  const Outcome run = run_sinew(
      path, {"run", "--model", "walk/model.osim", "--markers", "walk/walk.trc", "--tasks",
             "walk/ik_tasks.xml", "--loads", "walk/grf.xml", "--cutoff", "-1", "--out", "r"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_LT(largest_error(path / "r/ik.mot", path / "walk/truth_ik.mot"), 0.006);
  // At the record's ends a spline does not know the acceleration.
  EXPECT_LT(largest_error(path / "r/id.sto", path / "walk/truth_id.sto"), 6.0);
}

// Largest difference of two tables' values; NaN against NaN is none.
double largest_difference(const RowMatrix& a, const RowMatrix& b) {
  if (a.rows() != b.rows() || a.cols() != b.cols()) return 1e300;
  double largest = 0.0;
  for (Eigen::Index i = 0; i < a.size(); ++i) {
    const double x = a.data()[i], y = b.data()[i];
    if (std::isnan(x) && std::isnan(y)) continue;
    const double difference = std::abs(x - y);
    largest = difference <= largest ? largest : difference;  // also if it is NaN
  }
  return largest;
}

TEST(Example, LaboratoryFilesGiveTheSameRecordingBack) {
  const TemporaryFolder folder;
  const std::filesystem::path& path = folder.path();
  ASSERT_EQ(run_sinew(path, {"example", "--level", "simplified", "--noise", "0.001", "--occlusion",
                             "0.05", "--out", "e"})
                .exit_code,
            0);
  for (const std::string trial : {"walk", "static"}) {
    const Outcome outcome =
        run_sinew(path, {"convert", "e/" + trial + ".c3d", "--out", trial + ".trc"});
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_EQ(outcome.err, "");
    EXPECT_NE(outcome.out.find("up is z ("), std::string::npos) << outcome.out;
    EXPECT_NE(outcome.out.find("forward is y ("), std::string::npos) << outcome.out;
    const MarkerTrajectories back = read_trc(path / (trial + ".trc")).markers;
    const MarkerTrajectories given = read_trc(path / "e" / (trial + ".trc")).markers;
    EXPECT_EQ(back.names, given.names);
    EXPECT_EQ(back.frame_numbers, given.frame_numbers);
    // 32 bits of positions within 4 m, rounded once to them and once to as many digits.
    EXPECT_LT(largest_difference(back.p_WM, given.p_WM), 2.5e-7);
  }

  const Outcome outcome =
      run_sinew(path, {"convert", "e/walk.c3d", "--model", "e/model.osim", "--threshold", "0.01",
                       "--loads", "grf.xml", "--out", "grf.mot"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(outcome.err, "");
  const TimeTable back = read_storage(path / "grf.mot").table;
  const TimeTable given = read_storage(path / "e/grf.mot").table;
  ASSERT_EQ(back.values.rows(), given.values.rows());
  // The last step begins 10 ms before the end, which is too short to be taken for one.
  const Eigen::Index rows = 2200;
  EXPECT_LT((back.time - given.time).cwiseAbs().maxCoeff(), 1e-9);
  int compared = 0;
  for (const auto& [foot, side] : {std::pair{"right", "r"}, {"left", "l"}}) {
    const auto columns = [&](const TimeTable& table, const std::string& first) {
      const int column = table.find_column(first);
      EXPECT_GE(column, 0) << first;
      return table.values.middleCols<3>(std::max(column, 0)).topRows(rows).eval();
    };
    const std::string name = foot, ground = std::string("ground_");
    const RowMatrix force = columns(given, ground + "force_" + side + "_vx");
    // 0.01 N is the threshold: what is less is zero.
    EXPECT_LT(largest_difference(columns(back, name + "_force_vx"), force), 0.011);
    const RowMatrix point = columns(given, ground + "force_" + side + "_px"),
                    torque = columns(given, ground + "torque_" + side + "_x"),
                    point_back = columns(back, name + "_force_px"),
                    torque_back = columns(back, name + "_torque_x");
    for (Eigen::Index i = 0; i < force.rows(); ++i) {
      if (force(i, 1) < 20.0) continue;
      ++compared;
      ASSERT_LT((point_back.row(i) - point.row(i)).norm(), 1e-6) << i;
      ASSERT_LT((torque_back.row(i) - torque.row(i)).norm(), 2e-5) << i;
    }
  }
  EXPECT_GT(compared, 2400);  // two feet for 62 % of 2.2 s
}

TEST(Example, RunWithoutFilesSolvesIt) {
  const TemporaryFolder folder;
  const Outcome run = run_sinew(folder.path(), {"run", "--out", "r"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_TRUE(run.out.starts_with(
      "no model given: running the embedded walk, written to r/example\ninverse kinematics: "))
      << run.out;
  const auto json = nlohmann::json::parse(content_of(folder.path() / "r/summary.json"));
  EXPECT_EQ(json["inverse_kinematics"]["frames_not_converged"], 0);
  EXPECT_EQ(json["inputs"].size(), 5u);

  // Every joint between bones, in degrees. What markers determine is held to 1e-4 rad by the tests
  // of dynamics; how lumbar vertebrae share a turn, which the posture decides, comes to 2e-4 rad.
  const Outcome angles =
      run_sinew(folder.path(), {"compare", "r/ik.mot", "r/example/truth_ik.mot", "--model",
                                "whole-body-detailed", "--tolerance", "0.0115", "--worst", "3"});
  EXPECT_EQ(angles.exit_code, 0) << angles.out << angles.err;
  // Torques but for the record's ends, where a spline does not know the accelerations.
  const auto torques = nlohmann::json::parse(
      run_sinew(folder.path(), {"compare", "r/id.sto", "r/example/truth_id.sto", "--json", "--from",
                                "0.1", "--to", "2.1"})
          .out);
  int compared = 0;
  for (const auto& column : torques["columns"]) {
    const std::string name = column["name"];
    const double largest = column["max"];
    if (name.starts_with("pelvis_")) {
      // By construction the floor carries all of the body: there is nothing left at the root.
      EXPECT_LT(column["peak"], 1e-8) << name;
      EXPECT_LT(largest, name.ends_with("_force") ? 0.3 : 0.05) << name;
    } else if (column["peak"] > 1.0) {  // [N m]; not patellae, fingers and toes
      ++compared;
      EXPECT_LT(column["max_percent"], 1.0) << name;
    }
  }
  EXPECT_GT(compared, 80);
}

// RMS, of leg angles in degrees or their torques in % of the peak, and the largest roughness.
struct LegErrors {
  double rms = 0.0, roughness = 0.0;
  int columns = 0;
};

LegErrors leg_errors(const std::filesystem::path& folder, const std::string& result,
                     const std::string& truth, bool percent) {
  const Outcome outcome =
      run_sinew(folder, {"compare", result, truth, "--json", "--from", "0.1", "--to", "2.1"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  LegErrors errors;
  const auto json = nlohmann::json::parse(outcome.out);
  for (const auto& column : json["columns"]) {
    const std::string name = column["name"];
    // All of it is there: not a NaN anywhere.
    EXPECT_EQ(column["rows"], 201) << name;
    if (!name.starts_with("hip_") && !name.starts_with("knee_angle_") &&
        !name.starts_with("ankle_angle_")) {
      continue;
    }
    if (name.find("beta") != name.npos) continue;  // follows the knee
    ++errors.columns;
    const double scale = percent ? 100.0 / column["peak"].get<double>() : 1.0;
    errors.rms = std::max(errors.rms, scale * column["rms"].get<double>());
    errors.roughness = std::max(errors.roughness, column["roughness"].get<double>() /
                                                      column["true_roughness"].get<double>());
  }
  EXPECT_EQ(errors.columns, 10);
  return errors;
}

// Noise of 5 mm a coordinate is ten times that of optical systems.
TEST(Example, NoiseAndGapsLeaveResultsFiniteAndSmooth) {
  const TemporaryFolder folder;
  const std::filesystem::path& path = folder.path();
  ASSERT_EQ(run_sinew(path, {"example", "--noise", "0.005", "--occlusion", "0.1", "--out", "e"})
                .exit_code,
            0);
  const Outcome run =
      run_sinew(path, {"run", "--model", "e/model.osim", "--markers", "e/walk.trc", "--tasks",
                       "e/ik_tasks.xml", "--loads", "e/grf.xml", "--cutoff", "6", "--out", "r"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const LegErrors angles = leg_errors(path, "r/ik.mot", "e/truth_ik.mot", false);
  const LegErrors torques = leg_errors(path, "r/id.sto", "e/truth_id.sto", true);
  std::cout << "legs: angles RMS " << angles.rms << " degrees, roughness " << angles.roughness
            << "; torques RMS " << torques.rms << " % of the peak, roughness " << torques.roughness
            << "\n";
  EXPECT_LT(angles.rms, 2.0);
  EXPECT_LT(torques.rms, 10.0);
  // The filter makes torques bend no more than 1.5 times what the true ones do.
  EXPECT_LT(torques.roughness, 1.5);
}

}  // namespace
}  // namespace sinew
