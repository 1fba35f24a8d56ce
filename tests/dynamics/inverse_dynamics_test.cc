#include "dynamics/inverse_dynamics.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>
#include <random>
#include <stdexcept>
#include <string>
#include <variant>

#include "tests/dynamics/two_link_model.h"
#include "tests/model/random_model.h"

namespace sinew {
namespace {

// Each coordinate swings by itself: q = default + amplitude·sin(ω t + φ), 1 s at 100 Hz.
CoordinateTable swinging_motion(const MusculoskeletalModel& model, unsigned seed,
                                double amplitude) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> omega(3.0, 9.0), phase(0.0, 6.28);
  CoordinateTable motion;
  motion.path = "swing";
  motion.time = Eigen::VectorXd::LinSpaced(101, 0.0, 1.0);
  motion.q.resize(101, static_cast<Eigen::Index>(model.coordinates.size()));
  for (std::size_t c = 0; c < model.coordinates.size(); ++c) {
    const double w = omega(random), p = phase(random);
    motion.q.col(static_cast<Eigen::Index>(c)) =
        model.coordinates[c].default_value + amplitude * (w * motion.time.array() + p).sin();
    motion.measured.push_back(true);
  }
  return motion;
}

// A state of the compiled model on the motion, realized to Velocity.
struct OnMotion {
  std::vector<double> q, v, a;
  SimTK::State state;

  OnMotion(const SimbodyModel& compiled, const CoordinateSpline& motion, double t)
      : q(static_cast<std::size_t>(motion.size())), v(q), a(q), state(compiled.default_state()) {
    motion.evaluate(t, q, v, a);
    compiled.set_q(state, q);
    compiled.system().realize(state, SimTK::Stage::Position);
    SimTK::Vector q_dot(state.getNQ(), 0.0), u(state.getNU(), 0.0);
    for (std::size_t c = 0; c < v.size(); ++c) q_dot[compiled.q_index(static_cast<int>(c))] = v[c];
    compiled.matter().multiplyByNInv(state, false, q_dot, u);
    state.updU() = u;
    compiled.system().realize(state, SimTK::Stage::Velocity);
  }
};

double energy(const MusculoskeletalModel& model, const SimbodyModel& compiled,
              const CoordinateSpline& motion, double t) {
  const OnMotion at(compiled, motion, t);
  double result = compiled.matter().calcKineticEnergy(at.state);
  for (std::size_t b = 1; b < model.bodies.size(); ++b) {
    const SimTK::MobilizedBody& body =
        compiled.matter().getMobilizedBody(compiled.body(static_cast<int>(b)));
    const SimTK::Vec3 p =
        body.findStationLocationInGround(at.state, to_simtk(model.bodies[b].p_BCm));
    result -= model.bodies[b].mass * model.gravity.dot(to_eigen(p));
  }
  return result;
}

// Fourth-order central difference; h = 1 ms leaves (ω h)⁴/30 ≈ 1e-9 for the fastest harmonics here.
double derivative(const std::function<double(double)>& f, double t) {
  const double h = 1e-3;
  return (f(t - 2 * h) - 8 * f(t - h) + 8 * f(t + h) - f(t + 2 * h)) / (12 * h);
}

const InverseDynamicsOptions kExact{.exact_custom_joints = true};

Eigen::VectorXd one_time(double t) { return Eigen::VectorXd::Constant(1, t); }

ExternalLoads constant_load(const MusculoskeletalModel& model, const std::string& body) {
  ExternalForce force;
  force.applied_to_body = body;
  force.force_columns = {"fx", "fy", "fz"};
  force.point_columns = {"px", "py", "pz"};
  force.torque_columns = {"mx", "my", "mz"};
  ExternalLoadsSetup setup;
  setup.forces = {force};
  TimeTableFile file;
  file.table.labels = {"fx", "fy", "fz", "px", "py", "pz", "mx", "my", "mz"};
  file.table.time = Eigen::VectorXd::Zero(1);
  file.table.values = RowMatrix{{10.0, 50.0, -20.0, 0.3, 0.1, 0.2, 1.0, 2.0, 3.0}};
  return {model, setup, file};
}

std::string error_of(const std::function<void()>& function) {
  try {
    function();
  } catch (const std::exception& error) {
    return error.what();
  }
  return "no error";
}

TEST(InverseDynamics, OfASinglePendulumIsTheTextbooks) {
  MusculoskeletalModel model = two_link_model();
  model.bodies.pop_back();
  model.joints.pop_back();
  model.coordinates.pop_back();
  const SimbodyModel compiled(model);
  const CoordinateTable motion = swinging_motion(model, 1, 0.8);
  const CoordinateSpline spline = motion_spline(model, motion, -1.0);
  const TimeTable forces = inverse_dynamics(model, compiled, motion, {}).forces;
  ASSERT_EQ(forces.labels, std::vector<std::string>{"shoulder_angle_moment"});
  ASSERT_EQ(forces.time, motion.time);
  EXPECT_EQ(forces.in_degrees, false);
  const Body& body = model.bodies[1];
  const double l = 0.2, I = body.I_BCm(2, 2) + body.mass * l * l;
  for (Eigen::Index i = 0; i < forces.time.size(); ++i) {
    std::array<double, 1> q, a;
    spline.evaluate(forces.time[i], q, {}, a);
    const double expected = I * a[0] + body.mass * 9.80665 * l * std::sin(q[0]);
    EXPECT_NEAR(forces.values(i, 0), expected, 1e-12 * (1.0 + std::abs(expected)));
  }
}

// The planar double pendulum from Lagrange's equations.
TEST(InverseDynamics, OfADoublePendulumIsTheTextbooks) {
  const MusculoskeletalModel model = two_link_model();
  const SimbodyModel compiled(model);
  const CoordinateTable motion = swinging_motion(model, 2, 0.7);
  const CoordinateSpline spline = motion_spline(model, motion, -1.0);
  const TimeTable forces = inverse_dynamics(model, compiled, motion, {}).forces;
  const double m1 = 2.0, m2 = 1.5, l1 = 0.4, c1 = 0.2, c2 = 0.2, I1 = 0.031, I2 = 0.031,
               g = 9.80665;
  for (Eigen::Index i = 0; i < forces.time.size(); ++i) {
    std::array<double, 2> q, v, a;
    spline.evaluate(forces.time[i], q, v, a);
    const double h = m2 * l1 * c2, c = std::cos(q[1]), s = std::sin(q[1]);
    const double M22 = I2 + m2 * c2 * c2, M12 = M22 + h * c;
    const double M11 = I1 + m1 * c1 * c1 + M22 + m2 * l1 * l1 + 2 * h * c;
    const double g2 = m2 * g * c2 * std::sin(q[0] + q[1]);
    const double g1 = g2 + (m1 * c1 + m2 * l1) * g * std::sin(q[0]);
    EXPECT_NEAR(forces.values(i, 0),
                M11 * a[0] + M12 * a[1] - h * s * (2 * v[0] * v[1] + v[1] * v[1]) + g1, 1e-11);
    EXPECT_NEAR(forces.values(i, 1), M12 * a[0] + M22 * a[1] + h * s * v[0] * v[0] + g2, 1e-11);
  }
}

class RandomDynamics : public testing::TestWithParam<unsigned> {};

// A difference quotient cannot cross the kinks of these functions' derivatives.
void smooth(MusculoskeletalModel& model) {
  for (Joint& joint : model.joints) {
    for (TransformAxis& step : joint.axes) {
      auto& kind = step.function.kind;
      if (std::holds_alternative<PiecewiseLinearFunction>(kind) ||
          std::holds_alternative<SimmSpline>(kind) || std::holds_alternative<StepFunction>(kind)) {
        kind = SineFunction{0.4, 1.7, 0.3, 0.1};
      }
    }
  }
}

// Σ tau·q̇ + Σ F·V = dE/dt, with every kind of joint, speeds that are no rates too, and custom
// joints whose turns share coordinates in any order.
TEST_P(RandomDynamics, DoTheWorkThatTheEnergyNeeds) {
  MusculoskeletalModel model = random_model(GetParam());
  smooth(model);
  const SimbodyModel compiled(model);
  const CoordinateSpline motion =
      motion_spline(model, swinging_motion(model, GetParam(), 0.4), -1.0);
  const std::string loaded = model.bodies.back().name;
  const ExternalLoads loads = constant_load(model, loaded);
  for (double t = 0.1037; t < 0.9; t += 0.0871) {
    const TimeTable forces =
        generalized_forces(model, compiled, motion, loads, one_time(t), kExact);
    const OnMotion at(compiled, motion, t);
    double power = 0.0, size = 0.0;
    for (std::size_t c = 0; c < at.v.size(); ++c) {
      const double part = forces.values(0, static_cast<Eigen::Index>(c)) * at.v[c];
      power += part;
      size += std::abs(part);
    }
    SimTK::Vector_<SimTK::SpatialVec> F(compiled.matter().getNumBodies());
    F.setToZero();
    loads.add_body_forces(t, compiled, at.state, F);
    const SimTK::MobilizedBodyIndex b = compiled.body(model.find_body(loaded));
    power += ~F[b] * compiled.matter().getMobilizedBody(b).getBodyVelocity(at.state);
    const double rate = derivative([&](double s) { return energy(model, compiled, motion, s); }, t);
    EXPECT_NEAR(power, rate, 1e-6 * (1.0 + size)) << "at " << t << " s";
  }
}

INSTANTIATE_TEST_SUITE_P(Seeds, RandomDynamics, testing::Values(1u, 2u, 3u, 4u, 5u));

// ground – free – ball – pin, all with mass.
MusculoskeletalModel floating_model() {
  MusculoskeletalModel model = two_link_model();
  model.joints[0].kind = Joint::Kind::kFree;
  model.joints[1].kind = Joint::Kind::kBall;
  Body foot = model.bodies[2];
  foot.name = "foot";
  model.bodies.push_back(foot);
  Joint ankle = model.joints[1];
  ankle.name = "ankle";
  ankle.kind = Joint::Kind::kPin;
  ankle.parent = 2;
  ankle.child = 3;
  model.joints.push_back(ankle);
  model.coordinates.clear();
  const std::array counts = {6, 3, 1};
  for (int j = 0; j < 3; ++j) {
    model.joints[static_cast<std::size_t>(j)].coordinates.clear();
    for (int k = 0; k < counts[static_cast<std::size_t>(j)]; ++k) {
      Coordinate c;
      c.name = "q" + std::to_string(model.coordinates.size());
      c.joint = j;
      c.motion = k < 3 ? Coordinate::Motion::kRotational : Coordinate::Motion::kTranslational;
      c.default_value = 0.2;
      model.joints[static_cast<std::size_t>(j)].coordinates.push_back(
          static_cast<int>(model.coordinates.size()));
      model.coordinates.push_back(c);
    }
  }
  validate(model);
  return model;
}

// Forward dynamics of the forces gives the accelerations back.
TEST(InverseDynamics, IsUndoneByForwardDynamics) {
  const MusculoskeletalModel model = floating_model();
  const SimbodyModel compiled(model);
  const CoordinateSpline motion = motion_spline(model, swinging_motion(model, 7, 0.5), -1.0);
  const SimTK::SimbodyMatterSubsystem& matter = compiled.matter();
  for (double t = 0.05; t < 1.0; t += 0.0913) {
    const TimeTable forces = generalized_forces(model, compiled, motion, {}, one_time(t), {});
    OnMotion at(compiled, motion, t);
    compiled.system().realize(at.state, SimTK::Stage::Dynamics);
    SimTK::Vector tau_q(at.state.getNQ(), 0.0), tau_u, u_dot, q_ddot;
    for (std::size_t c = 0; c < at.q.size(); ++c) {
      tau_q[compiled.q_index(static_cast<int>(c))] = forces.values(0, static_cast<Eigen::Index>(c));
    }
    matter.multiplyByN(at.state, true, tau_q, tau_u);
    SimTK::Vector_<SimTK::SpatialVec> A;
    // Simbody's own gravity, not the one that inverse dynamics computes.
    matter.calcAccelerationIgnoringConstraints(
        at.state, tau_u, compiled.system().getRigidBodyForces(at.state, SimTK::Stage::Dynamics),
        u_dot, A);
    matter.calcQDotDot(at.state, u_dot, q_ddot);
    for (std::size_t c = 0; c < at.a.size(); ++c) {
      EXPECT_NEAR(q_ddot[compiled.q_index(static_cast<int>(c))], at.a[c],
                  1e-9 * (1.0 + std::abs(at.a[c])));
    }
  }
}

// Newton: the forces along the root's translations are m (a_com − g) − F, whatever the body does.
TEST(InverseDynamics, ObeysNewtonAtTheRoot) {
  const MusculoskeletalModel model = floating_model();
  const SimbodyModel compiled(model);
  const CoordinateSpline motion = motion_spline(model, swinging_motion(model, 8, 0.5), -1.0);
  const ExternalLoads loads = constant_load(model, "foot");
  const auto momentum = [&](double t) -> Eigen::Vector3d {
    const OnMotion at(compiled, motion, t);
    return to_eigen(compiled.matter().calcSystemMassCenterVelocityInGround(at.state)) *
           model.total_mass();
  };
  for (double t = 0.1; t < 0.9; t += 0.0931) {
    const TimeTable forces = generalized_forces(model, compiled, motion, loads, one_time(t), {});
    for (int k = 0; k < 3; ++k) {
      const double rate = derivative([&](double s) { return momentum(s)[k]; }, t);
      const double expected =
          rate - model.total_mass() * model.gravity[k] - Eigen::Vector3d(10, 50, -20)[k];
      EXPECT_NEAR(forces.values(0, 3 + k), expected, 1e-5) << "axis " << k << " at " << t;
      EXPECT_EQ(forces.labels[static_cast<std::size_t>(3 + k)],
                "q" + std::to_string(3 + k) + "_force");
    }
  }
}

// shoulder – elbow = f(shoulder) – wrist = g(elbow), given in the wrong order.
MusculoskeletalModel coupled_model() {
  MusculoskeletalModel model = two_link_model();
  Body hand = model.bodies[2];
  hand.name = "hand";
  model.bodies.push_back(hand);
  Joint wrist = model.joints[1];
  wrist.name = "wrist";
  wrist.parent = 2;
  wrist.child = 3;
  wrist.coordinates = {2};
  model.joints.push_back(wrist);
  Coordinate angle = model.coordinates[1];
  angle.name = "wrist_angle";
  angle.joint = 2;
  model.coordinates.push_back(angle);
  model.couplers = {{"second", 2, 1, {SineFunction{0.8, 1.3, 0.2, 0.1}}, {}},
                    {"first", 1, 0, {PolynomialFunction{{0.3, -0.7, 0.2}}}, {}}};
  validate(model);
  return model;
}

// Simbody's constraints, which this project's elimination shares nothing with: the projected
// torque alone drives the coupled mechanism with the motion's acceleration.
TEST(InverseDynamics, ProjectedTorqueDrivesTheCoupledMechanism) {
  const MusculoskeletalModel model = coupled_model();
  const SimbodyModel compiled(model);
  const SimbodyModel constrained(model, {.couplers_as_constraints = true});
  const CoordinateSpline motion = motion_spline(model, swinging_motion(model, 9, 0.6), -1.0);
  const CompiledFunction first(model.couplers[1].function), second(model.couplers[0].function);
  const SimTK::SimbodyMatterSubsystem& matter = constrained.matter();
  for (double t = 0.05; t < 1.0; t += 0.0913) {
    const TimeTable forces =
        generalized_forces(model, compiled, motion, {}, one_time(t), {.project_couplers = true});
    ASSERT_EQ(forces.labels, std::vector<std::string>{"shoulder_angle_moment"});
    std::array<double, 3> q, v, a;
    motion.evaluate(t, q, v, a);
    const auto f = first.evaluate(q[0]);
    const auto g = second.evaluate(f.f);
    SimTK::State state = constrained.default_state();
    constrained.set_q(state, std::array{q[0], f.f, g.f});
    const std::array u = {v[0], f.df * v[0], g.df * f.df * v[0]};
    for (int c = 0; c < 3; ++c) {
      state.updU()[constrained.u_index(c)] = u[static_cast<std::size_t>(c)];
    }
    constrained.system().realize(state, SimTK::Stage::Dynamics);
    SimTK::Vector tau(3, 0.0), u_dot;
    tau[constrained.u_index(0)] = forces.values(0, 0);
    SimTK::Vector_<SimTK::SpatialVec> A;
    matter.calcAcceleration(state, tau,
                            constrained.system().getRigidBodyForces(state, SimTK::Stage::Dynamics),
                            u_dot, A);
    EXPECT_NEAR(u_dot[constrained.u_index(0)], a[0], 1e-8 * (1.0 + std::abs(a[0]))) << t;
  }
}

TEST(InverseDynamics, LeavesCouplersAloneUnlessAsked) {
  const MusculoskeletalModel model = coupled_model();
  MusculoskeletalModel uncoupled = model;
  uncoupled.couplers.clear();
  const CoordinateTable motion = swinging_motion(model, 10, 0.6);
  const TimeTable with = inverse_dynamics(model, SimbodyModel(model), motion, {}).forces;
  const TimeTable without = inverse_dynamics(uncoupled, SimbodyModel(uncoupled), motion, {}).forces;
  EXPECT_EQ(with.labels.size(), 3u);
  EXPECT_EQ(with.values, without.values);
}

// Locks and prescribed functions do not change the motion, as in OpenSim.
TEST(InverseDynamics, IgnoresLocksAndPrescribedFunctions) {
  const MusculoskeletalModel model = two_link_model();
  MusculoskeletalModel locked = model;
  locked.coordinates[0].locked = true;
  locked.coordinates[1].prescribed = ScalarFunction{ConstantFunction{1.0}};
  const CoordinateTable motion = swinging_motion(model, 11, 0.6);
  EXPECT_EQ(inverse_dynamics(model, SimbodyModel(model), motion, {}).forces.values,
            inverse_dynamics(locked, SimbodyModel(locked), motion, {}).forces.values);
}

// A custom joint whose turns 1, 2 and 3 are driven by the coordinates `drivers` of `count`.
MusculoskeletalModel turning_model(int count, const std::array<int, 3>& drivers) {
  MusculoskeletalModel model = two_link_model();
  model.bodies.pop_back();
  model.joints.pop_back();
  Joint& joint = model.joints[0];
  joint.kind = Joint::Kind::kCustom;
  joint.coordinates.clear();
  model.coordinates.resize(1);
  for (int c = 0; c < count; ++c) {
    joint.coordinates.push_back(c);
    if (c > 0) model.coordinates.push_back(model.coordinates[0]);
    model.coordinates.back().name = "q" + std::to_string(c);
  }
  for (std::size_t k = 0; k < 6; ++k) {
    TransformAxis& step = joint.axes[k];
    step.axis = Eigen::Vector3d::Unit(static_cast<Eigen::Index>(k) % 3);
    step.coordinate = k < 3 ? drivers[k] : -1;
    if (step.coordinate >= 0) {
      step.function = {SineFunction{0.9, 1.0 + 0.3 * static_cast<double>(k), 0.2, 0.0}};
    }
  }
  validate(model);
  return model;
}

// Simbody 3.7 alone is exact where turn k is driven by coordinate k or stands still, and says work
// and energy differ elsewhere; the warning names those joints, and the correction mends them.
TEST(ExactCustomJoints, MatterWhereTurnsAreNotDrivenInOrder) {
  const struct {
    int count;
    std::array<int, 3> drivers;
    bool affected;
  } cases[] = {{3, {0, 1, 2}, false},  {1, {0, -1, -1}, false}, {1, {0, 0, -1}, false},
               {1, {0, -1, 0}, false}, {1, {-1, 0, 0}, true},   {1, {0, 0, 0}, true},
               {2, {0, 1, 0}, true},   {2, {1, 0, -1}, true},   {3, {2, 0, 1}, true},
               {3, {0, 2, 1}, true},   {2, {0, -1, 1}, false},  {2, {0, 1, 1}, false}};
  for (const auto& c : cases) {
    const MusculoskeletalModel model = turning_model(c.count, c.drivers);
    const SimbodyModel compiled(model);
    const CoordinateTable motion = swinging_motion(model, 3, 0.5);
    const CoordinateSpline spline = motion_spline(model, motion, -1.0);
    const std::string name = fmt::format("{}: {}", c.count, fmt::join(c.drivers, " "));
    double largest_error = 0.0, largest_exact_error = 0.0;
    for (double t = 0.1; t < 0.9; t += 0.0931) {
      const OnMotion at(compiled, spline, t);
      const double rate =
          derivative([&](double s) { return energy(model, compiled, spline, s); }, t);
      const auto error = [&](const InverseDynamicsOptions& options) {
        const TimeTable forces =
            generalized_forces(model, compiled, spline, {}, one_time(t), options);
        double power = 0.0;
        for (std::size_t k = 0; k < at.v.size(); ++k) {
          power += forces.values(0, static_cast<Eigen::Index>(k)) * at.v[k];
        }
        return std::abs(power - rate);
      };
      largest_error = std::max(largest_error, error({}));
      largest_exact_error = std::max(largest_exact_error, error(kExact));
    }
    EXPECT_LT(largest_exact_error, 1e-6) << name;
    EXPECT_EQ(largest_error > 1e-5, c.affected) << name << ": " << largest_error;
    const InverseDynamicsResult result = inverse_dynamics(model, compiled, motion, {});
    EXPECT_EQ(result.warnings.size(), c.affected ? 1u : 0u) << name;
    if (c.affected) {
      EXPECT_NE(to_string(result.warnings.at(0)).find("coordinates: shoulder."), std::string::npos);
    }
    EXPECT_TRUE(inverse_dynamics(model, compiled, motion, {}, kExact).warnings.empty());
  }
}

TEST(InverseDynamics, NamesColumnsByMotion) {
  MusculoskeletalModel model = two_link_model();
  model.coordinates[1].motion = Coordinate::Motion::kCoupled;  // OpenSim calls these forces
  const TimeTable forces =
      inverse_dynamics(model, SimbodyModel(model), swinging_motion(model, 1, 0.1), {}).forces;
  EXPECT_EQ(forces.labels,
            (std::vector<std::string>{"shoulder_angle_moment", "elbow_angle_force"}));
}

TEST(InverseDynamics, GivesTheSameBytesForAnyNumberOfThreads) {
  const MusculoskeletalModel model = random_model(21);
  const SimbodyModel compiled(model);
  const CoordinateTable motion = swinging_motion(model, 21, 0.4);
  const ExternalLoads loads = constant_load(model, model.bodies.back().name);
  const RowMatrix one =
      inverse_dynamics(model, compiled, motion, loads, {.cutoff = 6.0, .threads = 1}).forces.values;
  EXPECT_TRUE(one.allFinite());
  for (const int threads : {0, 2, 3, 8}) {
    const RowMatrix many =
        inverse_dynamics(model, compiled, motion, loads, {.cutoff = 6.0, .threads = threads})
            .forces.values;
    EXPECT_EQ(one, many) << threads << " threads";
  }
}

TEST(InverseDynamics, ReportsProgressAndStops) {
  const MusculoskeletalModel model = random_model(21);
  const SimbodyModel compiled(model);
  const CoordinateTable motion = swinging_motion(model, 21, 0.4);
  const int frames = static_cast<int>(motion.time.size());
  int last = 0;
  InverseDynamicsOptions options;
  options.threads = 1;
  options.progress = [&](int done, int total) {
    EXPECT_EQ(total, frames);
    EXPECT_GT(done, last);
    last = done;
    return true;
  };
  const InverseDynamicsResult whole = inverse_dynamics(model, compiled, motion, {}, options);
  EXPECT_EQ(last, frames);
  EXPECT_FALSE(whole.stopped);
  options.progress = [](int, int) { return false; };
  const InverseDynamicsResult part = inverse_dynamics(model, compiled, motion, {}, options);
  EXPECT_TRUE(part.stopped);
  int missing = 0;
  for (int row = 0; row < frames; ++row) {
    const auto values = part.forces.values.row(row);
    if (values.array().isNaN().all()) {
      ++missing;
    } else {
      EXPECT_EQ(values, whole.forces.values.row(row)) << row;
    }
  }
  EXPECT_GT(missing, 0);
  EXPECT_LT(missing, frames);
}

TEST(InverseDynamics, SolvesTheFramesInRange) {
  const MusculoskeletalModel model = two_link_model();
  const SimbodyModel compiled(model);
  CoordinateTable motion = swinging_motion(model, 12, 0.5);
  motion.warnings = {{{"swing", 0}, "a warning of the motion"}};
  const InverseDynamicsResult all = inverse_dynamics(model, compiled, motion, {});
  EXPECT_EQ(all.warnings, motion.warnings);
  // 1e-6 s inside the range, as rounded times are: still the frame that is meant.
  const TimeTable part =
      inverse_dynamics(model, compiled, motion, {}, {.from = 0.200001, .to = 0.499999}).forces;
  ASSERT_EQ(part.time.size(), 31);
  EXPECT_EQ(part.values, all.forces.values.middleRows(20, 31));
  EXPECT_EQ(
      error_of([&] { inverse_dynamics(model, compiled, motion, {}, {.from = 2.0, .to = 3.0}); }),
      "swing: no frame from 2 to 3 s; expected a range within 0 to 1 s. Choose a time range "
      "that the motion covers.");
}

// A sine of 12 Hz loses (1 + (tan/tan)⁶)⁻¹ of its amplitude at 6 Hz; the torque about a weightless
// pendulum follows its acceleration.
TEST(InverseDynamics, FiltersCoordinates) {
  MusculoskeletalModel model = two_link_model();
  model.gravity.setZero();
  const SimbodyModel compiled(model);
  CoordinateTable motion = swinging_motion(model, 13, 0.0);
  motion.q.col(0) = 0.01 * (2.0 * M_PI * 12.0 * motion.time.array()).sin();
  motion.q.col(1).setZero();
  const Eigen::VectorXd raw =
      inverse_dynamics(model, compiled, motion, {}).forces.values.col(0).segment(40, 21);
  const Eigen::VectorXd filtered = inverse_dynamics(model, compiled, motion, {}, {.cutoff = 6.0})
                                       .forces.values.col(0)
                                       .segment(40, 21);
  const double ratio = std::tan(M_PI * 0.12) / std::tan(M_PI * 0.06);
  const double gain = 1.0 / (1.0 + std::pow(ratio, 6));
  EXPECT_LT((filtered - gain * raw).cwiseAbs().maxCoeff(), 1e-3 * gain * raw.cwiseAbs().maxCoeff());
}

TEST(InverseDynamics, RejectsMotionsThatCannotBeDifferentiated) {
  const MusculoskeletalModel model = two_link_model();
  const SimbodyModel compiled(model);
  CoordinateTable motion = swinging_motion(model, 14, 0.5);
  EXPECT_EQ(error_of([&] { inverse_dynamics(model, compiled, motion, {}, {.cutoff = 60.0}); }),
            "swing: cannot be differentiated: the low-pass cutoff of 60 Hz is not below half the "
            "sampling rate of 100 Hz. Choose a cutoff below 50 Hz.");
  motion.time = motion.time.head(5).eval();
  motion.q = motion.q.topRows(5).eval();
  EXPECT_EQ(
      error_of([&] { inverse_dynamics(model, compiled, motion, {}); }),
      "swing: is too short to be differentiated; expected 6 frames or more, found 5. Take a longer "
      "record, or a longer part of it.");
  const CoordinateSpline other(Eigen::VectorXd::LinSpaced(6, 0.0, 1.0), RowMatrix::Zero(6, 3));
  EXPECT_EQ(
      error_of([&] { generalized_forces(model, compiled, other, {}, one_time(0.5), {}); }),
      "generalized_forces: the motion has 3 coordinates, the model 2 and its compiled form 2");
}

TEST(InverseDynamicsOptions, NamesFieldValueAndBound) {
  const auto error = [](const InverseDynamicsOptions& options) {
    return error_of([&] { options.validate(); });
  };
  EXPECT_EQ(
      error({.cutoff = 0.0}),
      "InverseDynamicsOptions::cutoff is 0 Hz; it must be positive, or negative for no filter");
  EXPECT_EQ(error({.from = 2.0, .to = 1.0}), "InverseDynamicsOptions::from is 2 s, after to, 1 s");
  EXPECT_EQ(error({.from = std::nan("")}),
            "InverseDynamicsOptions::from and to must be finite; leave them empty for the whole "
            "record");
  EXPECT_EQ(error({.threads = -1}),
            "InverseDynamicsOptions::threads is -1; it must be 0 (all) or positive");
}

}  // namespace
}  // namespace sinew
