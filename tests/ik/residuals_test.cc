#include "ik/residuals.h"

#include <gtest/gtest.h>

#include <numbers>

#include "ik/gradient_check.h"
#include "model/simbody_model.h"
#include "tests/ik/random_problem.h"
#include "tests/ik/small_model.h"

namespace sinew {
namespace {

using Eigen::Matrix3d;
using Eigen::Matrix3Xd;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr unsigned kSeeds = 12;
// Two sums of the same few hundred terms in different orders.
constexpr double kGradientTolerance = 1e-10;
// What extrapolated differences of costs near 1e3 leave, relative to the largest entry.
constexpr double kDifferenceTolerance = 1e-8;

Matrix3d exponential(const Vector3d& gamma) {
  const double phi = gamma.norm();
  return phi == 0.0 ? Matrix3d::Identity() : Eigen::AngleAxisd(phi, gamma / phi).toRotationMatrix();
}

double relative_difference(const VectorXd& a, const VectorXd& b) {
  return (a - b).cwiseAbs().maxCoeff() / b.cwiseAbs().maxCoeff();
}

// K_γ as eq. (16) prints it, with the sign that finite differences settle below.
Matrix3d printed_K(const Vector3d& gamma) {
  const double phi = gamma.norm();
  const Matrix3d N = skew(gamma / phi);
  return Matrix3d::Identity() + 0.5 * phi * N + (1.0 - phi / (2.0 * std::tan(0.5 * phi))) * N * N;
}

// Eqs. (12)-(16) word for word: a dense Jacobian of every residual, times its weighted residual.
class ExplicitGradient {
 public:
  ExplicitGradient(const RandomProblem& p, const KinematicWorkspace& ws)
      : p_(p), ws_(ws), g_(VectorXd::Zero(p.tree.unknown_count())) {}

  VectorXd sum() {
    for (std::size_t i = 0; i < p_.problem.positions.size(); ++i) add_position(i);
    for (std::size_t i = 0; i < p_.problem.orientations.size(); ++i) add_orientation(i);
    for (std::size_t i = 0; i < p_.problem.distances.size(); ++i) add_distance(i);
    for (const WireResidual& r : p_.problem.wires) add_wire(r);
    for (const CoincidenceResidual& r : p_.problem.coincidences) {
      const MatrixXd J = J_Bp(r.link_a, r.p_AP) - J_Bp(r.link_b, r.p_BQ);
      g_ += r.weight * J.transpose() * (place(r.link_a, r.p_AP) - place(r.link_b, r.p_BQ));
    }
    for (const AlignmentResidual& r : p_.problem.alignments) {
      const Matrix3d R = (R_WB(r.link_a) * r.R_AF) * (R_WB(r.link_b) * r.R_BG).transpose();
      const Eigen::AngleAxisd turn(R);
      const MatrixXd J = J_Bw(r.link_a) - J_Bw(r.link_b);
      g_ += r.weight * J.transpose() * (turn.angle() * turn.axis());
    }
    for (std::size_t i = 0; i < p_.problem.coordinates.size(); ++i) add_coordinate(i);
    return g_;
  }

 private:
  Vector3d place(int link, const Vector3d& p_BP) const {
    return ws_.X_WB[static_cast<std::size_t>(link)] * p_BP;
  }
  const Matrix3d& R_WB(int link) const { return ws_.X_WB[static_cast<std::size_t>(link)].R; }
  Matrix3Xd J_Bp(int link, const Vector3d& p_BP) const {
    Matrix3Xd J(3, p_.tree.unknown_count());
    station_jacobian(p_.tree, ws_, link, p_BP, J);
    return J;
  }
  Matrix3Xd J_Bw(int link) const {
    Matrix3Xd J(3, p_.tree.unknown_count());
    rotation_jacobian(p_.tree, ws_, link, J);
    return J;
  }

  void add_position(std::size_t i) {
    const PositionResidual& r = p_.problem.positions[i];
    if (!p_.targets.positions[i].allFinite()) return;
    const MatrixXd J_p = -J_Bp(r.link, r.p_BP);
    g_ += J_p.transpose() * r.weight * (p_.targets.positions[i] - place(r.link, r.p_BP));
  }

  void add_orientation(std::size_t i) {
    const OrientationResidual& r = p_.problem.orientations[i];
    if (!p_.targets.orientations[i].allFinite()) return;
    const Eigen::AngleAxisd turn(
        Matrix3d(p_.targets.orientations[i] * (R_WB(r.link) * r.R_BF).transpose()));
    const Vector3d gamma = turn.angle() * turn.axis();
    const MatrixXd J_gamma = -printed_K(gamma) * J_Bw(r.link);
    g_ += J_gamma.transpose() * r.weight * gamma;
  }

  void add_distance(std::size_t i) {
    const DistanceResidual& r = p_.problem.distances[i];
    if (std::isnan(p_.targets.distances[i])) return;
    const Vector3d pa = place(r.link_a, r.p_AP), pb = place(r.link_b, r.p_BQ);
    const double l = (pa - pb).norm(), delta = p_.targets.distances[i] - l;
    const MatrixXd J_l =
        -1.0 / l * (pa - pb).transpose() * (J_Bp(r.link_a, r.p_AP) - J_Bp(r.link_b, r.p_BQ));
    g_ += r.weight * delta * J_l.transpose();
  }

  // Eq. (38), segment by segment.
  void add_wire(const WireResidual& r) {
    std::vector<WirePoint> path;
    for (int k = 0; k < r.point_count; ++k) {
      const WirePoint& point = p_.problem.wire_points[static_cast<std::size_t>(r.first_point + k)];
      const double q =
          point.condition_q < 0 ? 0.0 : ws_.q[static_cast<std::size_t>(point.condition_q)];
      const bool off =
          point.condition_q >= 0 && (q < point.condition_min || q > point.condition_max);
      if (!off) path.push_back(point);
    }
    double l = 0.0;
    MatrixXd J_l = MatrixXd::Zero(1, p_.tree.unknown_count());
    for (std::size_t k = 1; k < path.size(); ++k) {
      const WirePoint &a = path[k - 1], &b = path[k];
      const Vector3d d = place(a.link, a.p_BP) - place(b.link, b.p_BP);
      l += d.norm();
      J_l -= d.normalized().transpose() * (J_Bp(a.link, a.p_BP) - J_Bp(b.link, b.p_BP));
    }
    g_ += r.weight * std::min(0.0, r.natural_length - l) * J_l.transpose();
  }

  void add_coordinate(std::size_t i) {
    const CoordinateResidual& r = p_.problem.coordinates[i];
    if (std::isnan(p_.targets.coordinates[i])) return;
    double slope = 1.0;
    int v = r.v;
    while (p_.tree.coupling_of_v[static_cast<std::size_t>(v)] >= 0) {
      const KinematicTree::Coupling& c = p_.tree.couplings[static_cast<std::size_t>(
          p_.tree.coupling_of_v[static_cast<std::size_t>(v)])];
      slope *= p_.tree.functions[static_cast<std::size_t>(c.function)].derivative(
          ws_.q[static_cast<std::size_t>(c.independent_q)], 1);
      v = c.independent_v;
    }
    const int x = p_.tree.unknown_of_v[static_cast<std::size_t>(v)];
    if (x < 0) return;
    const double weight = p_.targets.coordinate_scales[i] * r.weight;
    g_[x] += slope * weight * (ws_.q[static_cast<std::size_t>(r.q)] - p_.targets.coordinates[i]);
  }

  const RandomProblem& p_;
  const KinematicWorkspace& ws_;
  VectorXd g_;
};

struct GradientCase {
  ResidualKind kind;
  bool quaternions;
};

std::string name_of(const testing::TestParamInfo<GradientCase>& info) {
  static const char* const kNames[] = {"Position",   "Orientation", "Distance",  "Wire",
                                       "Coordinate", "Coincidence", "Alignment", "All"};
  return std::string(kNames[static_cast<int>(info.param.kind)]) +
         (info.param.quaternions ? "Quaternions" : "Angles");
}

std::vector<GradientCase> all_gradient_cases() {
  std::vector<GradientCase> cases;
  for (const ResidualKind kind : kResidualKinds) {
    cases.push_back({kind, false});
    cases.push_back({kind, true});
  }
  return cases;
}

class Gradient : public testing::TestWithParam<GradientCase> {
 protected:
  static RandomProblem problem(unsigned seed) {
    return only(random_problem(seed, GetParam().quaternions), GetParam().kind);
  }
};

TEST_P(Gradient, ByDecompositionIsThatOfTheExplicitJacobians) {
  for (unsigned seed = 0; seed < kSeeds; ++seed) {
    const RandomProblem p = problem(seed);
    KinematicWorkspace ws = p.workspace();
    const VectorXd expected = ExplicitGradient(p, ws).sum();
    ASSERT_GT(expected.cwiseAbs().maxCoeff(), 0.0);
    VectorXd decomposed(expected.size()), by_columns(expected.size());
    Matrix3Xd J(3, expected.size());
    const double f = decomposed_gradient(p.tree, p.problem, p.targets, ws, decomposed);
    EXPECT_LE(relative_difference(decomposed, expected), kGradientTolerance) << seed;
    EXPECT_EQ(jacobian_gradient(p.tree, p.problem, p.targets, ws, J, by_columns), f);
    EXPECT_LE(relative_difference(by_columns, expected), kGradientTolerance) << seed;
    EXPECT_EQ(cost(p.tree, p.problem, p.targets, ws), f);
  }
}

TEST_P(Gradient, IsThatOfFiniteDifferences) {
  for (unsigned seed = 0; seed < kSeeds; ++seed) {
    const RandomProblem p = problem(seed);
    const GradientCheck check = check_gradient(p.tree, p.problem, p.targets, p.q);
    EXPECT_LE(check.worst_relative(), kDifferenceTolerance)
        << "seed " << seed << ", unknown " << check.worst << ": " << check.gradient[check.worst]
        << " against " << check.quotient[check.worst];
  }
}

INSTANTIATE_TEST_SUITE_P(EveryKind, Gradient, testing::ValuesIn(all_gradient_cases()), name_of);

// The elastic forces of marker residuals as Simbody's body forces, its operator's torques by u, and
// the chain rules to rates of coordinates and through the couplers.
VectorXd gradient_by_simbody(const RandomProblem& p, const KinematicWorkspace& ws) {
  const SimbodyModel simbody(p.model);
  SimTK::State state = simbody.default_state();
  std::vector<double> q(p.model.coordinates.size());
  for (std::size_t c = 0; c < q.size(); ++c) {
    q[c] = ws.q[static_cast<std::size_t>(p.tree.q_of_coordinate[c])];
  }
  simbody.set_q(state, q);
  simbody.system().realize(state, SimTK::Stage::Position);
  SimTK::Vector_<SimTK::SpatialVec> forces(simbody.matter().getNumBodies(),
                                           SimTK::SpatialVec(SimTK::Vec3(0)));
  for (std::size_t i = 0; i < p.problem.positions.size(); ++i) {
    const PositionResidual& r = p.problem.positions[i];
    if (!p.targets.positions[i].allFinite()) continue;
    const SimTK::MobilizedBody& body = simbody.matter().getMobilizedBody(simbody.body(r.link));
    const Vector3d place = to_eigen(body.findStationLocationInGround(state, to_simtk(r.p_BP)));
    body.applyForceToBodyPoint(state, to_simtk(r.p_BP),
                               to_simtk(r.weight * (place - p.targets.positions[i])), forces);
  }
  SimTK::Vector by_u, by_rate;
  simbody.matter().multiplyBySystemJacobianTranspose(state, forces, by_u);
  simbody.matter().multiplyByNInv(state, true, by_u, by_rate);
  std::vector<double> by_v(static_cast<std::size_t>(p.tree.v_count()));
  for (int c = 0; c < simbody.coordinate_count(); ++c) {
    by_v[static_cast<std::size_t>(p.tree.v_of_coordinate[static_cast<std::size_t>(c)])] =
        by_rate[simbody.q_index(c)];
  }
  for (std::size_t i = p.tree.couplings.size(); i-- > 0;) {
    const KinematicTree::Coupling& c = p.tree.couplings[i];
    const double slope = p.tree.functions[static_cast<std::size_t>(c.function)].derivative(
        ws.q[static_cast<std::size_t>(c.independent_q)], 1);
    by_v[static_cast<std::size_t>(c.independent_v)] +=
        slope * by_v[static_cast<std::size_t>(c.dependent_v)];
  }
  VectorXd g(p.tree.unknown_count());
  for (int x = 0; x < g.size(); ++x) {
    g[x] = by_v[static_cast<std::size_t>(p.tree.unknown_v[static_cast<std::size_t>(x)])];
  }
  return g;
}

TEST(MarkerGradient, IsThatOfSimbodysJacobianOperator) {
  for (unsigned seed = 0; seed < kSeeds; ++seed) {
    const RandomProblem p = only(random_problem(seed, false), ResidualKind::kPosition);
    KinematicWorkspace ws = p.workspace();
    VectorXd g(p.tree.unknown_count());
    decomposed_gradient(p.tree, p.problem, p.targets, ws, g);
    EXPECT_LE(relative_difference(g, gradient_by_simbody(p, ws)), kGradientTolerance) << seed;
  }
}

const double kAngles[] = {0.0,
                          1e-300,
                          1e-12,
                          1e-9,
                          1e-6,
                          1e-4,
                          0.009999,
                          0.01,
                          0.010001,
                          0.3,
                          1.0,
                          2.0,
                          3.0,
                          std::numbers::pi - 1e-3,
                          std::numbers::pi - 1e-6};

TEST(RotationVector, GivesBackAngleAndAxisFromZeroToHalfATurn) {
  RandomValues values(1);
  for (const double angle : kAngles) {
    for (int i = 0; i < 20; ++i) {
      const Vector3d gamma = angle * values.vector(1.0).normalized();
      // Near φ = π the sine of φ/2 that remains is exact, and near zero so is the vector.
      EXPECT_LE((rotation_vector(exponential(gamma)) - gamma).norm(), 4e-15 + 4e-15 * angle)
          << angle;
    }
  }
}

TEST(RotationVector, IsEitherHalfTurnAtPi) {
  RandomValues values(2);
  for (int i = 0; i < 20; ++i) {
    const Vector3d axis = values.vector(1.0).normalized();
    const Vector3d gamma = rotation_vector(exponential(std::numbers::pi * axis));
    EXPECT_NEAR(gamma.norm(), std::numbers::pi, 1e-15);
    EXPECT_NEAR(std::abs(gamma.dot(axis)), std::numbers::pi, 1e-14);
  }
}

// A link that turns at ω takes ΔR = R^d Rᵀ to ΔR exp(−ωt).
TEST(RotationVectorRate, IsThatOfFiniteDifferences) {
  RandomValues values(3);
  for (const double angle : kAngles) {
    if (angle > std::numbers::pi - 1e-4) continue;  // a difference would step over the half turn
    const Vector3d gamma = angle * values.vector(1.0).normalized();
    const Matrix3d K = rotation_vector_rate(gamma);
    const double h = angle > 3.0 ? 1e-5 : 1e-4;  // truncation h²/6 of third derivatives
    for (int axis = 0; axis < 3; ++axis) {
      const Vector3d w = Vector3d::Unit(axis);
      const Matrix3d R = exponential(gamma);
      const Vector3d rate =
          (rotation_vector(R * exponential(-h * w)) - rotation_vector(R * exponential(h * w))) /
          (2.0 * h);
      EXPECT_LE((rate + K * w).norm(), 1e-8) << angle;
    }
  }
}

TEST(RotationVectorRate, HasThePositiveLinearTerm) {
  const Vector3d gamma(0.4, -0.7, 0.2);
  EXPECT_LE((rotation_vector_rate(gamma) - printed_K(gamma)).norm(), 1e-15);
  // The other sign, K(−γ), differs by φ[n×].
  EXPECT_NEAR((rotation_vector_rate(-gamma) - printed_K(gamma)).norm(), skew(gamma).norm(), 1e-15);
}

TEST(RotationVectorRate, LeavesTheVectorItselfAlone) {
  RandomValues values(4);
  for (const double angle : kAngles) {  // K_γᵀ Δγ = Δγ
    const Vector3d gamma = angle * values.vector(1.0).normalized();
    EXPECT_LE((rotation_vector_rate(gamma).transpose() * gamma - gamma).norm(), 1e-14) << angle;
  }
}

TEST(RotationVectorRate, JoinsItsSeriesToItsFormula) {
  const Vector3d axis = Vector3d(1.0, 2.0, -2.0) / 3.0;
  const Matrix3d below = rotation_vector_rate(std::nextafter(0.01, 0.0) * axis);
  const Matrix3d above = rotation_vector_rate(std::nextafter(0.01, 1.0) * axis);
  EXPECT_LE((below - above).norm(), 1e-15);
}

// One ball joint and one frame: what a single orientation residual pulls at.
RandomProblem one_frame(const Vector3d& gamma) {
  RandomProblem p;
  p.model = empty_model();
  add_body(p.model, 0, Joint::Kind::kBall, "rrr");
  p.tree = compile_tree(p.model, {.quaternions = true});
  p.q = p.tree.default_q;
  p.problem.orientations = {{1, Matrix3d::Identity(), RandomValues(5).weight()}};
  p.targets.orientations = {exponential(gamma)};
  return p;
}

TEST(OrientationGradient, IsRightFromZeroToHalfATurn) {
  RandomValues values(6);
  for (const double angle : kAngles) {
    const Vector3d gamma = angle * values.vector(1.0).normalized();
    const RandomProblem p = one_frame(gamma);
    KinematicWorkspace ws = p.workspace();
    VectorXd g(3);
    const double f = decomposed_gradient(p.tree, p.problem, p.targets, ws, g);
    const Matrix3d& W = p.problem.orientations[0].weight;
    EXPECT_NEAR(f, 0.5 * gamma.dot(W * gamma), 1e-14 + 1e-13 * f) << angle;
    const Vector3d expected =
        angle < 1e-5 ? Vector3d(-W * gamma) : Vector3d(-printed_K(gamma).transpose() * W * gamma);
    // Below 1e-5 the terms left out are of order φ², 1e-5 of the first.
    EXPECT_LE((g - expected).norm(), 1e-15 + (angle < 1e-5 ? 1e-5 : 1e-11) * angle) << angle;
  }
}

TEST(OrientationGradient, IsFiniteAtHalfATurn) {
  const RandomProblem p = one_frame(std::numbers::pi * Vector3d(2, -1, 2) / 3.0);
  KinematicWorkspace ws = p.workspace();
  VectorXd g(3);
  const double f = decomposed_gradient(p.tree, p.problem, p.targets, ws, g);
  EXPECT_GT(f, 0.0);
  EXPECT_TRUE(g.allFinite());
  EXPECT_GT(g.norm(), 1.0);
}

// Two points on the x axis, link 1 sliding along it from 1 m.
RandomProblem slider() {
  RandomProblem p;
  p.model = empty_model();
  add_body(p.model, 0, Joint::Kind::kSlider, "t");
  p.model.coordinates[0].default_value = 1.0;
  p.tree = compile_tree(p.model);
  p.q = p.tree.default_q;
  return p;
}

RandomProblem one_distance(double length) {
  RandomProblem p = slider();
  p.problem.distances = {{0, 1, Vector3d::Zero(), Vector3d::Zero(), 4.0}};
  p.targets.distances = {length};
  return p;
}

RandomProblem one_wire(double natural_length) {
  RandomProblem p = slider();
  p.problem.wire_points = {{0, Vector3d::Zero()}, {1, Vector3d::Zero()}};
  p.problem.wires = {{0, 2, natural_length, 4.0}};
  return p;
}

TEST(Distance, PullsAndPushesButAWireOnlyPulls) {
  const struct {
    RandomProblem problem;
    double f, g;
  } cases[] = {{one_distance(0.75), 0.125, 1.0}, {one_distance(1.25), 0.125, -1.0},
               {one_distance(1.0), 0.0, 0.0},    {one_wire(0.75), 0.125, 1.0},
               {one_wire(1.25), 0.0, 0.0},       {one_wire(1.0), 0.0, 0.0},
               {one_distance(kNaN), 0.0, 0.0}};
  for (const auto& c : cases) {
    KinematicWorkspace ws = c.problem.workspace();
    VectorXd g(1);
    EXPECT_EQ(decomposed_gradient(c.problem.tree, c.problem.problem, c.problem.targets, ws, g),
              c.f);
    EXPECT_EQ(g[0], c.g);
  }
}

// From the world's origin over a pulley 3 m up to a slider 4 m along the floor: a right triangle.
TEST(Wire, RunsOverItsViaPoints) {
  RandomProblem p = slider();
  p.q = {4.0};
  p.problem.wire_points = {{0, Vector3d::Zero()}, {0, Vector3d(0, 3, 0)}, {1, Vector3d::Zero()}};
  p.problem.wires = {{0, 3, 7.0, 2.0}};
  KinematicWorkspace ws = p.workspace();
  VectorXd g(1);
  EXPECT_DOUBLE_EQ(wire_length(p.problem, p.problem.wires[0], ws), 8.0);
  EXPECT_DOUBLE_EQ(decomposed_gradient(p.tree, p.problem, p.targets, ws, g), 1.0);
  EXPECT_DOUBLE_EQ(g[0], 2.0 * 4.0 / 5.0);
  // Off the path below 5 m, the wire goes straight and is slack.
  p.problem.wire_points[1].condition_q = 0;
  p.problem.wire_points[1].condition_min = 5.0;
  p.problem.wire_points[1].condition_max = 6.0;
  EXPECT_DOUBLE_EQ(wire_length(p.problem, p.problem.wires[0], ws), 4.0);
  EXPECT_EQ(decomposed_gradient(p.tree, p.problem, p.targets, ws, g), 0.0);
}

TEST(Wire, HasNoDirectionBetweenCoincidentPoints) {
  RandomProblem p = one_wire(0.0);
  p.q = {0.0};
  KinematicWorkspace ws = p.workspace();
  VectorXd g(1);
  EXPECT_EQ(decomposed_gradient(p.tree, p.problem, p.targets, ws, g), 0.0);
  EXPECT_EQ(g[0], 0.0);
}

TEST(Distance, HasNoDirectionBetweenCoincidentPoints) {
  RandomProblem p = one_distance(0.5);
  p.q = {0.0};
  KinematicWorkspace ws = p.workspace();
  VectorXd g(1);
  EXPECT_EQ(decomposed_gradient(p.tree, p.problem, p.targets, ws, g), 0.5);
  EXPECT_EQ(g[0], 0.0);
}

TEST(MissingTargets, LeaveCostAndGradientAsIfTheirResidualsWereNotThere) {
  RandomProblem p = random_problem(7, false);
  p.problem.wires.clear();
  p.problem.coincidences.clear();
  p.problem.alignments.clear();
  p.targets = IkTargets(p.problem);
  KinematicWorkspace ws = p.workspace();
  VectorXd g(p.tree.unknown_count());
  EXPECT_EQ(decomposed_gradient(p.tree, p.problem, p.targets, ws, g), 0.0);
  EXPECT_EQ(g, VectorXd::Zero(g.size()));
}

std::string error_of(const RandomProblem& p) {
  try {
    validate(p.tree, p.problem, p.targets);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "no error";
}

TEST(Validate, NamesTheResidualThatIsWrong) {
  const RandomProblem good = random_problem(0, false);
  RandomProblem p = good;
  p.problem.positions[2].link = 25;
  EXPECT_EQ(error_of(p), "position residual 2 is on link 25; expected 0 to 24");
  p = good;
  p.problem.orientations[1].weight(0, 1) += 0.1;
  EXPECT_EQ(error_of(p),
            "orientation residual 1 has an unusable weight; expected a symmetric matrix without "
            "negative eigenvalues");
  p = good;
  p.problem.distances[3].weight = -1.0;
  EXPECT_EQ(error_of(p), "distance residual 3 has weight -1; expected a finite number, 0 or more");
  p = good;
  p.problem.wires[2].natural_length = -0.5;
  EXPECT_EQ(error_of(p),
            "wire residual 2 has natural length -0.5; expected a finite number, 0 or more");
  p = good;
  p.problem.wires[23].point_count = 40;
  const auto points = static_cast<int>(p.problem.wire_points.size());
  const int first = p.problem.wires[23].first_point;
  EXPECT_EQ(error_of(p), "wire residual 23 has points " + std::to_string(first) + " to " +
                             std::to_string(first + 39) + " of " + std::to_string(points) +
                             "; expected two or more of them");
  p = good;
  p.problem.wire_points[0].link = 99;
  EXPECT_EQ(error_of(p), "wire residual 0 is on link 99; expected 0 to 24");
  p = good;
  p.problem.wire_points[0].condition_q = 1;
  EXPECT_EQ(error_of(p),
            "wire residual 0 has a condition on its first or last point; expected it in between");
  p = good;
  p.problem.coincidences[4].link_b = -1;
  EXPECT_EQ(error_of(p), "coincidence residual 4 is on link -1; expected 0 to 24");
  p = good;
  p.problem.alignments[0].weight = kNaN;
  EXPECT_EQ(error_of(p),
            "alignment residual 0 has weight nan; expected a finite number, 0 or more");
  p = good;
  p.problem.coordinates[0].v = p.tree.v_count();
  EXPECT_EQ(error_of(p), "coordinate residual 0 is on coordinate " +
                             std::to_string(p.problem.coordinates[0].q) + " with direction " +
                             std::to_string(p.tree.v_count()) + "; expected one of the tree's own");
  p = good;
  p.targets.distances.pop_back();
  EXPECT_EQ(error_of(p), "24 distance residuals have 23 targets; expected as many");
}

}  // namespace
}  // namespace sinew
