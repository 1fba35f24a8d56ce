#pragma once

#include <algorithm>
#include <numeric>
#include <random>
#include <string>
#include <vector>

#include "model/musculoskeletal_model.h"

/// Random models that hold everything a description can: every kind of joint and function, frames
/// anywhere, branches, couplers in chains and across branches, locks, massless bodies. The same
/// seed gives the same model.
namespace sinew {

struct RandomModelOptions {
  int body_count = 24;    // beside ground
  int coupler_count = 5;  // each on a coordinate of its own
  int lock_count = 3;     // locked coordinates
  int marker_count = 30;  // anywhere, on ground too
  // Nothing couples or locks the coordinates of ball and free joints, so that the model also
  // compiles with quaternions.
  bool for_quaternions = false;
};

class RandomModelBuilder {
 public:
  RandomModelBuilder(unsigned seed, const RandomModelOptions& options)
      : random_(seed), options_(options) {}

  MusculoskeletalModel build() {
    model_.name = "random";
    model_.bodies.emplace_back();
    model_.bodies[0].name = "ground";
    for (int b = 1; b <= options_.body_count; ++b) add_body(b);
    add_couplers_and_locks();
    for (int m = 0; m < options_.marker_count; ++m) {
      model_.markers.push_back(
          {"marker" + std::to_string(m), integer(0, options_.body_count), vector(0.3), false, {}});
    }
    validate(model_);
    return model_;
  }

 private:
  double uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }
  int integer(int low, int high) { return std::uniform_int_distribution<int>(low, high)(random_); }
  Eigen::Vector3d vector(double size) {
    return {uniform(-size, size), uniform(-size, size), uniform(-size, size)};
  }
  RigidTransform frame() { return {rotation_from_body_xyz(vector(3.0)), vector(0.4)}; }

  // Ten points on [-2, 2] of a curve that turns by less than a radian.
  template <typename Points>
  Points points() {
    Points f;
    for (int i = 0; i < 10; ++i) {
      f.x.push_back(-2.0 + 4.0 * i / 9.0 + uniform(-0.1, 0.1));
      f.y.push_back(uniform(-0.7, 0.7));
    }
    return f;
  }

  ScalarFunction function() {
    ScalarFunction f;
    switch (next_function_++ % 9) {
      case 0:
        f.kind = points<SimmSpline>();
        break;
      case 1:
        f.kind = PolynomialFunction{{uniform(-0.1, 0.1), uniform(-0.3, 0.3), uniform(-1, 1), 0.2}};
        break;
      case 2:
        f.kind = SineFunction{uniform(0.2, 0.6), uniform(0.5, 2), uniform(-1, 1), uniform(-1, 1)};
        break;
      case 3:
        f.kind = ConstantFunction{uniform(-1, 1)};
        break;
      case 4:
        f.kind = LinearFunction{uniform(-1.5, 1.5), uniform(-0.5, 0.5)};
        break;
      case 5:
        f.kind = points<GcvSpline>();
        break;
      case 6:
        f.kind = points<PiecewiseLinearFunction>();
        break;
      case 7:
        f.kind = StepFunction{uniform(-1, 0), uniform(0.1, 1), uniform(-1, 0), uniform(0, 1)};
        break;
      default:
        f.kind = LinearFunction{};  // the coordinate itself
    }
    f.scale = integer(0, 2) == 0 ? uniform(-1.5, 1.5) : 1.0;
    return f;
  }

  void add_coordinates(Joint& joint, const std::string& motions) {
    for (const char motion : motions) {
      Coordinate c;
      c.name = "q" + std::to_string(model_.coordinates.size());
      c.joint = static_cast<int>(model_.joints.size());
      c.motion =
          motion == 'r' ? Coordinate::Motion::kRotational : Coordinate::Motion::kTranslational;
      c.default_value = uniform(-0.5, 0.5);
      joint.coordinates.push_back(static_cast<int>(model_.coordinates.size()));
      model_.coordinates.push_back(c);
    }
  }

  // Up to six coordinates, some driving several axes, some none, and axes that nothing drives.
  void add_custom_axes(Joint& joint) {
    const int count = integer(0, 6);
    add_coordinates(joint, std::string(static_cast<std::size_t>(count), 'r'));
    const RigidTransform turned = frame();
    for (int i = 0; i < 6; ++i) {
      TransformAxis& step = joint.axes[static_cast<std::size_t>(i)];
      // Never parallel: axes of a frame, bent a little.
      step.axis = turned.R.col(i % 3) + vector(0.2);
      if (i < 3) step.axis.normalize();
      step.function = function();
      if (count > 0 && integer(0, 5) > 0) {
        step.coordinate = joint.coordinates[static_cast<std::size_t>(integer(0, count - 1))];
      } else {
        step.function = {ConstantFunction{integer(0, 1) * uniform(-1, 1)}};
      }
    }
  }

  void add_body(int b) {
    using Kind = Joint::Kind;
    static const struct {
      Kind kind;
      const char* motions;
    } kKinds[] = {{Kind::kFree, "rrrttt"},  {Kind::kCustom, ""},       {Kind::kPin, "r"},
                  {Kind::kCustom, ""},      {Kind::kBall, "rrr"},      {Kind::kWeld, ""},
                  {Kind::kCustom, ""},      {Kind::kSlider, "t"},      {Kind::kGimbal, "rrr"},
                  {Kind::kUniversal, "rr"}, {Kind::kEllipsoid, "rrr"}, {Kind::kCustom, ""},
                  {Kind::kPlanar, "rtt"}};
    const auto& kind = kKinds[static_cast<std::size_t>(b - 1) % std::size(kKinds)];
    Body body;
    body.name = "body" + std::to_string(b);
    if (integer(0, 4) > 0) {
      body.mass = uniform(0.1, 10);
      body.p_BCm = vector(0.2);
      const Eigen::Matrix3d R = rotation_from_body_xyz(vector(3.0));
      const double a = uniform(0.01, 0.1);  // principal moments a, a, 1.5 a: a real body's
      body.I_BCm = R * Eigen::Vector3d(a, a, 1.5 * a).asDiagonal() * R.transpose();
    }
    model_.bodies.push_back(body);
    Joint joint;
    joint.name = "joint" + std::to_string(b);
    joint.kind = kind.kind;
    joint.parent = integer(std::max(0, b - 5), b - 1);
    joint.child = b;
    joint.X_PF = frame();
    joint.X_BM = frame();
    joint.radii = Eigen::Vector3d(uniform(0.05, 0.3), uniform(0.05, 0.3), uniform(0.05, 0.3));
    add_coordinates(joint, kind.motions);
    if (joint.kind == Kind::kCustom) add_custom_axes(joint);
    model_.joints.push_back(joint);
  }

  void add_couplers_and_locks() {
    std::vector<int> order;
    for (std::size_t c = 0; c < model_.coordinates.size(); ++c) {
      const Joint& joint = model_.joints[static_cast<std::size_t>(model_.coordinates[c].joint)];
      const bool spherical = joint.kind == Joint::Kind::kBall || joint.kind == Joint::Kind::kFree;
      if (!options_.for_quaternions || !spherical) order.push_back(static_cast<int>(c));
    }
    std::shuffle(order.begin(), order.end(), random_);
    // Sources come before dependents in a random order, the first dependents being each other's
    // sources: circles cannot arise and chains do.
    const int first = static_cast<int>(order.size()) - options_.coupler_count;
    for (int i = first; i < static_cast<int>(order.size()); ++i) {
      const int source = i > first && integer(0, 1) == 0 ? i - 1 : integer(0, i - 1);
      model_.couplers.push_back({"coupler" + std::to_string(i),
                                 order[static_cast<std::size_t>(i)],
                                 order[static_cast<std::size_t>(source)],
                                 function(),
                                 {}});
    }
    std::shuffle(model_.couplers.begin(), model_.couplers.end(), random_);
    for (int i = 0; i < options_.lock_count; ++i) {
      const auto c = static_cast<std::size_t>(order[static_cast<std::size_t>(i)]);
      model_.coordinates[c].locked = true;
    }
  }

  std::mt19937 random_;
  RandomModelOptions options_;
  MusculoskeletalModel model_;
  int next_function_ = 0;
};

inline MusculoskeletalModel random_model(unsigned seed, const RandomModelOptions& options = {}) {
  return RandomModelBuilder(seed, options).build();
}

/// Values for every coordinate of the description: angles within ±1 rad, clear of the singularity
/// of Euler angles at ±π/2, so that Simbody's speeds map to rates of coordinates.
inline std::vector<double> random_pose(const MusculoskeletalModel& model, std::mt19937& random) {
  std::uniform_real_distribution<double> value(-1.0, 1.0);
  std::vector<double> q(model.coordinates.size());
  for (double& each : q) each = value(random);
  return q;
}

}  // namespace sinew
