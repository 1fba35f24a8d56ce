#include "data/coordinate_spline.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>

namespace sinew {
namespace {

constexpr double kOmega = 2.0 * std::numbers::pi;

struct Motion {
  std::array<double, 2> q, v, a;
};

Motion evaluate(const CoordinateSpline& spline, double t) {
  Motion m;
  spline.evaluate(t, m.q, m.v, m.a);
  return m;
}

// 1 s of samples every 10 ms: a sine and a parabola.
CoordinateSpline sampled_spline() {
  const Eigen::VectorXd time = Eigen::VectorXd::LinSpaced(101, 0.0, 1.0);
  RowMatrix q(101, 2);
  q.col(0) = (kOmega * time.array()).sin();
  q.col(1) = 0.5 * time.array().square() - time.array() + 3.0;
  return {time, q};
}

TEST(CoordinateSpline, DifferentiatesASine) {
  const CoordinateSpline spline = sampled_spline();
  // The natural ends (f''' = f'''' = 0) disturb the first and last tenth of this record.
  for (double t = 0.15; t < 0.85; t += 0.00317) {
    const Motion m = evaluate(spline, t);
    EXPECT_NEAR(m.q[0], std::sin(kOmega * t), 1e-9) << t;
    EXPECT_NEAR(m.v[0], kOmega * std::cos(kOmega * t), 1e-6) << t;
    EXPECT_NEAR(m.a[0], -kOmega * kOmega * std::sin(kOmega * t), 1e-4) << t;
  }
}

TEST(CoordinateSpline, ReproducesAParabolaEverywhere) {
  const CoordinateSpline spline = sampled_spline();
  EXPECT_EQ(spline.size(), 2);
  for (double t = 0.0; t <= 1.0; t += 0.0625) {
    const Motion m = evaluate(spline, t);
    EXPECT_NEAR(m.q[1], 0.5 * t * t - t + 3.0, 1e-13);
    EXPECT_NEAR(m.v[1], t - 1.0, 1e-11);
    EXPECT_NEAR(m.a[1], 1.0, 1e-8);
  }
}

TEST(CoordinateSpline, DerivativesAgreeWithFiniteDifferences) {
  const CoordinateSpline spline = sampled_spline();
  const double h = 1e-5;
  for (double t = 0.01; t < 0.99; t += 0.0173) {
    const Motion before = evaluate(spline, t - h), at = evaluate(spline, t),
                 after = evaluate(spline, t + h);
    for (std::size_t j = 0; j < 2; ++j) {
      EXPECT_NEAR((after.q[j] - before.q[j]) / (2 * h), at.v[j], 1e-7);
      EXPECT_NEAR((after.v[j] - before.v[j]) / (2 * h), at.a[j], 1e-6);
    }
  }
}

TEST(CoordinateSpline, SkipsEmptySpans) {
  const CoordinateSpline spline = sampled_spline();
  std::array<double, 2> v{};
  spline.evaluate(0.25, {}, v, {});
  EXPECT_NEAR(v[1], -0.75, 1e-11);
}

TEST(CoordinateSpline, RejectsTimesOutsideAndShortRecords) {
  const CoordinateSpline spline = sampled_spline();
  const auto error_of = [](auto function) -> std::string {
    try {
      function();
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "no error";
  };
  EXPECT_EQ(error_of([&] { evaluate(spline, 1.5); }), "1.5 s is outside the record of 0 to 1 s");
  EXPECT_EQ(error_of([&] { evaluate(spline, std::nan("")); }),
            "nan s is outside the record of 0 to 1 s");
  const Eigen::VectorXd time = Eigen::VectorXd::LinSpaced(5, 0.0, 1.0);
  EXPECT_EQ(error_of([&] { CoordinateSpline(time, RowMatrix::Ones(5, 1)); }),
            "differentiation needs at least 6 frames, there are 5");
}

}  // namespace
}  // namespace sinew
