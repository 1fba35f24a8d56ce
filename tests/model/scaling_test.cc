#include "model/scaling.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "model/kinematic_tree.h"
#include "model/osim_file.h"
#include "model/whole_body.h"
#include "tests/data/test_files.h"
#include "tests/model/random_model.h"
#include "tests/model/same_model.h"
#include "tests/model/shared_models.h"

namespace sinew {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

ScaleFactors random_factors(const MusculoskeletalModel& model, unsigned seed) {
  ScaleFactors factors(model);
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> value(0.8, 1.25);
  for (std::size_t b = 1; b < factors.of_body.size(); ++b) {
    for (double& f : factors.of_body[b]) f = value(random);
  }
  return factors;
}

ScaleFactors uniform_factors(const MusculoskeletalModel& model, double f) {
  ScaleFactors factors(model);
  for (std::size_t b = 1; b < factors.of_body.size(); ++b) factors.of_body[b].setConstant(f);
  return factors;
}

TEST(ScaleInertia, GrowsWithTheFifthPowerOfAUniformFactor) {
  Matrix3d I;
  I << 0.3, 0.01, -0.02, 0.01, 0.2, 0.03, -0.02, 0.03, 0.4;
  const BodyInertia scaled = scale_inertia({5.0, I}, Vector3d::Constant(1.1), true);
  EXPECT_NEAR(scaled.mass, 5.0 * std::pow(1.1, 3), 1e-14);
  EXPECT_LT((scaled.I_BCm - I * std::pow(1.1, 5)).norm(), 1e-15);
  const BodyInertia same_mass = scale_inertia({5.0, I}, Vector3d::Constant(1.1), false);
  EXPECT_EQ(same_mass.mass, 5.0);
  EXPECT_LT((same_mass.I_BCm - I * std::pow(1.1, 2)).norm(), 1e-15);
}

TEST(ScaleInertia, OfACylinderIsThatOfTheScaledCylinder) {
  const double m = 3.0, r = 0.07, l = 0.4;
  for (int axis = 0; axis < 3; ++axis) {
    Vector3d moments = Vector3d::Constant(m * (l * l / 12.0 + r * r / 4.0));
    moments[axis] = m * r * r / 2.0;
    // The same factor across the axis keeps the section a circle.
    Vector3d f = Vector3d::Constant(1.3);
    f[axis] = 0.8;
    const double m2 = m * 1.3 * 1.3 * 0.8, r2 = 1.3 * r, l2 = 0.8 * l;
    Vector3d expected = Vector3d::Constant(m2 * (l2 * l2 / 12.0 + r2 * r2 / 4.0));
    expected[axis] = m2 * r2 * r2 / 2.0;
    const BodyInertia scaled = scale_inertia({m, moments.asDiagonal()}, f, true);
    EXPECT_NEAR(scaled.mass, m2, 1e-14);
    EXPECT_LT((scaled.I_BCm.diagonal() - expected).norm(), 1e-14) << axis;
  }
}

TEST(ScaleInertia, OfABodyWithoutMassIsNone) {
  EXPECT_EQ(scale_inertia({0.0, Matrix3d::Identity()}, Vector3d(1, 2, 3), true).I_BCm,
            Matrix3d::Zero());
}

// Everything grows by the same factor: so do all distances, at every pose.
TEST(ScaleModel, UniformlyMakesASimilarModel) {
  const MusculoskeletalModel model = whole_body({.level = WholeBodyOptions::Level::kSimplified});
  const double f = 1.2;
  const MusculoskeletalModel scaled = scale_model(model, uniform_factors(model, f));
  EXPECT_NEAR(scaled.total_mass(), model.total_mass() * f * f * f, 1e-10);
  const KinematicTree tree = compile_tree(model), scaled_tree = compile_tree(scaled);
  KinematicWorkspace a(tree), b(scaled_tree);
  std::mt19937 random(3);
  const std::vector<double> q = random_pose(model, random);
  for (std::size_t c = 0; c < q.size(); ++c) {
    const bool shift = model.coordinates[c].motion == Coordinate::Motion::kTranslational;
    a.q[static_cast<std::size_t>(tree.q_of_coordinate[c])] = q[c];
    b.q[static_cast<std::size_t>(scaled_tree.q_of_coordinate[c])] = shift ? f * q[c] : q[c];
  }
  update_poses(tree, a);
  update_poses(scaled_tree, b);
  for (std::size_t m = 0; m < model.markers.size(); ++m) {
    const auto body = static_cast<std::size_t>(model.markers[m].body);
    EXPECT_LT(
        (f * (a.X_WB[body] * model.markers[m].p_BM) - b.X_WB[body] * scaled.markers[m].p_BM).norm(),
        1e-12)
        << model.markers[m].name;
  }
  for (std::size_t i = 0; i < model.paths.size(); ++i) {
    EXPECT_NEAR(scaled.paths[i].natural_length, f * model.paths[i].natural_length,
                1e-12 * model.paths[i].natural_length)
        << model.paths[i].name;
  }
}

TEST(ScaleModel, GivesTheSubjectsMass) {
  const MusculoskeletalModel model = whole_body();
  for (const bool preserve : {false, true}) {
    const MusculoskeletalModel scaled =
        scale_model(model, random_factors(model, 4), {61.5, preserve});
    EXPECT_NEAR(scaled.total_mass(), 61.5, 1e-12);
    if (!preserve) continue;
    for (std::size_t b = 1; b < model.bodies.size(); ++b) {
      EXPECT_NEAR(scaled.bodies[b].mass, model.bodies[b].mass * 61.5 / model.total_mass(), 1e-13);
    }
  }
}

TEST(ScaleModel, ByTheInverseGoesBack) {
  const MusculoskeletalModel model = whole_body();
  const ScaleFactors factors = random_factors(model, 5);
  ScaleFactors inverse = factors;
  for (Vector3d& f : inverse.of_body) f = f.cwiseInverse();
  const MusculoskeletalModel back =
      scale_model(scale_model(model, factors), inverse, {model.total_mass(), false});
  for (std::size_t i = 0; i < model.paths.size(); ++i) {
    EXPECT_NEAR(back.paths[i].natural_length, model.paths[i].natural_length, 1e-12);
  }
  for (std::size_t b = 1; b < model.bodies.size(); ++b) {
    EXPECT_NEAR(back.bodies[b].mass, model.bodies[b].mass, 1e-12);
    EXPECT_LT((back.bodies[b].p_BCm - model.bodies[b].p_BCm).norm(), 1e-15);
    EXPECT_LT((back.joints[b - 1].X_PF.p - model.joints[b - 1].X_PF.p).norm(), 1e-15);
  }
}

// What auto_scale() relies on: at a pose, p(f + 2d) − p(f) = 2 (p(f + d) − p(f)).
TEST(ScaleGeometry, IsLinearInTheFactors) {
  SINEW_SKIP_WITHOUT_SHARED_DATA();
  for (const char* file : {"nimblephysics/Arnold2013Synthetic/unscaled_generic.osim",
                           "opensim-core/OpenSim/Tests/Wrapping/"
                           "testGeometryPathWrapping_ShoulderWrappingWithPathSprings.osim"}) {
    const MusculoskeletalModel model = read_osim(kSharedData / file);
    std::mt19937 random(6);
    const std::vector<double> q = random_pose(model, random);
    const ScaleFactors f = random_factors(model, 7), d = random_factors(model, 8);
    const auto places = [&](double step) {
      ScaleFactors factors = f;
      for (std::size_t b = 1; b < f.of_body.size(); ++b) factors.of_body[b] += step * d.of_body[b];
      const MusculoskeletalModel scaled = scale_geometry(model, factors);
      const KinematicTree tree = compile_tree(scaled);
      KinematicWorkspace ws(tree);
      for (std::size_t c = 0; c < q.size(); ++c) {
        ws.q[static_cast<std::size_t>(tree.q_of_coordinate[c])] = q[c];
      }
      update_poses(tree, ws);
      Eigen::Matrix3Xd p(3, scaled.markers.size());
      for (std::size_t m = 0; m < scaled.markers.size(); ++m) {
        p.col(static_cast<Eigen::Index>(m)) =
            ws.X_WB[static_cast<std::size_t>(scaled.markers[m].body)] * scaled.markers[m].p_BM;
      }
      return p;
    };
    const Eigen::Matrix3Xd p0 = places(0.0), p1 = places(1.0), p2 = places(2.0);
    EXPECT_GT((p1 - p0).norm(), 0.1);
    EXPECT_LT((p2 - 2.0 * p1 + p0).cwiseAbs().maxCoeff(), 1e-13) << file;
  }
}

template <typename Action>
std::string refusal(Action action) {
  try {
    action();
  } catch (const std::invalid_argument& error) {
    return error.what();
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(ScaleModel, RefusesWhatIsNoScaling) {
  MusculoskeletalModel model = whole_body({.level = WholeBodyOptions::Level::kSimplified});
  ScaleFactors factors(model);
  factors.of_body[2][1] = -1.0;
  EXPECT_EQ(refusal([&] { scale_model(model, factors); }),
            "scale factors of body '" + model.bodies[2].name +
                "' are 1 -1 1; expected finite numbers above 0");
  factors.of_body.pop_back();
  EXPECT_EQ(refusal([&] { scale_model(model, factors); }),
            "scale factors of " + std::to_string(factors.of_body.size()) +
                " bodies for a model of " + std::to_string(model.bodies.size()));
  EXPECT_EQ(refusal([&] {
              scale_model(model, ScaleFactors(model), {-1.0, false});
            }),
            "ScaleOptions.mass is -1; expected more than 0 kg");
  for (Body& body : model.bodies) body.mass = 0.0;
  EXPECT_EQ(refusal([&] {
              scale_model(model, ScaleFactors(model), {70.0, false});
            }),
            model.name +
                ": no body of the model has mass; expected bodies with mass, to be scaled to the "
                "subject. Leave the subject's mass out, or give the bodies mass.");
}

}  // namespace
}  // namespace sinew
