#include "pipeline/load_placement.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "data/storage_file.h"
#include "tests/pipeline/command_line.h"
#include "tests/pipeline/lab_trial.h"

namespace sinew {
namespace {

using Json = nlohmann::json;

class LoadPlacementOfWalk : public WithLabTrial {
 protected:
  // The verdict on the true angles with a file of loads.
  static Json judged(const std::string& loads, int exit_code) {
    const Outcome outcome =
        run_sinew(path(), {"id", "--model", "model.osim", "--coordinates", "truth_ik.mot",
                           "--cutoff", "-1", "--loads", loads, "--out", "id.sto"});
    EXPECT_EQ(outcome.exit_code, exit_code) << loads << outcome.out << outcome.err;
    return Json::parse(content_of(path() / "id_verdict.json"));
  }
  static Json reason(const Json& verdict, const std::string& code) {
    for (const Json& r : verdict["reasons"]) {
      if (r["code"] == code) return r;
    }
    return nullptr;
  }

  // The loads with a coordinate of all points times a factor and moved [m].
  static void move_points(const std::string& coordinate, double factor, double distance) {
    TimeTable loads = read_storage(path() / "grf.mot").table;
    for (std::size_t c = 0; c < loads.labels.size(); ++c) {
      if (!loads.labels[c].ends_with("_p" + coordinate)) continue;
      auto column = loads.values.col(static_cast<Eigen::Index>(c));
      column = factor * column.array() + distance;
    }
    write_loads(loads);
  }

  // moved.mot and a setup for it, moved.xml.
  static void write_loads(const TimeTable& loads) {
    write_storage(path() / "moved.mot", loads);
    std::string setup = content_of(path() / "grf.xml");
    setup.replace(setup.find("grf.mot"), 7, "moved.mot");
    trial_->write("moved.xml", setup);
  }
};

TEST_F(LoadPlacementOfWalk, IsRightAsRecorded) {
  const Json verdict = judged("grf.xml", 0);
  EXPECT_TRUE(reason(verdict, "loads-of-other-foot").is_null()) << verdict;
  EXPECT_TRUE(reason(verdict, "loads-beside-foot").is_null()) << verdict;
  for (const char* code :
       {"loads-mirrored", "loads-turned", "loads-no-push", "loads-far-point", "loads-pull-down"}) {
    EXPECT_TRUE(reason(verdict, code).is_null()) << verdict;
  }
}

// The walk goes along z = 0, its left foot where its right one's mirror image is.
TEST_F(LoadPlacementOfWalk, TellsMirroredPoints) {
  for (const std::string axis : {"x", "z"}) {
    move_points(axis, -1.0, 0.0);
    const Json found = reason(judged("moved.xml", 1), "loads-mirrored");
    ASSERT_FALSE(found.is_null()) << axis;
    EXPECT_EQ(found["remedy"], "turn the sign of the " + axis + " of its centres of pressure");
  }
}

// Every figure of the sums is as good as before: only places tell.
TEST_F(LoadPlacementOfWalk, TellsExchangedFeet) {
  std::string setup = content_of(path() / "grf.xml");
  for (std::size_t at = 0; (at = setup.find("calcn_", at)) != setup.npos; at += 7) {
    setup[at + 6] = setup[at + 6] == 'r' ? 'l' : 'r';
  }
  trial_->write("exchanged.xml", setup);
  const Json verdict = judged("exchanged.xml", 1);
  const Json found = reason(verdict, "loads-of-other-foot");
  ASSERT_FALSE(found.is_null()) << verdict;
  EXPECT_EQ(found["weight"], "unusable");
  EXPECT_GT(found["figure"].get<double>(), 90.0);
  EXPECT_EQ(verdict["joints"]["knee_r"]["torques"], "unusable");
  EXPECT_EQ(verdict["joints"]["shoulder_r"]["torques"], "usable");
}

// To the right of both feet, so that the left foot's come to lie at the right one.
TEST_F(LoadPlacementOfWalk, TellsHowFarBesideTheFootForcesAct) {
  move_points("z", 1.0, -1.0);  // z points to the right
  const Json far = reason(judged("moved.xml", 1), "loads-beside-foot");
  ASSERT_FALSE(far.is_null());
  EXPECT_EQ(far["weight"], "unusable");
  EXPECT_NEAR(far["figure"].get<double>(), 1000.0, 80.0);  // half of a foot's width
}

// Centres of pressure as laboratories export them where hardly anything acts.
TEST_F(LoadPlacementOfWalk, TellsPointsThatAreFarOffWhereForcesAreSmall) {
  TimeTable loads = read_storage(path() / "grf.mot").table;
  const int force = loads.find_column("ground_force_r_vy"),
            point = loads.find_column("ground_force_r_px");
  ASSERT_TRUE(force >= 0 && point >= 0);
  double farthest = 0.0;
  for (Eigen::Index f = 0; f < loads.time.size(); ++f) {
    if (!(loads.values(f, force) > 0.0) || loads.values(f, force) > 40.0) continue;
    loads.values(f, point) += 20.0;
    // Markers are recorded at 100 Hz.
    const double hundredths = 100.0 * loads.time[f];
    if (std::abs(hundredths - std::round(hundredths)) > 1e-6) continue;
    farthest = std::max(farthest, loads.values(f, force) * 20.0);
  }
  ASSERT_GT(farthest, 100.0);
  write_loads(loads);
  const Json found = reason(judged("moved.xml", 1), "loads-far-point");
  ASSERT_FALSE(found.is_null());
  // The foot is no farther than its length, and its force is not the upward part alone.
  EXPECT_NEAR(found["figure"].get<double>(), farthest, 0.1 * farthest);
}

// Exchanged columns leave every length as it is.
TEST_F(LoadPlacementOfWalk, TellsExchangedAxes) {
  TimeTable loads = read_storage(path() / "grf.mot").table;
  for (const std::string side : {"r", "l"}) {
    loads.values.col(loads.find_column("ground_force_" + side + "_vx"))
        .swap(loads.values.col(loads.find_column("ground_force_" + side + "_vz")));
  }
  write_loads(loads);
  const Json found = reason(judged("moved.xml", 1), "loads-turned");
  ASSERT_FALSE(found.is_null());
  EXPECT_NE(found["text"].get<std::string>().find("x is z, z is x"), std::string::npos) << found;
}

TEST_F(LoadPlacementOfWalk, TellsForcesOnLegs) {
  for (const auto& [body, exit_code] :
       {std::pair{"tibia_r", 0}, std::pair{"femur_r", 0}, std::pair{"pelvis", 0}}) {
    std::string setup = content_of(path() / "grf.xml");
    setup.replace(setup.find("calcn_r"), 7, body);
    trial_->write("leg.xml", setup);
    const Json verdict = judged("leg.xml", exit_code);
    ASSERT_FALSE(reason(verdict, "loads-not-on-foot").is_null()) << verdict;
    EXPECT_EQ(verdict["joints"]["foot_r"]["torques"], "unusable") << verdict;
  }
}

// One of the steps of a foot is given to the other.
TEST_F(LoadPlacementOfWalk, TellsASingleStepOfTheOtherFoot) {
  TimeTable loads = read_storage(path() / "grf.mot").table;
  const auto column = [&](const char* name) { return loads.find_column(name); };
  const int right = column("ground_force_r_vx"), left = column("ground_force_l_vx");
  ASSERT_TRUE(right >= 0 && left >= 0);
  for (Eigen::Index f = 0; f < loads.time.size(); ++f) {
    if (loads.time[f] > 0.9) continue;
    const Eigen::RowVectorXd step = loads.values.block<1, 9>(f, right);
    loads.values.block<1, 9>(f, right) = loads.values.block<1, 9>(f, left);
    loads.values.block<1, 9>(f, left) = step;
  }
  write_loads(loads);
  EXPECT_FALSE(reason(judged("moved.xml", 1), "loads-of-other-foot").is_null());
}

}  // namespace
}  // namespace sinew
