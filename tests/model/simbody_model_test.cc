#include "model/simbody_model.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <sstream>

#include "model/osim_file.h"
#include "tests/model/random_model.h"
#include "tests/model/shared_models.h"

namespace sinew {
namespace {

// The mass matrix needs a mass behind every coordinate, which massless ends of branches lack.
MusculoskeletalModel random_massive_model(unsigned seed) {
  MusculoskeletalModel model = random_model(seed);
  for (std::size_t b = 1; b < model.bodies.size(); ++b) {
    if (model.bodies[b].mass > 0.0) continue;
    model.bodies[b].mass = 1.0;
    model.bodies[b].I_BCm = 0.1 * Eigen::Matrix3d::Identity();
  }
  return model;
}

TEST(SimbodyModel, HasTheMassPropertiesOfTheDescription) {
  const MusculoskeletalModel model = random_model(2);
  const SimbodyModel simbody(model);
  SimTK::State state = simbody.default_state();
  simbody.system().realize(state, SimTK::Stage::Position);
  for (std::size_t b = 1; b < model.bodies.size(); ++b) {
    const SimTK::MobilizedBody& mobilized =
        simbody.matter().getMobilizedBody(simbody.body(static_cast<int>(b)));
    const SimTK::MassProperties& properties = mobilized.getBodyMassProperties(state);
    const Body& body = model.bodies[b];
    EXPECT_EQ(properties.getMass(), body.mass);
    EXPECT_EQ(to_eigen(properties.getMassCenter()), body.p_BCm);
    if (body.mass == 0.0) continue;
    const SimTK::Mat33 I = properties.calcCentralInertia().toMat33();
    for (int i = 0; i < 9; ++i) EXPECT_NEAR(I(i / 3, i % 3), body.I_BCm(i / 3, i % 3), 1e-15);
  }
}

// Kinetic energy by the tree's bodies, ½ Σ (m v² + w·I w), is that of Simbody's mass matrix: speeds
// and Jacobians of every joint, constant turns included, fit each other.
TEST(SimbodyModel, MovesBodiesByItsMassMatrix) {
  for (unsigned seed = 0; seed < 10; ++seed) {
    const MusculoskeletalModel model = random_massive_model(seed);
    const SimbodyModel simbody(model);
    SimTK::State state = simbody.default_state();
    std::mt19937 random(seed);
    simbody.set_q(state, random_pose(model, random));
    std::uniform_real_distribution<double> value(-1.0, 1.0);
    for (int i = 0; i < state.getNU(); ++i) state.updU()[i] = value(random);
    simbody.system().realize(state, SimTK::Stage::Velocity);
    SimTK::Vector momentum;
    simbody.matter().multiplyByM(state, state.getU(), momentum);
    const double by_mass_matrix = 0.5 * (~state.getU() * momentum);
    EXPECT_NEAR(simbody.matter().calcKineticEnergy(state), by_mass_matrix, 1e-12 * by_mass_matrix);
  }
}

// toes_r and toes_l of this model have moments of 0.0001, 0.0002 and 0.001.
TEST(SimbodyModel, AcceptsInertiasThatNoBodyHasAfterReading) {
  SINEW_SKIP_WITHOUT_SHARED_DATA();
  const MusculoskeletalModel model =
      read_osim(kSharedData / "nimblephysics/Arnold2013Synthetic/unscaled_generic.osim");
  const int toes = model.find_body("toes_r");
  ASSERT_GT(toes, 0);
  const Eigen::Matrix3d expected = Eigen::Vector3d(0.00045, 0.00055, 0.001).asDiagonal();
  EXPECT_LE((model.bodies[static_cast<std::size_t>(toes)].I_BCm - expected).norm(), 1e-18);
  EXPECT_EQ(model.warnings[0].text,
            "the inertia of body 'toes_r' (0.0001 0.0002 0.001 0 0 0) belongs to no real body; the "
            "nearest that does (0.00045 0.00055 0.001 0 0 0) is used");
  EXPECT_NO_THROW(SimbodyModel{model});
}

// Repaired inertias lie on the border of what Simbody accepts; rounding must not push them over it.
TEST(SimbodyModel, AcceptsWhateverInertiaAFileHolds) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> value(-1.0, 1.0);
  for (int i = 0; i < 200; ++i) {
    const double scale = std::pow(10.0, 3.0 * value(random));
    std::ostringstream text;
    text << "<OpenSimDocument Version=\"40000\"><Model><BodySet><objects><Body name=\"a\"><mass>"
         << scale << "</mass><mass_center>0.1 -0.2 0.3</mass_center><inertia>";
    for (int k = 0; k < 6; ++k) text << scale * value(random) << " ";
    text << "</inertia></Body></objects></BodySet></Model></OpenSimDocument>";
    const MusculoskeletalModel model = parse_osim("m.osim", text.str());
    const SimbodyModel simbody(model);
    SimTK::State state = simbody.default_state();
    EXPECT_NO_THROW(simbody.system().realize(state, SimTK::Stage::Dynamics)) << text.str();
  }
}

TEST(SimbodyModel, SetsAndGetsCoordinatesInTheOrderOfTheDescription) {
  const MusculoskeletalModel model = random_model(3);
  const SimbodyModel simbody(model);
  SimTK::State state = simbody.default_state();
  std::mt19937 random(3);
  const std::vector<double> q = random_pose(model, random);
  std::vector<double> defaults(q.size()), back(q.size());
  simbody.get_q(state, defaults);
  for (std::size_t c = 0; c < q.size(); ++c) {
    EXPECT_EQ(defaults[c], model.coordinates[c].default_value);
  }
  simbody.set_q(state, q);
  simbody.get_q(state, back);
  EXPECT_EQ(back, q);
}

// Welds and point constraints hold where both sides meet: none in default_state(), an error apart.
TEST(SimbodyModel, MeasuresHowFarLoopsAreFromClosed) {
  MusculoskeletalModel model = random_model(4, {.coupler_count = 0, .lock_count = 0});
  const SimbodyModel open(model);
  SimTK::State state = open.default_state();
  open.system().realize(state, SimTK::Stage::Position);
  const RigidTransform X_WA =
      to_eigen(open.matter().getMobilizedBody(open.body(3)).getBodyTransform(state));
  const RigidTransform X_WB =
      to_eigen(open.matter().getMobilizedBody(open.body(8)).getBodyTransform(state));
  const RigidTransform X_AB = X_WA.inverse() * X_WB;
  const Eigen::Vector3d p_BQ(0.1, 0.2, 0.3);
  model.welds.push_back({"weld", 3, 8, X_AB, {}, {}});
  model.point_constraints.push_back({"point", 3, 8, X_AB * p_BQ, p_BQ, {}});
  const SimbodyModel closed(model, {.loops_as_constraints = true});
  SimTK::State met = closed.default_state();
  closed.system().realize(met, SimTK::Stage::Position);
  EXPECT_EQ(met.getQErr().size(), 9);
  EXPECT_LE(met.getQErr().normInf(), 1e-14);
  std::mt19937 random(4);
  closed.set_q(met, random_pose(model, random));
  closed.system().realize(met, SimTK::Stage::Position);
  EXPECT_GT(met.getQErr().normInf(), 1e-3);
}

}  // namespace
}  // namespace sinew
