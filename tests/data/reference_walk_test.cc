#include "data/reference_walk.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <string_view>

namespace sinew {
namespace {

constexpr double kRadiansPerDegree = std::numbers::pi / 180.0;

const WalkCurve& curve_of(const ReferenceWalk& walk, const std::string& coordinate) {
  const auto found = std::find_if(walk.curves.begin(), walk.curves.end(),
                                  [&](const auto& c) { return c.coordinate == coordinate; });
  EXPECT_NE(found, walk.curves.end()) << coordinate;
  return *found;
}

TEST(FourierSeries, IsWhatItsFormulaSays) {
  const FourierSeries series{0.5, {0.0, 2.0}, {3.0, 0.0}};
  const double w = 2.0 * std::numbers::pi;
  for (const double x : {-0.3, 0.0, 0.1, 1.7}) {
    const auto [f, df, ddf] = evaluate(series, x);
    EXPECT_NEAR(f, 0.5 + 2.0 * std::cos(2 * w * x) + 3.0 * std::sin(w * x), 1e-13);
    EXPECT_NEAR(df, -4.0 * w * std::sin(2 * w * x) + 3.0 * w * std::cos(w * x), 1e-12);
    EXPECT_NEAR(ddf, -8.0 * w * w * std::cos(2 * w * x) - 3.0 * w * w * std::sin(w * x), 1e-11);
  }
}

TEST(ReferenceWalk, CurvesArePeriodicWithTheirDerivatives) {
  constexpr double kStep = 1e-5;  // error step²·f⁗ ~ 1e-10·(16π)⁴/12·0.01, below 1e-6
  for (const WalkCurve& curve : reference_walk().curves) {
    for (const double x : {0.0, 0.25, 0.61}) {
      const auto [f, df, ddf] = evaluate(curve.series, x);
      const auto later = evaluate(curve.series, x + 1.0);
      const double before = evaluate(curve.series, x - kStep)[0];
      const double after = evaluate(curve.series, x + kStep)[0];
      EXPECT_NEAR(later[0], f, 1e-13) << curve.coordinate;
      EXPECT_NEAR(later[1], df, 1e-11) << curve.coordinate;
      EXPECT_NEAR(later[2], ddf, 1e-9) << curve.coordinate;
      EXPECT_NEAR((after - before) / (2 * kStep), df, 1e-5) << curve.coordinate;
      EXPECT_NEAR((after - 2 * f + before) / (kStep * kStep), ddf, 1e-3) << curve.coordinate;
    }
  }
}

// Half a stride later the body is its own mirror image: what lies in the middle keeps its sign or
// changes it, and the left side does what the right did.
TEST(ReferenceWalk, IsSymmetric) {
  const ReferenceWalk walk = reference_walk();
  const auto changes_sign = [](const std::string& name) {
    return name == "pelvis_list" || name == "pelvis_tz" || name.ends_with("_rotation") ||
           name.ends_with("_bending");
  };
  for (const WalkCurve& curve : walk.curves) {
    const std::string& name = curve.coordinate;
    if (name.ends_with("_r")) {
      const WalkCurve& left = curve_of(walk, name.substr(0, name.size() - 1) + "l");
      EXPECT_EQ(left.series, curve.series) << name;
      EXPECT_EQ(left.delay, 0.5) << name;
    } else if (!name.ends_with("_l")) {
      const double sign = changes_sign(name) ? -1.0 : 1.0;
      for (const double x : {0.0, 0.13, 0.4}) {
        EXPECT_NEAR(evaluate(curve.series, x + 0.5)[0], sign * evaluate(curve.series, x)[0], 1e-13)
            << name;
      }
    }
  }
}

// Of a coordinate, or the sum over the vertebrae that share a turn of the trunk.
double angle_of(const ReferenceWalk& walk, const std::string& coordinate, double phase) {
  constexpr std::string_view kLumbar = "lumbar_";
  if (!coordinate.starts_with(kLumbar)) {
    return evaluate(curve_of(walk, coordinate).series, phase)[0];
  }
  double sum = 0.0;
  for (const std::string& vertebra : turning_vertebrae()) {
    const WalkCurve& curve = curve_of(walk, vertebra + "_" + coordinate.substr(kLumbar.size()));
    sum += evaluate(curve.series, phase)[0];
  }
  return sum;
}

// The fit to this body moves the curves off the normative ones by at most two of their standard
// deviations, root mean square; most where the toes, which are locked, do not give.
TEST(ReferenceWalk, KeepsToNormativeCurves) {
  const ReferenceWalk walk = reference_walk();
  for (const NormativeCurve& norm : normative_curves()) {
    ASSERT_EQ(norm.percent.size(), norm.degrees.size());
    double squares = 0.0;
    for (std::size_t i = 0; i < norm.percent.size(); ++i) {
      const double angle = angle_of(walk, norm.coordinate, norm.percent[i] / 100.0);
      squares += std::pow(angle / kRadiansPerDegree - norm.degrees[i], 2);
    }
    const double rms = std::sqrt(squares / static_cast<double>(norm.percent.size()));
    EXPECT_LE(rms, 2.0 * norm.standard_deviation) << norm.coordinate;
  }
}

// Winter 2009, natural cadence: 1.2 to 1.5 m/s and 1.0 to 1.25 s a stride.
TEST(ReferenceWalk, GoesAtANaturalPace) {
  const ReferenceWalk walk = reference_walk();
  EXPECT_GT(walk.stride_length / walk.stride_time, 1.2);
  EXPECT_LT(walk.stride_length / walk.stride_time, 1.5);
  EXPECT_GT(walk.stride_time, 1.0);
  EXPECT_LT(walk.stride_time, 1.25);
  EXPECT_EQ(curve_of(walk, "pelvis_tx").advance, walk.stride_length);
}

TEST(ReferenceWalk, OutlinesAreConvexAndHoldThePressure) {
  for (const WalkFoot& foot : reference_walk().feet) {
    const std::size_t n = foot.outline.size();
    const double turn = foot.side == "r" ? 1.0 : -1.0;
    for (std::size_t i = 0; i < n; ++i) {
      const Eigen::Vector3d edge = foot.outline[(i + 1) % n] - foot.outline[i];
      const Eigen::Vector3d next = foot.outline[(i + 2) % n] - foot.outline[(i + 1) % n];
      EXPECT_GT(turn * edge.cross(next).y(), 0.0) << foot.side << i;
      for (const Eigen::Vector3d& p : {foot.first_pressure, foot.last_pressure}) {
        EXPECT_GT(turn * edge.cross(p - foot.outline[i]).y(), 0.0) << foot.side << i;
      }
    }
  }
}

}  // namespace
}  // namespace sinew
