#include "data/laboratory_axes.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <limits>

#include "data/force_platform.h"
#include "data/marker_names.h"

namespace sinew {
namespace {

using Eigen::Vector3d;

// A walker in a model's axes, x forward, y up, z right, turned into a laboratory by R_WM.
MarkerTrajectories walker(const Eigen::Matrix3d& R_WM, double speed,
                          std::vector<std::string> names) {
  const std::vector<Vector3d> p = {{0.05, 1.7, -0.08}, {0.05, 1.7, 0.08}, {0.1, 1.0, -0.12},
                                   {0.1, 1.0, 0.12},   {0.2, 0.05, -0.1}, {-0.1, 0.05, 0.1}};
  MarkerTrajectories markers;
  markers.names = std::move(names);
  markers.rate = 100.0;
  markers.time = Eigen::VectorXd::LinSpaced(101, 0.0, 1.0);
  markers.p_WM.resize(101, 18);
  for (int f = 0; f < 101; ++f) {
    markers.frame_numbers.push_back(f + 1);
    for (std::size_t i = 0; i < p.size(); ++i) {
      markers.p_WM.row(f).segment<3>(3 * static_cast<Eigen::Index>(i)) =
          (R_WM * (p[i] + Vector3d(speed * markers.time[f], 0.0, 0.0))).transpose();
    }
  }
  return markers;
}

const std::vector<std::string> kNames = {"LFHD", "RFHD", "LASI", "RASI", "LTOE", "RHEE"};
const std::vector<std::string> kNoNames = {"m1", "m2", "m3", "m4", "m5", "m6"};

// All 24 rotations of whole axes.
std::vector<Eigen::Matrix3d> rotations() {
  std::vector<Eigen::Matrix3d> found;
  for (int a = 0; a < 6; ++a) {
    for (int b = 0; b < 6; ++b) {
      if (a % 3 == b % 3) continue;
      const Vector3d x = (a < 3 ? 1.0 : -1.0) * Vector3d::Unit(a % 3);
      const Vector3d y = (b < 3 ? 1.0 : -1.0) * Vector3d::Unit(b % 3);
      Eigen::Matrix3d R;
      R << x, y, x.cross(y);
      found.push_back(R);
    }
  }
  return found;
}

TEST(LaboratoryAxes, NamesAndWayGiveEveryRotationBack) {
  ASSERT_EQ(rotations().size(), 24u);
  for (const Eigen::Matrix3d& R_WM : rotations()) {
    const MarkerTrajectories markers = walker(R_WM, 1.3, kNames);
    const LaboratoryAxes axes = find_axes({.markers = &markers});
    EXPECT_EQ(axes.rotation(), R_WM.transpose());
    EXPECT_TRUE(axes.contradictions.empty());
    // Standing, only left and right tell where forward is.
    const MarkerTrajectories still = walker(R_WM, 0.0, kNames);
    EXPECT_EQ(find_axes({.markers = &still}).rotation(), R_WM.transpose());
  }
}

TEST(LaboratoryAxes, ForcesTellUpWithoutNames) {
  for (const Eigen::Matrix3d& R_WM : rotations()) {
    const MarkerTrajectories markers = walker(R_WM, 1.3, kNoNames);
    const LaboratoryAxes axes =
        find_axes({.markers = &markers, .reaction = R_WM * Vector3d(60.0, 700.0, -30.0)});
    EXPECT_EQ(axes.rotation(), R_WM.transpose());
    EXPECT_GT(axes.up.confidence, 0.9);
  }
}

TEST(LaboratoryAxes, ExtentIsAGuessAndNothingIsNone) {
  const MarkerTrajectories markers = walker(Eigen::Matrix3d::Identity(), 0.0, kNoNames);
  const LaboratoryAxes axes = find_axes({.markers = &markers});
  EXPECT_EQ(axis_name(axes.up.axis), "y");
  EXPECT_LT(axes.up.confidence, 0.5);
  EXPECT_EQ(axes.forward.confidence, 0.0);
  EXPECT_FALSE(find_axes({}).up.known());
}

TEST(LaboratoryAxes, WhatDisagreesIsSaid) {
  const MarkerTrajectories markers =
      walker(Eigen::Matrix3d::Identity(), -1.3, kNames);  // walks backwards
  LaboratoryAxes axes = find_axes({.markers = &markers});
  ASSERT_EQ(axes.contradictions.size(), 1u);
  EXPECT_EQ(axes.contradictions[0],
            "forward is -x by the way that the markers go, but x by left and right in the markers' "
            "names");
  axes = find_axes({.markers = &markers, .up = Vector3d::UnitZ(), .forward = Vector3d::UnitX()});
  EXPECT_EQ(axes.up.confidence, 1.0);
  EXPECT_EQ(axes.rotation().row(1), Eigen::RowVector3d::Unit(2));
  EXPECT_THROW(find_axes({.up = Vector3d::UnitZ(), .forward = -Vector3d::UnitZ()}),
               std::invalid_argument);
}

TEST(LaboratoryAxes, AxesHaveNames) {
  for (const char* name : {"x", "y", "z", "-x", "-y", "-z"}) {
    EXPECT_EQ(axis_name(parse_axis(name).value()), name);
  }
  EXPECT_EQ(parse_axis("+Z").value(), Vector3d::UnitZ());
  for (const char* none : {"", "-", "w", "xx", "auto"}) EXPECT_FALSE(parse_axis(none)) << none;
}

TEST(LaboratoryAxes, RotationKeepsNaNWhereItIs) {
  RowMatrix values(1, 6);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  values << 1.0, 2.0, 3.0, nan, nan, nan;
  Eigen::Matrix3d R;
  R << 0, 1, 0, 0, 0, 1, 1, 0, 0;
  rotate_vectors(R, values);
  EXPECT_EQ(values.leftCols(3), Eigen::RowVector3d(2.0, 3.0, 1.0));
  EXPECT_TRUE(values.rightCols(3).array().isNaN().all());
}

TEST(MarkerNames, SidesOfThePublishedSets) {
  const std::pair<const char*, Side> cases[] = {
      {"LASI", Side::kLeft},      {"RASI", Side::kRight},     {"Subject:LHEE", Side::kLeft},
      {"R.Heel", Side::kRight},   {"L_ankle", Side::kLeft},   {"calcn_r", Side::kRight},
      {"Left Knee", Side::kLeft}, {"knee_left", Side::kLeft}, {"lumbar", Side::kNone},
      {"C7", Side::kNone},        {"STRN", Side::kNone},      {"rib", Side::kNone}};
  for (const auto& [name, side] : cases) EXPECT_EQ(parse_marker_name(name).side, side) << name;
  const auto pairs = find_marker_pairs({"RASI", "C7", "LASI", "LKNE", "V:RKNE"});
  ASSERT_EQ(pairs.size(), 2u);
  EXPECT_EQ(pairs[0].left, 2);
  EXPECT_EQ(pairs[0].right, 0);
  EXPECT_EQ(pairs[1].right, 4);
}

}  // namespace
}  // namespace sinew
