#include "model/kinematic_tree.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <random>

#include "model/osim_file.h"
#include "model/simbody_model.h"
#include "tests/model/random_model.h"
#include "tests/model/shared_models.h"

namespace sinew {
namespace {

using Eigen::Matrix3Xd;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

// Rounding of chains of some 20 products of numbers near 1.
constexpr double kPoseTolerance = 1e-12;
constexpr double kJacobianTolerance = 1e-12;
constexpr double kTorqueTolerance = 1e-12;  // relative to the largest torque
// Central differences: third derivatives times step² / 6, and rounding over step.
constexpr double kDifferenceStep = 5e-6;
constexpr double kDifferenceTolerance = 2e-9;

constexpr unsigned kSeeds = 20;

template <typename Action>
std::string error_of(Action action) {
  try {
    action();
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

bool is_ellipsoid(const MusculoskeletalModel& model, int coordinate) {
  const int joint = model.coordinates[static_cast<std::size_t>(coordinate)].joint;
  return model.joints[static_cast<std::size_t>(joint)].kind == Joint::Kind::kEllipsoid;
}

// A model in both compiled forms, at one pose.
class Pair {
 public:
  explicit Pair(const MusculoskeletalModel& model, const KinematicTree::Options& options = {})
      : model(model),
        tree(compile_tree(model, options)),
        workspace(tree),
        simbody(model),
        state(simbody.default_state()) {}

  // Poses both at q, given by coordinate; dependent coordinates follow by the tree.
  void pose(const std::vector<double>& q) {
    for (std::size_t c = 0; c < q.size(); ++c) {
      if (tree.q_of_coordinate[c] >= 0) {
        workspace.q[static_cast<std::size_t>(tree.q_of_coordinate[c])] = q[c];
      }
    }
    update_kinematics(tree, workspace);
    std::vector<double> full(q.size());
    for (std::size_t c = 0; c < q.size(); ++c) {
      const int i = tree.q_of_coordinate[c];
      full[c] = i >= 0 ? workspace.q[static_cast<std::size_t>(i)] : q[c];
    }
    simbody.set_q(state, full);
    simbody.system().realize(state, SimTK::Stage::Position);
  }

  RigidTransform simbody_pose(int body) const {
    return to_eigen(simbody.matter().getMobilizedBody(simbody.body(body)).getBodyTransform(state));
  }

  // Frame Jacobian of Simbody, by its speeds u: rows [angular; linear].
  MatrixXd simbody_jacobian_u(int body, const Vector3d& p_BQ) const {
    SimTK::RowVector_<SimTK::SpatialVec> J;
    simbody.matter().calcFrameJacobian(state, simbody.body(body), to_simtk(p_BQ), J);
    MatrixXd result(6, J.size());
    for (int i = 0; i < J.size(); ++i) {
      result.col(i) << to_eigen(J[i][0]), to_eigen(J[i][1]);
    }
    return result;
  }

  // A covector by speeds u → by rates of coordinates q̇.
  VectorXd by_coordinate(const VectorXd& by_u) const {
    SimTK::Vector in(static_cast<int>(by_u.size())), out;
    for (int i = 0; i < in.size(); ++i) in[i] = by_u[i];
    simbody.matter().multiplyByNInv(state, true, in, out);
    VectorXd result(simbody.coordinate_count());
    for (int c = 0; c < simbody.coordinate_count(); ++c) result[c] = out[simbody.q_index(c)];
    return result;
  }

  // The chain rule through couplers: a covector by coordinate, each taken as independent → by the
  // tree's unknowns.
  VectorXd by_unknown(const VectorXd& by_coordinate) const {
    VectorXd result = VectorXd::Zero(tree.unknown_count());
    for (int c = 0; c < by_coordinate.size(); ++c) {
      double scale = 1.0;
      const int source = follow_couplers(c, scale);
      const int x = tree.unknown_of_v[static_cast<std::size_t>(
          tree.v_of_coordinate[static_cast<std::size_t>(source)])];
      if (x >= 0) result[x] += scale * by_coordinate[c];
    }
    return result;
  }

  int follow_couplers(int c, double& slope) const {
    for (bool found = true; found;) {
      found = false;
      for (const CoordinateCoupler& coupler : model.couplers) {
        if (coupler.dependent != c) continue;
        c = coupler.independent;
        slope *= CompiledFunction(coupler.function).derivative(coordinate(c), 1);
        found = true;
        break;
      }
    }
    return c;
  }

  double coordinate(int c) const {
    return workspace.q[static_cast<std::size_t>(tree.q_of_coordinate[static_cast<std::size_t>(c)])];
  }

  const MusculoskeletalModel model;
  const KinematicTree tree;
  KinematicWorkspace workspace;
  const SimbodyModel simbody;
  SimTK::State state;
};

double distance(const RigidTransform& a, const RigidTransform& b) {
  return std::max((a.R - b.R).cwiseAbs().maxCoeff(), (a.p - b.p).cwiseAbs().maxCoeff());
}

// Grows to the largest difference seen; NaN counts as infinite.
struct Worst {
  double value = 0.0;
  void add(double difference) {
    value = difference <= value
                ? value
                : (std::isnan(difference) ? std::numeric_limits<double>::infinity() : difference);
  }
};

double worst_pose(const Pair& pair) {
  Worst worst;
  for (int b = 0; b < pair.tree.link_count(); ++b) {
    worst.add(distance(pair.workspace.X_WB[static_cast<std::size_t>(b)], pair.simbody_pose(b)));
  }
  return worst.value;
}

double worst_jacobian(const Pair& pair, std::mt19937& random) {
  std::uniform_real_distribution<double> place(-0.3, 0.3);
  Worst worst;
  Matrix3Xd J_v(3, pair.tree.unknown_count()), J_w(3, pair.tree.unknown_count());
  for (int b = 0; b < pair.tree.link_count(); ++b) {
    const Vector3d p_BQ(place(random), place(random), place(random));
    station_jacobian(pair.tree, pair.workspace, b, p_BQ, J_v);
    rotation_jacobian(pair.tree, pair.workspace, b, J_w);
    const MatrixXd J_u = pair.simbody_jacobian_u(b, p_BQ);
    for (int row = 0; row < 3; ++row) {
      const VectorXd w = pair.by_unknown(pair.by_coordinate(J_u.row(row)));
      const VectorXd v = pair.by_unknown(pair.by_coordinate(J_u.row(row + 3)));
      worst.add((J_w.row(row).transpose() - w).cwiseAbs().sum());
      worst.add((J_v.row(row).transpose() - v).cwiseAbs().sum());
    }
  }
  return worst.value;
}

// |tree's g − Simbody's| of random wrenches on all links, relative to the largest torque.
double worst_torque(Pair& pair, std::mt19937& random) {
  std::uniform_real_distribution<double> value(-1.0, 1.0);
  SimTK::Vector_<SimTK::SpatialVec> F(pair.simbody.matter().getNumBodies(),
                                      SimTK::SpatialVec(SimTK::Vec3(0)));
  for (int b = 1; b < pair.tree.link_count(); ++b) {
    Vector6d& wrench = pair.workspace.F[static_cast<std::size_t>(b)];
    for (int i = 0; i < 6; ++i) wrench[i] = value(random);
    F[pair.simbody.body(b)] =
        SimTK::SpatialVec(to_simtk(wrench.head<3>()), to_simtk(wrench.tail<3>()));
  }
  joint_torques(pair.tree, pair.workspace);
  fold_couplings(pair.tree, pair.workspace);
  SimTK::Vector f;
  pair.simbody.matter().multiplyBySystemJacobianTranspose(pair.state, F, f);
  const VectorXd expected =
      pair.by_unknown(pair.by_coordinate(Eigen::Map<const VectorXd>(&f[0], f.size())));
  VectorXd found(pair.tree.unknown_count());
  for (int x = 0; x < found.size(); ++x) {
    found[x] = pair.workspace
                   .g[static_cast<std::size_t>(pair.tree.unknown_v[static_cast<std::size_t>(x)])];
  }
  return (found - expected).cwiseAbs().maxCoeff() / expected.cwiseAbs().maxCoeff();
}

double largest_distance(const Pair& pair) {
  double largest = 0.0;
  for (const RigidTransform& X_WB : pair.workspace.X_WB) largest = std::max(largest, X_WB.p.norm());
  return largest;
}

// How far the tree's coordinates are from satisfying the couplers as Simbody's own constraints.
double worst_coupler(const MusculoskeletalModel& model, unsigned seed) {
  Pair pair(model);
  std::mt19937 random(seed);
  pair.pose(random_pose(model, random));
  const SimbodyModel constrained(model, {.couplers_as_constraints = true});
  std::vector<double> q(model.coordinates.size());
  for (std::size_t c = 0; c < q.size(); ++c) q[c] = pair.coordinate(static_cast<int>(c));
  SimTK::State state = constrained.default_state();
  constrained.set_q(state, q);
  constrained.system().realize(state, SimTK::Stage::Position);
  const SimTK::Vector errors = state.getQErr();
  EXPECT_EQ(errors.size(), static_cast<int>(model.couplers.size()));
  Worst worst;
  for (int i = 0; i < errors.size(); ++i) worst.add(std::abs(errors[i]));
  return worst.value;
}

// |station Jacobian − quotient of differences| over all links, each unknown stepped by advance().
double worst_difference_quotient(const Pair& pair, double h) {
  const KinematicTree& tree = pair.tree;
  const Vector3d p_BQ(0.2, -0.1, 0.3);
  std::vector<Matrix3Xd> J(tree.links.size(), Matrix3Xd(3, tree.unknown_count()));
  for (int b = 0; b < tree.link_count(); ++b) {
    station_jacobian(tree, pair.workspace, b, p_BQ, J[static_cast<std::size_t>(b)]);
  }
  KinematicWorkspace ahead(tree), behind(tree);
  std::vector<double> step(static_cast<std::size_t>(tree.unknown_count()), 0.0);
  Worst worst;
  for (int x = 0; x < tree.unknown_count(); ++x) {
    double& step_x = step[static_cast<std::size_t>(x)];
    step_x = h;
    advance(tree, pair.workspace.q, step, ahead.q);
    step_x = -h;
    advance(tree, pair.workspace.q, step, behind.q);
    step_x = 0.0;
    update_poses(tree, ahead);
    update_poses(tree, behind);
    for (std::size_t b = 0; b < tree.links.size(); ++b) {
      const Vector3d quotient = (ahead.X_WB[b] * p_BQ - behind.X_WB[b] * p_BQ) / (2.0 * h);
      worst.add((J[b].col(x) - quotient).norm() / std::max(1.0, quotient.norm()));
    }
  }
  return worst.value;
}

TEST(KinematicTree, PosesAllBodiesAsSimbody) {
  Worst worst;
  for (unsigned seed = 0; seed < kSeeds; ++seed) {
    Pair pair(random_model(seed));
    std::mt19937 random(seed);
    for (int pose = 0; pose < 5; ++pose) {
      pair.pose(random_pose(pair.model, random));
      worst.add(worst_pose(pair));
    }
  }
  EXPECT_LE(worst.value, kPoseTolerance);
}

TEST(KinematicTree, HasTheJacobiansOfSimbodyByTheChainRule) {
  Worst worst;
  for (unsigned seed = 0; seed < kSeeds; ++seed) {
    Pair pair(random_model(seed));
    std::mt19937 random(seed);
    pair.pose(random_pose(pair.model, random));
    worst.add(worst_jacobian(pair, random));
  }
  EXPECT_LE(worst.value, kJacobianTolerance);
}

TEST(KinematicTree, HasTheJointTorquesOfSimbodyByTheChainRule) {
  Worst worst;
  for (unsigned seed = 0; seed < kSeeds; ++seed) {
    for (const bool ignore_locks : {false, true}) {
      Pair pair(random_model(seed), {.ignore_locks = ignore_locks});
      std::mt19937 random(seed);
      pair.pose(random_pose(pair.model, random));
      worst.add(worst_torque(pair, random));
    }
  }
  EXPECT_LE(worst.value, kTorqueTolerance);
}

TEST(KinematicTree, HasTheJacobianOfItsOwnPoses) {
  Worst worst;
  for (unsigned seed = 0; seed < kSeeds; ++seed) {
    Pair pair(random_model(seed));
    std::mt19937 random(seed);
    pair.pose(random_pose(pair.model, random));
    worst.add(worst_difference_quotient(pair, kDifferenceStep));
  }
  EXPECT_LE(worst.value, kDifferenceTolerance);
}

TEST(PublishedModels, HaveThePosesJacobiansAndTorquesOfSimbody) {
  SINEW_SKIP_WITHOUT_SHARED_DATA();
  for (const auto& path : shared_models()) {
    if (has_no_bodies(path)) continue;
    SCOPED_TRACE(path);
    Pair pair(read_osim(path));
    std::mt19937 random(1);
    pair.pose(random_pose(pair.model, random));
    // Couplers can put bodies tens of metres away at angles outside their splines.
    const double size = std::max(1.0, largest_distance(pair));
    EXPECT_LE(worst_pose(pair), kPoseTolerance * size);
    EXPECT_LE(worst_jacobian(pair, random), kJacobianTolerance * size);
    if (pair.tree.unknown_count() > 0) {
      EXPECT_LE(worst_torque(pair, random), kTorqueTolerance);
    }
  }
}

TEST(PublishedModels, KeepTheirCouplersInSimbodyToo) {
  SINEW_SKIP_WITHOUT_SHARED_DATA();
  int with_couplers = 0;
  for (const auto& path : shared_models()) {
    if (has_no_bodies(path)) continue;
    SCOPED_TRACE(path);
    const MusculoskeletalModel model = read_osim(path);
    if (model.couplers.empty()) continue;
    ++with_couplers;
    EXPECT_LE(worst_coupler(model, 1), kPoseTolerance);
  }
  EXPECT_GE(with_couplers, 10);
}

TEST(KinematicTree, KeepsCouplersInSimbodyToo) {
  Worst worst;
  for (unsigned seed = 0; seed < kSeeds; ++seed) {
    worst.add(worst_coupler(random_model(seed, {.coupler_count = 12}), seed));
  }
  EXPECT_LE(worst.value, kPoseTolerance);
}

TEST(KinematicTree, UpdatesPosesAloneToTheSameBits) {
  Pair pair(random_model(1));
  std::mt19937 random(1);
  pair.pose(random_pose(pair.model, random));
  KinematicWorkspace poses(pair.tree);
  poses.q = pair.workspace.q;
  update_poses(pair.tree, poses);
  EXPECT_EQ(poses.X_WB, pair.workspace.X_WB);
}

bool is_quaternion(const KinematicTree::Link& link) {
  return link.kind == KinematicTree::Kind::kBall || link.kind == KinematicTree::Kind::kFree;
}

// Poses a tree of the same model, with its ball and free joints as quaternions, like `pair` at q.
void pose_quaternions(const Pair& pair, const std::vector<double>& q, const KinematicTree& tree,
                      KinematicWorkspace& workspace) {
  for (std::size_t c = 0; c < q.size(); ++c) {
    const int i = tree.q_of_coordinate[c];
    if (i >= 0) workspace.q[static_cast<std::size_t>(i)] = q[c];
  }
  for (std::size_t b = 1; b < tree.links.size(); ++b) {
    if (!is_quaternion(tree.links[b])) continue;
    const auto first = static_cast<std::size_t>(pair.model.joints[b - 1].coordinates[0]);
    const Eigen::Quaterniond R(rotation_from_body_xyz({q[first], q[first + 1], q[first + 2]}));
    const double values[] = {R.w(), R.x(), R.y(), R.z()};
    std::copy(values, values + 4, workspace.q.begin() + tree.links[b].first_q);
  }
  update_kinematics(tree, workspace);
}

// Without couplers and locks, the columns of the quaternion tree and Simbody's speeds u are one to
// one; an ellipsoid's are angles here and angular velocities there.
double worst_column(const Pair& pair, const KinematicTree& tree,
                    const KinematicWorkspace& workspace, int link) {
  const Vector3d p_BQ(0.1, -0.2, 0.3);
  const MatrixXd J_u = pair.simbody_jacobian_u(link, p_BQ);
  Matrix3Xd J(3, tree.unknown_count());
  station_jacobian(tree, workspace, link, p_BQ, J);
  Worst worst;
  for (int c = 0; c < pair.simbody.coordinate_count(); ++c) {
    if (is_ellipsoid(pair.model, c)) continue;
    const int x = tree.unknown_of_v[static_cast<std::size_t>(
        tree.v_of_coordinate[static_cast<std::size_t>(c)])];
    worst.add((J.col(x) - J_u.col(pair.simbody.u_index(c)).tail<3>()).norm());
  }
  return worst.value;
}

TEST(QuaternionTree, HasThePosesAndJacobiansOfSimbodysSpeeds) {
  Worst pose, jacobian;
  for (unsigned seed = 0; seed < kSeeds; ++seed) {
    Pair pair(random_model(seed, {.coupler_count = 0, .lock_count = 0, .for_quaternions = true}));
    std::mt19937 random(seed);
    const std::vector<double> q = random_pose(pair.model, random);
    pair.pose(q);
    const KinematicTree tree = compile_tree(pair.model, {.quaternions = true});
    KinematicWorkspace workspace(tree);
    pose_quaternions(pair, q, tree, workspace);
    for (int b = 0; b < tree.link_count(); ++b) {
      pose.add(distance(workspace.X_WB[static_cast<std::size_t>(b)], pair.simbody_pose(b)));
      jacobian.add(worst_column(pair, tree, workspace, b));
    }
  }
  EXPECT_LE(pose.value, kPoseTolerance);
  EXPECT_LE(jacobian.value, kJacobianTolerance);
}

TEST(QuaternionTree, HasTheJacobianOfItsOwnSteps) {
  Worst worst;
  for (unsigned seed = 0; seed < kSeeds; ++seed) {
    Pair pair(random_model(seed, {.for_quaternions = true}), {.quaternions = true});
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> value(-0.5, 0.5);
    std::vector<double> step(static_cast<std::size_t>(pair.tree.unknown_count()));
    for (double& each : step) each = value(random);
    advance(pair.tree, pair.tree.default_q, step, pair.workspace.q);
    update_kinematics(pair.tree, pair.workspace);
    worst.add(worst_difference_quotient(pair, kDifferenceStep));
  }
  EXPECT_LE(worst.value, kDifferenceTolerance);
}

TEST(QuaternionTree, StartsAtThePoseOfTheAngles) {
  const MusculoskeletalModel model = random_model(3, {.for_quaternions = true});
  const KinematicTree angles = compile_tree(model);
  const KinematicTree quaternions = compile_tree(model, {.quaternions = true});
  KinematicWorkspace a(angles), b(quaternions);
  update_poses(angles, a);
  update_poses(quaternions, b);
  for (std::size_t i = 0; i < a.X_WB.size(); ++i) {
    EXPECT_LE(distance(a.X_WB[i], b.X_WB[i]), kPoseTolerance);
  }
}

TEST(QuaternionTree, KeepsQuaternionsOfUnitLengthThroughManySteps) {
  const KinematicTree tree =
      compile_tree(random_model(4, {.for_quaternions = true}), {.quaternions = true});
  std::vector<double> q = tree.default_q;
  const std::vector<double> step(static_cast<std::size_t>(tree.unknown_count()), 0.3);
  for (int i = 0; i < 1000; ++i) {
    const std::vector<double> before = q;
    advance(tree, before, step, q);
  }
  int count = 0;
  for (const KinematicTree::Link& link : tree.links) {
    if (!is_quaternion(link)) continue;
    EXPECT_NEAR(Eigen::Map<const Eigen::Vector4d>(q.data() + link.first_q).norm(), 1.0, 1e-15);
    ++count;
  }
  EXPECT_GE(count, 2);
}

TEST(QuaternionTree, RejectsWhatAnglesAreNeededFor) {
  MusculoskeletalModel model = random_model(0, {.coupler_count = 0, .lock_count = 0});
  ASSERT_EQ(model.joints[0].kind, Joint::Kind::kFree);
  MusculoskeletalModel locked = model, coupled = model;
  locked.coordinates[1].source = {"model.osim", 5};
  locked.coordinates[1].locked = true;
  coupled.couplers.push_back({"c", 0, 7, {LinearFunction{}}, {"model.osim", 9}});
  const KinematicTree::Options options{.quaternions = true};
  EXPECT_EQ(error_of([&] { compile_tree(locked, options); }),
            "model.osim:5: coordinate 'q1' is locked, clamped or prescribed, but its joint is to "
            "step as a quaternion; expected a free coordinate. Use angles for this model.");
  EXPECT_EQ(error_of([&] { compile_tree(coupled, options); }),
            "model.osim:9: coupler 'c' acts on a joint that is to step as a quaternion; expected "
            "coordinates with a value of their own. Use angles for this model.");
  const int all = compile_tree(model, options).unknown_count();
  EXPECT_EQ(compile_tree(locked, {.quaternions = true, .ignore_locks = true}).unknown_count(), all);
  std::swap(locked.coordinates[1].locked, locked.coordinates[3].locked);
  EXPECT_EQ(compile_tree(locked, options).unknown_count(), all - 1);  // a shift can be held
}

TEST(Unknowns, LeaveOutDependentLockedAndPrescribedCoordinates) {
  MusculoskeletalModel model = random_model(5);
  const int before = compile_tree(model).unknown_count();
  int free = 0;
  for (std::size_t c = 0; c < model.coordinates.size(); ++c) {
    const bool dependent =
        std::any_of(model.couplers.begin(), model.couplers.end(),
                    [&](const CoordinateCoupler& k) { return k.dependent == static_cast<int>(c); });
    free += !dependent && !model.coordinates[c].locked ? 1 : 0;
  }
  EXPECT_EQ(before, free);
  const auto c = static_cast<std::size_t>(compile_tree(model).unknown_v[4]);   // no quaternions:
  model.coordinates[c].prescribed = ScalarFunction{LinearFunction{2.0, 1.0}};  // v = coordinate
  const KinematicTree tree = compile_tree(model);
  EXPECT_EQ(tree.unknown_count(), before - 1);
  std::vector<double> q = tree.default_q;
  prescribe(tree, 3.0, q);
  EXPECT_EQ(q[static_cast<std::size_t>(tree.q_of_coordinate[c])], 7.0);
}

TEST(Advance, KeepsUnknownsWithinTheirBoundsAndOthersWhereTheyAre) {
  MusculoskeletalModel model = random_model(6);
  const auto bounded = static_cast<std::size_t>(compile_tree(model).unknown_v[3]);
  model.coordinates[bounded].clamped = true;
  model.coordinates[bounded].range_min = -0.75;
  model.coordinates[bounded].range_max = 0.75;
  const KinematicTree tree = compile_tree(model);
  std::vector<double> q(tree.default_q.size());
  const std::vector<double> up(static_cast<std::size_t>(tree.unknown_count()), 2.0);
  advance(tree, tree.default_q, up, q);
  for (std::size_t i = 0; i < q.size(); ++i) {
    const int x = tree.unknown_of_v[i];
    EXPECT_EQ(q[i], x < 0 ? tree.default_q[i] : i == bounded ? 0.75 : tree.default_q[i] + 2.0);
  }
}

// One body on a custom joint along the axes of frames that coincide; each coordinate moves one
// axis.
MusculoskeletalModel plain_custom_joint() {
  MusculoskeletalModel model =
      random_model(0, {.body_count = 1, .coupler_count = 0, .lock_count = 0});
  Joint& joint = model.joints[0];
  joint.kind = Joint::Kind::kCustom;
  joint.X_PF = joint.X_BM = {};
  for (std::size_t i = 0; i < 6; ++i) {
    joint.axes[i] = {
        Vector3d::Unit(static_cast<int>(i % 3)), joint.coordinates[i], {LinearFunction{}}};
  }
  return model;
}

// Constant functions of a coordinate are folded away; the coordinate stays, and moves nothing.
TEST(CustomJoint, KeepsACoordinateThatMovesNothing) {
  MusculoskeletalModel model = plain_custom_joint();
  for (std::size_t i = 0; i < 6; ++i) {
    if (i != 4) model.joints[0].axes[i].function = {ConstantFunction{0.1 * double(i)}};
  }
  Pair pair(model);
  EXPECT_EQ(pair.tree.unknown_count(), 6);
  pair.pose({1, 2, 3, 4, 5, 6});
  EXPECT_LE(worst_pose(pair), kPoseTolerance);
  for (std::size_t v = 0; v < 6; ++v) {
    EXPECT_EQ(pair.workspace.S[v].norm() > 0.0, v == 4) << v;
  }
}

// Simbody, and so OpenSim, takes the direction of a translation axis and not its length.
TEST(CustomJoint, ShiftsByTheFunctionWhateverTheLengthOfTheAxis) {
  MusculoskeletalModel model = plain_custom_joint();
  model.joints[0].axes[3].axis = {0.0, 0.0, 5.0};
  model.joints[0].axes[5].axis = {1.0, 0.0, 0.0};
  Pair pair(model);
  pair.pose({0, 0, 0, 2, 0, 0});
  EXPECT_EQ(pair.workspace.X_WB[1].p, Vector3d(0, 0, 2));
  EXPECT_LE(worst_pose(pair), kPoseTolerance);
}

}  // namespace
}  // namespace sinew
