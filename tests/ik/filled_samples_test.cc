#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>

#include "ik/filled_weights.h"
#include "ik/residual_rows.h"
#include "model/osim_file.h"
#include "tests/data/test_files.h"
#include "tests/ik/methods.h"

namespace sinew {
namespace {

// A body that only shifts along x, with three markers: what is found is their weighted mean.
constexpr int kFrames = 100;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

constexpr const char* kSlider = R"(<OpenSimDocument Version="40000">
<Model name="slider">
<BodySet><objects><Body name="cart"><mass>1</mass><mass_center>0 0 0</mass_center><inertia>1 1 1 0 0 0</inertia></Body></objects></BodySet>
<JointSet><objects><SliderJoint name="rail"><socket_parent_frame>ground</socket_parent_frame><socket_child_frame>cart</socket_child_frame>
<coordinates><Coordinate name="x"/></coordinates></SliderJoint></objects></JointSet>
<MarkerSet><objects>
<Marker name="A"><socket_parent_frame>/bodyset/cart</socket_parent_frame><location>0 1 0</location></Marker>
<Marker name="B"><socket_parent_frame>/bodyset/cart</socket_parent_frame><location>0 2 0</location></Marker>
<Marker name="C"><socket_parent_frame>/bodyset/cart</socket_parent_frame><location>0 3 0</location></Marker>
</objects></MarkerSet>
</Model></OpenSimDocument>)";

class FilledSamples : public ::testing::Test {
 protected:
  FilledSamples() {
    folder_.write("slider.osim", kSlider);
    model_ = read_osim(folder_.path() / "slider.osim");
    tree_ = compile_tree(model_);
    MarkerTrajectories& markers = recording_.markers;
    markers.names = {"A", "B", "C"};
    markers.rate = 100.0;
    markers.time = Eigen::VectorXd::LinSpaced(kFrames, 0.0, 0.01 * (kFrames - 1));
    markers.p_WM.resize(kFrames, 9);
    for (int f = 0; f < kFrames; ++f) {
      markers.frame_numbers.push_back(f + 1);
      markers.p_WM.row(f) << 0.1, 1, 0, 0.2, 2, 0, 0.9, 3, 0;
    }
    tracking_ = bind_recording(model_, tree_, recording_, nullptr, nullptr);
  }

  TrackingResult solve(Method method = Method::kGaussNewton) const {
    TrackingOptions options;
    options.threads = 1;
    options.minimizer.method = method;
    return track(model_, tree_, tracking_, recording_.markers, options);
  }

  const TemporaryFolder folder_;
  MusculoskeletalModel model_;
  KinematicTree tree_;
  MarkerFile recording_;
  TrackingProblem tracking_;
};

TEST_F(FilledSamples, WeighLessAndSmoothlyBeside) {
  weigh_filled_samples(tracking_, recording_.markers, {{"C", 50, 2}}, 0.25);
  // Two frames off, a tenth of the taper of 0.2 s: 1 − 0.75 (1 − 10x³ + 15x⁴ − 6x⁵), x = 0.1.
  const double beside = 1.0 - 0.75 * (1.0 - 0.01 + 0.0015 - 0.00006);
  EXPECT_NEAR(tracking_.marker_scales(48, 2), beside, 1e-12);
  EXPECT_NEAR(tracking_.marker_scales(53, 2), beside, 1e-12);
  EXPECT_NEAR(tracking_.marker_scales(40, 2), 1.0 - 0.75 * 0.5, 1e-12);  // the middle
  for (const Method method : kEveryMethod) {
    SCOPED_TRACE(to_string(method));
    const TrackingResult result = solve(method);
    const auto mean = [](double weight) { return (0.3 + 0.9 * weight) / (2.0 + weight); };
    EXPECT_NEAR(result.coordinates(0, 0), mean(1.0), 1e-8);
    EXPECT_NEAR(result.coordinates(30, 0), mean(1.0), 1e-8);
    EXPECT_NEAR(result.coordinates(48, 0), mean(beside), 1e-8);
    EXPECT_NEAR(result.coordinates(50, 0), mean(0.25), 1e-8);
    EXPECT_NEAR(result.coordinates(51, 0), mean(0.25), 1e-8);
    EXPECT_NEAR(result.coordinates(71, 0), mean(1.0), 1e-8);
  }
  weigh_filled_samples(tracking_, recording_.markers, {{"C", 0, kFrames}}, 0.0);
  EXPECT_NEAR(solve().coordinates(2, 0), 0.15, 1e-8);
}

// Inverse variances: 5 mm of a measured sample, and what the fill is off besides.
TEST(FilledWeight, FollowsFromTheError) {
  EXPECT_EQ(filled_weight(0.0), 1.0);
  EXPECT_NEAR(filled_weight(5e-6), 1.0, 1e-6);
  EXPECT_NEAR(filled_weight(0.005), 0.5, 1e-12);
  EXPECT_NEAR(filled_weight(0.015), 0.1, 1e-12);
  EXPECT_NEAR(filled_weight(0.1), 25e-6 / (25e-6 + 0.01), 1e-12);
  EXPECT_EQ(filled_weight(std::nan("")), kFilledWeight);
  EXPECT_EQ(filled_weight(kInfinity), 0.0);
  EXPECT_EQ(filled_weight(0.03, 1.0), 1.0);
  EXPECT_EQ(filled_weight(0.001, 0.0), 0.0);
}

// A weight with a bounded second difference gives a pose with one: nowhere more than b″
// has, 5.8/T².
TEST_F(FilledSamples, WeightsHaveNoStep) {
  const double bound = 5.8 / (kWeightTaper * kWeightTaper) * 1e-4;
  for (const double error : {0.001, 0.01, kInfinity}) {
    weigh_filled_samples(tracking_, recording_.markers, {{"B", 40, 1, error}, {"B", 95, 5, error}});
    const Eigen::VectorXd w = tracking_.marker_scales.col(1);
    double steepest = 0.0;
    for (int f = 2; f < kFrames; ++f) {
      steepest = std::max(steepest, std::abs(w[f] - 2.0 * w[f - 1] + w[f - 2]));
    }
    EXPECT_LE(steepest, bound * (1.0 - filled_weight(error))) << error;
    EXPECT_NEAR(w[40], filled_weight(error), 1e-12);
  }
}

// Of markers that run out together only the ratio counts.
TEST_F(FilledSamples, MarkersThatRunOutTogetherKeepTheirRatio) {
  weigh_filled_samples(tracking_, recording_.markers,
                       {{"A", 50, 5, kInfinity}, {"B", 50, 5, kInfinity}, {"C", 50, 5, kInfinity}});
  for (int f = 0; f < kFrames; ++f) {
    if (f >= 50 && f < 55) continue;
    for (int i = 0; i < 3; ++i) EXPECT_DOUBLE_EQ(tracking_.marker_scales(f, i), 1.0) << f;
  }
}

TEST_F(FilledSamples, CountInNoError) {
  weigh_filled_samples(tracking_, recording_.markers, {{"C", 1, 2}}, 0.25);
  const TrackingResult result = solve();
  // What is measured beside them is measured, though it weighs less.
  EXPECT_EQ(result.frames[0].measured_markers, 3);
  EXPECT_EQ(result.frames[1].measured_markers, 2);
  EXPECT_TRUE(std::isnan(result.marker_errors(1, 2)));
  const double x = result.coordinates(1, 0);
  EXPECT_NEAR(result.frames[1].marker_rms,
              std::sqrt(0.5 * (std::pow(x - 0.1, 2) + std::pow(x - 0.2, 2))), 1e-12);
}

// A scale in the targets is the same as that weight in the problem: cost, gradients and rows.
TEST_F(FilledSamples, ScaleIsAWeight) {
  IkTargets scaled(tracking_.problem), plain(tracking_.problem);
  set_targets(tracking_, recording_.markers, 0, scaled);
  set_targets(tracking_, recording_.markers, 0, plain);
  scaled.position_scales = {1.0, 1.0, 0.3};
  IkProblem weighted = tracking_.problem;
  weighted.positions[2].weight *= 0.3;
  KinematicWorkspace ws(tree_);
  ws.q[0] = 0.35;
  update_kinematics(tree_, ws);
  Eigen::VectorXd g(1), h(1);
  const double f = decomposed_gradient(tree_, tracking_.problem, scaled, ws, g);
  EXPECT_DOUBLE_EQ(f, decomposed_gradient(tree_, weighted, plain, ws, h));
  EXPECT_DOUBLE_EQ(g[0], h[0]);
  EXPECT_DOUBLE_EQ(f, cost(tree_, tracking_.problem, scaled, ws));
  Eigen::Matrix3Xd J(3, 1);
  EXPECT_DOUBLE_EQ(f, jacobian_gradient(tree_, tracking_.problem, scaled, ws, J, h));
  EXPECT_NEAR(g[0], h[0], 1e-15);
  ResidualRows rows(tree_, tracking_.problem);
  rows.update(tree_, tracking_.problem, scaled, ws);
  EXPECT_NEAR((rows.A.topRows(rows.count).transpose() * rows.b.head(rows.count))[0], g[0], 1e-15);
}

TEST_F(FilledSamples, RefusesWhatDoesNotFit) {
  const auto text = [&](const std::vector<FilledStretch>& filled, double scale) -> std::string {
    try {
      weigh_filled_samples(tracking_, recording_.markers, filled, scale);
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "no error";
  };
  EXPECT_EQ(text({}, 1.5), "a filled sample's weight is 1.5; expected 0 to 1");
  EXPECT_EQ(text({{"A", 99, 2}}, 0.5),
            "filled samples 99 to 100 of A are not in a recording of 100 frames");
}

}  // namespace
}  // namespace sinew
