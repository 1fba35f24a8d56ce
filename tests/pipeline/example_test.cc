#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/pipeline/command_line.h"

namespace sinew {
namespace {

using Arguments = std::vector<std::string>;

// Largest difference of a leg's column from the truth's, in the table's unit. What markers leave to
// the posture's weights, spine and fingers, differs by more.
double largest_error(const std::filesystem::path& table, const std::filesystem::path& truth) {
  const TimeTable a = read_storage(table).table, b = read_storage(truth).table;
  EXPECT_EQ(a.labels, b.labels);
  EXPECT_EQ(a.in_degrees, b.in_degrees);
  if (a.values.rows() != b.values.rows() || a.values.cols() != b.values.cols()) return 1e300;
  double largest = 0.0;
  int compared = 0;
  for (std::size_t c = 0; c < a.labels.size(); ++c) {
    const std::string& name = a.labels[c];
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
  const Arguments written = {
      "grf.mot",      "grf.xml",      "id_setup.xml",     "ik_setup.xml",
      "ik_tasks.xml", "model.osim",   "static.trc",       "truth_accelerations.sto",
      "truth_id.sto", "truth_ik.mot", "truth_speeds.sto", "walk.trc"};
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
  for (const auto& residual : json["inverse_dynamics"]["root_residuals"]) {
    EXPECT_LT(residual["rms"].get<double>(), 40.0) << residual;  // what 6 Hz takes away
  }
}

}  // namespace
}  // namespace sinew
