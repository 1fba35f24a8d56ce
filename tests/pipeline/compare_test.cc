#include <nlohmann/json.hpp>

#include "tests/pipeline/command_line.h"

namespace sinew {
namespace {

// Two motions of a knee, in degrees under OpenSim 3's labels and in radians under OpenSim 4's.
class Compare : public ::testing::Test {
 protected:
  Compare() {
    folder_.write("a.mot",
                  "Coordinates\nversion=1\nnRows=3\nnColumns=4\ninDegrees=yes\nendheader\n"
                  "time\tknee_angle_r\tpelvis_tx\town\n"
                  "0\t10\t0.1\t1\n0.1\t20\t0.25\t1\n0.2\t30\t0.3\t1\n");
    folder_.write("b.sto",
                  "Coordinates\nversion=1\nnRows=3\nnColumns=3\ninDegrees=yes\nendheader\n"
                  "time\tknee_angle_r\tpelvis_tx\n"
                  "0\t10\t0.1\n0.1\t21\t0.25\n0.2\t34\t0.3\n");
    folder_.write(
        "c.sto",
        "Coordinates\nversion=1\nnRows=3\nnColumns=3\ninDegrees=no\nendheader\n"
        "time\t/jointset/knee_r/knee_angle_r/value\t/jointset/ground_pelvis/pelvis_tx/value\n"
        "0\t0.17453292519943295\t0.1\n0.1\t0.3490658503988659\t0.25\n"
        "0.2\t0.5235987755982988\t0.3\n");
  }

  const TemporaryFolder folder_;
  const std::filesystem::path& path_ = folder_.path();
};

TEST_F(Compare, PrintsATableOfErrors) {
  const Outcome outcome = run_sinew(path_, {"compare", "a.mot", "b.sto"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(outcome.out,
            "a.mot against b.sto: 3 rows, 0 s to 0.2 s\n"
            "column                                       RMS         max      at s        peak"
            "     max %   rough\n"
            "knee_angle_r                                2.38           4       0.2          34"
            "      11.8       0\n"
            "pelvis_tx                                      0           0         0         0.3"
            "         0       1\n"
            "only in a.mot: 1 column: own\n");
}

TEST_F(Compare, FailsBeyondATolerance) {
  const Outcome outcome = run_sinew(path_, {"compare", "a.mot", "b.sto", "--tolerance", "3.9"});
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_NE(outcome.out.find("1 of 2 columns beyond 3.9: knee_angle_r\n"), std::string::npos)
      << outcome.out;
  EXPECT_EQ(run_sinew(path_, {"compare", "a.mot", "b.sto", "--tolerance", "4"}).exit_code, 0);
  EXPECT_EQ(run_sinew(path_, {"compare", "a.mot", "b.sto", "--percent", "11"}).exit_code, 1);
  EXPECT_EQ(run_sinew(path_, {"compare", "a.mot", "b.sto", "--percent", "12"}).exit_code, 0);
}

TEST_F(Compare, WritesJsonOfTheWorstColumns) {
  const Outcome outcome =
      run_sinew(path_, {"compare", "a.mot", "b.sto", "--worst", "1", "--percent", "5", "--json"});
  EXPECT_EQ(outcome.exit_code, 1) << outcome.err;
  const auto json = nlohmann::json::parse(outcome.out);
  ASSERT_EQ(json["columns"].size(), 1u);
  const auto& knee = json["columns"][0];
  EXPECT_EQ(knee["name"], "knee_angle_r");
  EXPECT_EQ(knee["rows"], 3);
  EXPECT_NEAR(knee["mean"].get<double>(), -5.0 / 3.0, 1e-12);
  EXPECT_NEAR(knee["rms"].get<double>(), std::sqrt(17.0 / 3.0), 1e-12);
  EXPECT_NEAR(knee["max_percent"].get<double>(), 100.0 * 4.0 / 34.0, 1e-12);
  EXPECT_NEAR(knee["true_roughness"].get<double>(), 2.0 / 0.01, 1e-9);
  EXPECT_EQ(json["only_in_result"][0], "own");
  EXPECT_EQ(json["beyond_tolerance"], 1);
}

TEST_F(Compare, AModelSaysWhatAnAngleIs) {
  const Outcome refused = run_sinew(path_, {"compare", "a.mot", "c.sto"});
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_EQ(error_line(refused, path_),
            "a.mot: cannot be compared with c.sto: their angles have different units; expected "
            "radians, found degrees. Give the model, which says what an angle is.");
  const Outcome outcome = run_sinew(
      path_, {"compare", "a.mot", "c.sto", "--model", "whole-body", "--tolerance", "1e-12"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.out << outcome.err;
  EXPECT_NE(outcome.out.find("knee_angle_r"), std::string::npos);
  EXPECT_NE(outcome.err.find("own"), std::string::npos) << outcome.err;
}

TEST_F(Compare, RefusesWhatIsNoTable) {
  const Outcome outcome = run_sinew(path_, {"compare", "a.mot", "walk.c3d"});
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_EQ(error_line(outcome, path_),
            "walk.c3d is a C3D file: convert it first, with sinew convert");
  EXPECT_EQ(run_sinew(path_, {"compare", "a.mot"}).exit_code, 2);
}

}  // namespace
}  // namespace sinew
