#include "data/reference_walk.h"

#include <cmath>
#include <numbers>
#include <string_view>

namespace sinew {
namespace {

constexpr double kAnkleHeight = 0.0702;  // of the whole body's man [m]
constexpr double kHeel = -0.060;         // his heel behind the ankle [m]

// Which harmonics of the stride a row of curves.inc has. What both sides share repeats with each
// step (even) or changes its side with it (odd).
enum class Harmonics { kAll, kEven, kOdd };

struct CurveRow {
  const char* coordinate;
  Harmonics harmonics;
  std::vector<double> coefficients;  // mean, a, b, a, b, …
};

const std::vector<CurveRow>& curve_rows() {
  using enum Harmonics;
  static const std::vector<CurveRow> rows = {
#include "data/reference_walk/curves.inc"
  };
  return rows;
}

FourierSeries series_of(const CurveRow& row) {
  FourierSeries series;
  series.mean = row.coefficients[0];
  const std::size_t stride = row.harmonics == Harmonics::kAll ? 1 : 2;
  std::size_t k = row.harmonics == Harmonics::kEven ? 2 : 1;
  for (std::size_t i = 1; i + 1 < row.coefficients.size(); i += 2, k += stride) {
    series.cosines.resize(k, 0.0);
    series.sines.resize(k, 0.0);
    series.cosines[k - 1] = row.coefficients[i];
    series.sines[k - 1] = row.coefficients[i + 1];
  }
  return series;
}

// Stride of 1.10 s and 1.50 m; Winter 2009 has 1.14 s and 1.51 m for the natural cadence.
constexpr double kStrideTime = 1.10;
constexpr double kStrideLength = 1.50;
// Perry & Burnfield 2010: the foot is on the floor for 62 % of the stride.
constexpr double kStance = 0.62;
// Murray MP, Drought AB, Kory RC (1964) J Bone Joint Surg Am 46:335-360: 8 cm between the heels'
// lines and 7 degrees of toeing out.
constexpr double kStepWidth = 0.08;
constexpr double kToeOut = 7.0 * std::numbers::pi / 180.0;

WalkFoot foot(bool left) {
  const double z = left ? -1.0 : 1.0, floor = -kAnkleHeight;
  WalkFoot foot;
  foot.side = left ? "l" : "r";
  foot.body = "calcn_" + foot.side;
  foot.strike = left ? 0.5 : 0.0;
  foot.stance = kStance;
  foot.toe_out = kToeOut;
  // The heel steps on x = 0 in stride 0.
  foot.p_WB = {-kHeel * std::cos(kToeOut) + foot.strike * kStrideLength, kAnkleHeight,
               z * (0.5 * kStepWidth - kHeel * std::sin(kToeOut))};
  // Length 0.267 m (de Leva), breadth 0.055 of the stature (Drillis & Contini 1966).
  foot.outline = {{-0.060, floor, -0.022 * z}, {-0.060, floor, 0.022 * z},
                  {-0.030, floor, 0.034 * z},  {0.105, floor, 0.050 * z},
                  {0.165, floor, 0.048 * z},   {0.195, floor, 0.030 * z},
                  {0.207, floor, 0.000 * z},   {0.207, floor, -0.030 * z},
                  {0.135, floor, -0.049 * z},  {-0.030, floor, -0.032 * z}};
  // Nearly steady from the heel to the big toe, as in Winter 2009, ch. 5.
  foot.first_pressure = {-0.040, floor, 0.004 * z};
  foot.last_pressure = {0.180, floor, -0.010 * z};
  return foot;
}

constexpr std::string_view kLumbar = "lumbar_";

// `lumbar_extension` becomes `L5_extension`, … with an equal part each.
void share_by_vertebrae(const WalkCurve& trunk, std::vector<WalkCurve>& curves) {
  const std::vector<std::string> vertebrae = turning_vertebrae();
  const double part = 1.0 / static_cast<double>(vertebrae.size());
  for (const std::string& vertebra : vertebrae) {
    WalkCurve curve = trunk;
    curve.coordinate = vertebra + "_" + trunk.coordinate.substr(kLumbar.size());
    curve.series.mean *= part;
    for (double& a : curve.series.cosines) a *= part;
    for (double& b : curve.series.sines) b *= part;
    curves.push_back(std::move(curve));
  }
}

}  // namespace

std::array<double, 3> evaluate(const FourierSeries& series, double phase) {
  std::array<double, 3> result{series.mean, 0.0, 0.0};
  for (std::size_t i = 0; i < series.cosines.size(); ++i) {
    const double w = 2.0 * std::numbers::pi * static_cast<double>(i + 1);
    const double c = std::cos(w * phase), s = std::sin(w * phase);
    const double a = series.cosines[i], b = series.sines[i];
    result[0] += a * c + b * s;
    result[1] += w * (b * c - a * s);
    result[2] -= w * w * (a * c + b * s);
  }
  return result;
}

std::vector<NormativeCurve> normative_curves() {
  return {
#include "data/reference_walk/normative.inc"
  };
}

std::vector<std::string> turning_vertebrae() { return {"L5", "L4", "L3", "L2"}; }

ReferenceWalk reference_walk() {
  ReferenceWalk walk;
  walk.stride_time = kStrideTime;
  walk.stride_length = kStrideLength;
  for (const CurveRow& row : curve_rows()) {
    WalkCurve curve{row.coordinate, series_of(row), 0.0, 0.0};
    if (curve.coordinate.starts_with(kLumbar)) {
      share_by_vertebrae(curve, walk.curves);
      continue;
    }
    if (curve.coordinate == "pelvis_tx") curve.advance = kStrideLength;
    walk.curves.push_back(curve);
    if (!curve.coordinate.ends_with("_r")) continue;
    curve.coordinate.back() = 'l';
    curve.delay = 0.5;
    walk.curves.push_back(curve);
  }
  walk.feet = {foot(false), foot(true)};
  return walk;
}

}  // namespace sinew
