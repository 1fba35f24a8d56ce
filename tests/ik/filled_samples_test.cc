#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

#include "ik/residual_rows.h"
#include "ik/tracking.h"
#include "model/osim_file.h"
#include "tests/data/test_files.h"
#include "tests/ik/methods.h"

namespace sinew {
namespace {

// A body that only shifts along x, with three markers: what is found is their weighted mean.
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
    markers.time = Eigen::VectorXd::LinSpaced(4, 0.0, 0.03);
    markers.frame_numbers = {1, 2, 3, 4};
    markers.p_WM.resize(4, 9);
    for (int f = 0; f < 4; ++f) markers.p_WM.row(f) << 0.1, 1, 0, 0.2, 2, 0, 0.9, 3, 0;
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

TEST_F(FilledSamples, WeighLessInTheirFramesOnly) {
  weigh_filled_samples(tracking_, recording_.markers, {{"C", 1, 2}}, 0.25);
  for (const Method method : kEveryMethod) {
    SCOPED_TRACE(to_string(method));
    const TrackingResult result = solve(method);
    const double all = (0.1 + 0.2 + 0.9) / 3.0, less = (0.1 + 0.2 + 0.25 * 0.9) / 2.25;
    EXPECT_NEAR(result.coordinates(0, 0), all, 1e-8);
    EXPECT_NEAR(result.coordinates(1, 0), less, 1e-8);
    EXPECT_NEAR(result.coordinates(2, 0), less, 1e-8);
    EXPECT_NEAR(result.coordinates(3, 0), all, 1e-8);
  }
  weigh_filled_samples(tracking_, recording_.markers, {{"C", 0, 4}}, 0.0);
  EXPECT_NEAR(solve().coordinates(2, 0), 0.15, 1e-8);
}

TEST_F(FilledSamples, CountInNoError) {
  weigh_filled_samples(tracking_, recording_.markers, {{"C", 1, 2}}, 0.25);
  const TrackingResult result = solve();
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
  EXPECT_EQ(text({{"A", 3, 2}}, 0.5),
            "filled samples 3 to 4 of A are not in a recording of 4 frames");
}

}  // namespace
}  // namespace sinew
