#include "ik/warm_start.h"

#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "tests/ik/small_model.h"

namespace sinew {
namespace {

// One slider, solved for value(0), value(1), …: where each frame after it would start.
class Slider {
 public:
  explicit Slider(double upper = 1e9) {
    MusculoskeletalModel model = empty_model();
    add_body(model, 0, Joint::Kind::kSlider, "t");
    clamp(model.coordinates[0], -upper, upper);
    tree_ = compile_tree(model);
    problem_.positions = {{1, Eigen::Vector3d::Zero()}};
    warm_ = std::make_unique<WarmStart>(tree_, problem_);
  }
  double start_after(double solution, bool measured = true) {
    std::vector<double> q = {solution};
    IkTargets targets(problem_);
    if (measured) targets.positions[0].setZero();
    warm_->advance(tree_, problem_, targets, q);
    return q[0];
  }
  void reset() { warm_->reset(); }

 private:
  KinematicTree tree_;
  IkProblem problem_;
  std::unique_ptr<WarmStart> warm_;
};

TEST(WarmStart, GoesOnAsItWent) {
  Slider slider;
  EXPECT_EQ(slider.start_after(1.0), 1.0);  // nothing before
  EXPECT_EQ(slider.start_after(3.0), 3.0);  // nothing tells yet which is better
  for (int frame = 2; frame < 8; ++frame) {
    EXPECT_EQ(slider.start_after(1.0 + 2.0 * frame), 3.0 + 2.0 * frame);
  }
  slider.reset();
  EXPECT_EQ(slider.start_after(5.0), 5.0);
}

TEST(WarmStart, GoesOnAsItSpedUp) {
  Slider slider;
  for (int frame = 0; frame < 10; ++frame) {
    const double start = slider.start_after(frame * frame);
    EXPECT_TRUE(frame < 4 || start == (frame + 1.0) * (frame + 1.0)) << start;
  }
}

// Alternating values: an extrapolation would be off by twice or four times as much.
TEST(WarmStart, StaysWhereThereIsNothingButNoise) {
  Slider slider;
  for (int frame = 0; frame < 10; ++frame) {
    const double value = frame % 2 == 0 ? 1.0 : -1.0;
    EXPECT_EQ(slider.start_after(value), value);
  }
}

TEST(WarmStart, DoesNotJumpAgainAfterAJump) {
  Slider slider;
  for (int frame = 0; frame < 8; ++frame) slider.start_after(0.01 * frame);
  EXPECT_EQ(slider.start_after(6.0), 6.0);
  EXPECT_EQ(slider.start_after(6.01), 6.01);
  for (int frame = 2; frame < 40; ++frame) slider.start_after(6.0 + 0.01 * frame);
  EXPECT_NEAR(slider.start_after(6.4), 6.41, 1e-12);
}

TEST(WarmStart, StaysWhereTheMarkerIsMissing) {
  Slider slider;
  for (int frame = 0; frame < 8; ++frame) slider.start_after(frame * frame);
  // Nothing holds it now: its solutions are its starts.
  for (int frame = 0; frame < 20; ++frame) EXPECT_EQ(slider.start_after(64.0, false), 64.0);
  EXPECT_EQ(slider.start_after(64.0), 64.0);
}

TEST(WarmStart, KeepsBounds) {
  Slider slider(0.5);
  for (int frame = 0; frame < 5; ++frame) slider.start_after(0.1 * frame);
  EXPECT_EQ(slider.start_after(0.5), 0.5);
}

}  // namespace
}  // namespace sinew
