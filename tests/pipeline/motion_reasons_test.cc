#include "pipeline/motion_reasons.h"

#include <gtest/gtest.h>

#include <numbers>

#include "data/storage_file.h"
#include "model/osim_file.h"
#include "tests/pipeline/lab_trial.h"

namespace sinew {
namespace {

class MotionReasons : public WithLabTrial {
 protected:
  MotionReasons()
      : model_(read_osim(path() / "model.osim")),
        motion_(coordinate_table(model_, read_storage(path() / "truth_ik.mot"))) {}

  Eigen::Index column(const std::string& name) const {
    for (std::size_t c = 0; c < model_.coordinates.size(); ++c) {
      if (model_.coordinates[c].name == name) return static_cast<Eigen::Index>(c);
    }
    throw std::invalid_argument(name);
  }

  MusculoskeletalModel model_;
  CoordinateTable motion_;
};

TEST_F(MotionReasons, AWalkHasNone) { EXPECT_TRUE(motion_reasons(model_, motion_).empty()); }

TEST_F(MotionReasons, RadiansThatAHeaderCallsDegrees) {
  TimeTableFile file = read_storage(path() / "truth_ik.mot");
  ASSERT_EQ(file.table.in_degrees, true);
  for (std::size_t c = 0; c < model_.coordinates.size(); ++c) {
    const int i = file.table.find_column(model_.coordinates[c].name);
    if (i < 0 || model_.coordinates[c].motion != Coordinate::Motion::kRotational) continue;
    file.table.values.col(i) *= std::numbers::pi / 180.0;
  }
  CoordinateTable radians = coordinate_table(model_, file);
  const std::vector<VerdictReason> reasons = motion_reasons(model_, radians);
  ASSERT_EQ(reasons.size(), 1u);
  EXPECT_EQ(reasons[0].code, "angles-unit");
  EXPECT_EQ(reasons[0].weight, VerdictReason::Weight::kUnusable);
  EXPECT_LT(reasons[0].figure, reasons[0].limit);
  // Who stands may be as straight.
  for (const char* name : {"pelvis_tx", "pelvis_ty", "pelvis_tz"}) {
    radians.q.col(column(name)).setConstant(0.9);
  }
  EXPECT_TRUE(motion_reasons(model_, radians).empty());
}

TEST_F(MotionReasons, KneesThatBendTheOtherWay) {
  const auto bend = [&](const char* name) {
    auto q = motion_.q.col(column(name));
    q = -(q.cwiseAbs().array() + 1.0).matrix();
  };
  const Coordinate& knee = model_.coordinates[static_cast<std::size_t>(column("knee_angle_r"))];
  ASSERT_GT(knee.range_min, -0.6);
  bend("knee_angle_r");
  std::vector<VerdictReason> reasons = motion_reasons(model_, motion_);
  ASSERT_EQ(reasons.size(), 1u);
  EXPECT_EQ(reasons[0].code, "beyond-range");
  EXPECT_EQ(reasons[0].weight, VerdictReason::Weight::kRemark);
  EXPECT_EQ(reasons[0].torques, std::vector<std::string>{"knee_angle_r"});
  bend("knee_angle_l");
  reasons = motion_reasons(model_, motion_);
  ASSERT_EQ(reasons.size(), 1u);
  EXPECT_EQ(reasons[0].weight, VerdictReason::Weight::kUnusable);
}

}  // namespace
}  // namespace sinew
