#include "ik/wire_binding.h"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

#include "ik/assembler.h"
#include "ik/tracking.h"
#include "tests/ik/small_model.h"

namespace sinew {
namespace {

using Eigen::Vector3d;

PathElement path_between(const std::string& name, PathElement::Kind kind, int body_a, int body_b,
                         double natural_length) {
  PathElement path;
  path.name = name;
  path.kind = kind;
  path.points.resize(2);
  path.points[0].body = body_a;
  path.points[1].body = body_b;
  path.natural_length = natural_length;
  return path;
}

// A slider on the x axis from 1 m on, and a virtual link between it and the world, held by a tendon
// of 1 m on either side.
MusculoskeletalModel slider_on_tendons() {
  MusculoskeletalModel model = empty_model();
  add_body(model, 0, Joint::Kind::kSlider, "t");
  model.bodies[1].mass = 1.0;
  model.bodies[1].I_BCm.setIdentity();
  model.coordinates[0].default_value = 1.0;
  model.markers.push_back({"tip", 1, Vector3d::Zero(), false, {}});
  add_body(model, 0, Joint::Kind::kFree, "rrrttt", {1.0, 0.0, 0.0});
  model.bodies[2].virtual_link = true;
  model.paths.push_back(path_between("near", PathElement::Kind::kTendon, 0, 2, 1.0));
  model.paths.push_back(path_between("far", PathElement::Kind::kTendon, 2, 1, 1.0));
  validate(model);
  return model;
}

MarkerFile tip_at(const std::vector<double>& x) {
  MarkerFile file;
  file.path = "tip.trc";
  file.markers.names = {"tip"};
  file.markers.rate = 100.0;
  const auto frames = static_cast<Eigen::Index>(x.size());
  file.markers.time =
      Eigen::VectorXd::LinSpaced(frames, 0.0, 0.01 * static_cast<double>(frames - 1));
  file.markers.p_WM = RowMatrix::Zero(frames, 3);
  for (Eigen::Index i = 0; i < frames; ++i) {
    file.markers.p_WM(i, 0) = x[static_cast<std::size_t>(i)];
  }
  return file;
}

TEST(Wires, ShareTheTensionThatHoldsAMarkerBack) {
  const MusculoskeletalModel model = slider_on_tendons();
  const KinematicTree tree = compile_tree(model);
  const MarkerFile recording = tip_at({1.5, 3.0, 4.0});
  BindingOptions binding;
  binding.wires.virtual_link_weight = 1e-9;
  binding.wires.tendon_weight = 0.5;
  const TrackingProblem tracking =
      bind_recording(model, tree, recording, nullptr, nullptr, binding);
  ASSERT_EQ(tracking.wires.size(), 2u);
  EXPECT_EQ(tracking.problem.wires[0].weight, 5.0);
  const TrackingResult result = track(model, tree, tracking, recording.markers, {});

  // Slack: the marker is met, and the link stays in its place.
  EXPECT_NEAR(result.coordinates(0, 0), 1.5, 1e-8);
  EXPECT_NEAR(result.furcations(0, 0), 1.0, 1e-6);
  EXPECT_NEAR(result.wire_lengths(0, 0) + result.wire_lengths(0, 1), 1.5, 1e-6);
  // Taut, at target t: two springs of 5 in a row, of 2 m together, against the marker's of 1.
  // x = 2 + 2e and 5 e = t − x.
  for (int frame = 1; frame < 3; ++frame) {
    const double excess = (recording.markers.p_WM(frame, 0) - 2.0) / 7.0;
    EXPECT_NEAR(result.coordinates(frame, 0), 2.0 + 2.0 * excess, 1e-7);
    EXPECT_NEAR(result.wire_lengths(frame, 0), 1.0 + excess, 1e-7);
    EXPECT_NEAR(result.wire_lengths(frame, 1), 1.0 + excess, 1e-7);
    EXPECT_NEAR(result.furcations(frame, 0), 1.0 + excess, 1e-7);
    // ½·1·(5e)² + 2·½·5e²
    EXPECT_NEAR(result.frames[static_cast<std::size_t>(frame)].cost, 17.5 * excess * excess, 1e-7);
  }
}

TEST(Wires, AreTheSameForSimbodysAssembler) {
  const MusculoskeletalModel model = slider_on_tendons();
  const KinematicTree tree = compile_tree(model);
  const MarkerFile recording = tip_at({1.5, 2.5, 3.0, 4.0});
  BindingOptions binding;
  binding.wires.virtual_link_weight = 0.1;
  const TrackingProblem tracking =
      bind_recording(model, tree, recording, nullptr, nullptr, binding);
  AssemblerComparisonOptions options;
  options.accuracy = 1e-9;
  const Comparison comparison =
      compare_with_assembler(model, tree, tracking, recording.markers, options);
  ASSERT_EQ(comparison.frames.size(), 4u);
  EXPECT_EQ(comparison.assembler_failures, 0);
  for (const ComparedFrame& frame : comparison.frames) {
    SCOPED_TRACE(testing::Message()
                 << frame.time << " s: " << frame.cost << " and " << frame.assembler_cost << ", "
                 << to_string(frame.termination));
    EXPECT_FALSE(frame.worse);
    EXPECT_NEAR(frame.cost, frame.assembler_cost, 1e-6 * frame.assembler_cost + 1e-12);
  }
  EXPECT_LT(comparison.angle_max.maxCoeff(), 1e-4);
}

TEST(Wires, ComeFromModelsWithVirtualLinksUnlessAskedOtherwise) {
  MusculoskeletalModel model = slider_on_tendons();
  const KinematicTree tree = compile_tree(model);
  const auto count = [&](WireOptions::Use use) {
    IkProblem problem;
    std::vector<Warning> warnings;
    WireOptions options;
    options.use = use;
    const std::size_t wires = bind_wires(model, tree, options, problem, warnings).size();
    EXPECT_EQ(problem.wires.size(), wires);
    return wires;
  };
  EXPECT_EQ(count(WireOptions::Use::kAuto), 2u);
  EXPECT_EQ(count(WireOptions::Use::kAll), 2u);
  EXPECT_EQ(count(WireOptions::Use::kNone), 0u);
  model.bodies[2].virtual_link = false;
  EXPECT_EQ(count(WireOptions::Use::kAuto), 0u);
  EXPECT_EQ(count(WireOptions::Use::kAll), 2u);
}

TEST(Wires, LeaveOutPathsThatAreNoPolylinesAndSaySo) {
  MusculoskeletalModel model = slider_on_tendons();
  model.paths.push_back(path_between("wrapped", PathElement::Kind::kMuscle, 0, 1, 1.0));
  model.paths.back().wrap_objects = {"cylinder"};
  model.paths.push_back(path_between("endless", PathElement::Kind::kMuscle, 0, 1, kNaN));
  model.paths.push_back(path_between("moving", PathElement::Kind::kMuscle, 0, 1, 1.0));
  model.paths.back().points[1].kind = PathPoint::Kind::kMoving;
  const KinematicTree tree = compile_tree(model);
  IkProblem problem;
  std::vector<Warning> warnings;
  EXPECT_EQ(bind_wires(model, tree, {}, problem, warnings).size(), 2u);
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_EQ(warnings[0].text,
            "3 of 5 paths are no wires of the inverse kinematics, since they run over wrap "
            "objects, have moving points or no natural length (first: 'wrapped')");
}

TEST(Wires, RejectOptionsOutOfBounds) {
  WireOptions options;
  options.penalty = -1.0;
  try {
    options.validate();
    FAIL();
  } catch (const std::invalid_argument& error) {
    EXPECT_STREQ(error.what(), "WireOptions.penalty is -1; expected a finite number, 0 or more");
  }
}

}  // namespace
}  // namespace sinew
