#include "ik/continuity.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <filesystem>
#include <functional>
#include <numbers>
#include <random>

#include "data/storage_file.h"
#include "data/trc_file.h"
#include "ik/angle_jumps.h"
#include "model/osim_file.h"
#include "tests/ik/small_model.h"

namespace sinew {
namespace {

using Eigen::Vector3d;

constexpr double kPi = std::numbers::pi, kDegree = kPi / 180.0;

// A body that turns about three axes in succession, with four markers.
struct Turning {
  MusculoskeletalModel model = empty_model();
  KinematicTree tree;

  explicit Turning(const std::array<Vector3d, 3>& axes) {
    add_body(model, 0, Joint::Kind::kCustom, "rrr");
    for (std::size_t i = 0; i < 3; ++i) {
      model.joints[0].axes[i] = {axes[i], static_cast<int>(i), {LinearFunction{}}};
    }
    add_markers();
    compile();
  }
  explicit Turning(Joint::Kind kind, const std::string& motions) {
    add_body(model, 0, kind, motions);
    if (kind == Joint::Kind::kEllipsoid) model.joints[0].radii = {0.1, 0.2, 0.15};
    add_markers();
    compile();
  }

  void add_markers() {
    for (const Vector3d& p : {Vector3d(0.2, 0, 0.1), Vector3d(0, 0.3, 0), Vector3d(-0.1, 0, 0.2),
                              Vector3d(0.1, -0.2, -0.1)}) {
      Marker& marker = model.markers.emplace_back();
      marker.name = "m" + std::to_string(model.markers.size());
      marker.body = 1;
      marker.p_BM = p;
    }
  }
  void compile() {
    validate(model);
    tree = compile_tree(model);
  }
};

// What cameras see of a motion: frames × coordinates of the model.
MarkerFile recording_of(const Turning& body, const RowMatrix& motion, double rate = 100.0) {
  MarkerFile file;
  file.path = "turn.trc";
  MarkerTrajectories& markers = file.markers;
  const Eigen::Index frames = motion.rows();
  markers.rate = rate;
  markers.time = Eigen::VectorXd::LinSpaced(frames, 0.0, static_cast<double>(frames - 1) / rate);
  markers.p_WM.resize(frames, 3 * static_cast<Eigen::Index>(body.model.markers.size()));
  for (const Marker& marker : body.model.markers) markers.names.push_back(marker.name);
  KinematicWorkspace ws(body.tree);
  for (Eigen::Index f = 0; f < frames; ++f) {
    markers.frame_numbers.push_back(static_cast<int>(f) + 1);
    for (Eigen::Index c = 0; c < motion.cols(); ++c) {
      ws.q[static_cast<std::size_t>(body.tree.q_of_coordinate[static_cast<std::size_t>(c)])] =
          motion(f, c);
    }
    update_poses(body.tree, ws);
    for (std::size_t m = 0; m < body.model.markers.size(); ++m) {
      const Marker& marker = body.model.markers[m];
      markers.p_WM.row(f).segment<3>(3 * static_cast<Eigen::Index>(m)) =
          (ws.X_WB[static_cast<std::size_t>(marker.body)] * marker.p_BM).transpose();
    }
  }
  return file;
}

RowMatrix motion_of(int frames, const std::function<Eigen::VectorXd(double)>& angles,
                    double rate = 100.0) {
  RowMatrix motion(frames, angles(0.0).size());
  for (int f = 0; f < frames; ++f) motion.row(f) = angles(f / rate).transpose();
  return motion;
}

TrackingResult solve(const Turning& body, const MarkerFile& recording, int threads = 1,
                     const IkTaskSet* tasks = nullptr) {
  TrackingOptions options;
  options.threads = threads;
  return track(body.model, body.tree,
               bind_recording(body.model, body.tree, recording, tasks, nullptr), recording.markers,
               options);
}

// How far angles are from a motion, whole turns of a whole column aside.
double distance_to(const RowMatrix& motion, RowMatrix angles) {
  for (Eigen::Index c = 0; c < angles.cols(); ++c) {
    const double turns = std::round((angles(0, c) - motion(0, c)) / (2.0 * kPi));
    angles.col(c).array() -= 2.0 * kPi * turns;
  }
  return (angles - motion).cwiseAbs().maxCoeff();
}

double largest_step(const RowMatrix& q) {
  return (q.bottomRows(q.rows() - 1) - q.topRows(q.rows() - 1)).cwiseAbs().maxCoeff();
}

const std::array<Vector3d, 3> kZxy{Vector3d::UnitZ(), Vector3d::UnitX(), Vector3d::UnitY()};

Eigen::Matrix3d rotation(const std::array<Vector3d, 3>& axes, const Vector3d& theta) {
  return (Eigen::AngleAxisd(theta[0], axes[0]) * Eigen::AngleAxisd(theta[1], axes[1]) *
          Eigen::AngleAxisd(theta[2], axes[2]))
      .toRotationMatrix();
}

class Axes {
 public:
  explicit Axes(unsigned seed) : random_(seed) {}
  double uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }
  int integer(int low, int high) { return std::uniform_int_distribution<int>(low, high)(random_); }
  Vector3d axis() { return Vector3d(uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)).normalized(); }

 private:
  std::mt19937 random_;
};

// ---- the other triple

TEST(OtherTriple, IsTheSameOrientationAboutAnyAxes) {
  Axes random(1);
  for (int i = 0; i < 200; ++i) {
    const std::array<Vector3d, 3> axes{random.axis(), random.axis(), random.axis()};
    const Turning body(axes);
    const TurnChoices choices = find_turn_choices(body.model, body.tree, {});
    ASSERT_EQ(choices.triples.size(), 1u);
    const Vector3d theta(random.uniform(-3, 3), random.uniform(-3, 3), random.uniform(-3, 3));
    const Vector3d other = other_triple(choices, choices.triples[0], theta);
    EXPECT_LE((rotation(axes, other) - rotation(axes, theta)).cwiseAbs().maxCoeff(), 1e-12);
    EXPECT_GT((other - theta).norm(), 1e-3);
    const Vector3d back = other_triple(choices, choices.triples[0], other);
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(std::cos(back[k] - theta[k]), 1.0, 1e-12);
  }
}

TEST(OtherTriple, OfNormalAxesTurnsTwoByHalfATurn) {
  const Turning body(kZxy);
  const TurnChoices choices = find_turn_choices(body.model, body.tree, {});
  const Vector3d other = other_triple(choices, choices.triples[0], {0.3, 0.5, -0.7});
  EXPECT_NEAR(std::remainder(other[0] - 0.3 - kPi, 2 * kPi), 0.0, 1e-14);
  EXPECT_NEAR(std::remainder(other[1] - (kPi - 0.5), 2 * kPi), 0.0, 1e-14);
  EXPECT_NEAR(std::remainder(other[2] + 0.7 - kPi, 2 * kPi), 0.0, 1e-14);
  EXPECT_TRUE(choices.triples[0].has_line);
}

// ---- which coordinates

TEST(TurnChoices, LeaveOutWhatDoesMoreThanTurn) {
  MusculoskeletalModel model = empty_model();
  const int root = add_body(model, 0, Joint::Kind::kFree, "rrrttt");    // 0 … 5
  const int hip = add_body(model, root, Joint::Kind::kGimbal, "rrr");   // 6 7 8, 7 locked
  const int knee = add_body(model, hip, Joint::Kind::kCustom, "r");     // 9 turns and shifts
  const int ankle = add_body(model, knee, Joint::Kind::kPin, "r");      // 10 drives 11
  add_body(model, ankle, Joint::Kind::kPin, "r");                       // 11
  const int toe = add_body(model, ankle, Joint::Kind::kCustom, "rrr");  // 12 13 14
  add_body(model, toe, Joint::Kind::kPin, "r");                         // 15, of a condition
  add_body(model, toe, Joint::Kind::kUniversal, "rr");                  // 16 17
  add_body(model, toe, Joint::Kind::kPlanar, "rtt");                    // 18
  model.coordinates[7].locked = true;
  model.joints[2].axes[0] = {Vector3d::UnitZ(), 9, {LinearFunction{}}};
  model.joints[2].axes[3] = {Vector3d::UnitX(), 9, {PolynomialFunction{{0.1, 0.0, 0.0}}}};
  model.joints[5].axes[0] = {Vector3d::UnitX(), 12, {LinearFunction{-2.0, 0.5}, 0.5}};
  model.joints[5].axes[1] = {Vector3d::UnitY(), 13, {SineFunction{}}};
  model.joints[5].axes[2] = {Vector3d::UnitZ(), 14, {PolynomialFunction{{0.0, -1.0, 0.2}}}};
  model.joints[5].axes[3] = {Vector3d::UnitX(), 14, {ConstantFunction{0.3}}};  // shifts nothing
  clamp(model.coordinates[12], -1.0, 2.0);
  CoordinateCoupler& coupler = model.couplers.emplace_back();
  coupler.name = "coupler";
  coupler.independent = 10;
  coupler.dependent = 11;
  coupler.function = {LinearFunction{}};
  validate(model);
  const KinematicTree tree = compile_tree(model);
  IkProblem problem;
  problem.wire_points.push_back({0, {0, 0, 0}, tree.q_of_coordinate[15], 0.0, 1.0});
  const TurnChoices choices = find_turn_choices(model, tree, problem);
  std::vector<int> found;
  for (const FreeTurn& turn : choices.turns) found.push_back(turn.coordinate);
  EXPECT_EQ(found, (std::vector<int>{0, 1, 2, 6, 8, 12, 14, 16, 17, 18}));
  ASSERT_EQ(choices.triples.size(), 1u);
  EXPECT_EQ(choices.triples[0].turns, (std::array<int, 3>{0, 1, 2}));
  EXPECT_EQ(choices.single.size(), 7u);
  const FreeTurn& turn = choices.turns[5];
  EXPECT_EQ(turn.slope, -1.0);
  EXPECT_EQ(turn.intercept, 0.25);
  EXPECT_EQ(turn.lower, -1.75);
  EXPECT_EQ(turn.upper, 1.25);
  EXPECT_EQ(choices.turns[6].slope, -1.0);
}

// ---- choosing

// Every frame on a random branch: a whole turn off, or the other triple.
RowMatrix scrambled(const Turning& body, const RowMatrix& motion, Axes& random) {
  const TurnChoices choices = find_turn_choices(body.model, body.tree, {});
  RowMatrix q = motion;
  for (Eigen::Index f = 0; f < q.rows(); ++f) {
    Vector3d theta = q.row(f).head<3>().transpose();
    if (random.integer(0, 1) == 1) theta = other_triple(choices, choices.triples[0], theta);
    for (int k = 0; k < 3; ++k) theta[k] += 2.0 * kPi * random.integer(-2, 2);
    q.row(f).head<3>() = theta.transpose();
  }
  return q;
}

TrackingResult continued(const Turning& body, const RowMatrix& motion, const RowMatrix& given) {
  const MarkerFile recording = recording_of(body, motion);
  const TrackingProblem problem =
      bind_recording(body.model, body.tree, recording, nullptr, nullptr);
  TrackingResult result =
      evaluate_coordinates(body.model, body.tree, problem, recording.markers, 0, given);
  make_continuous(body.model, body.tree, problem, recording.markers, 0, result);
  return result;
}

TEST(MakeContinuous, FindsASmoothMotionAgainThroughPoles) {
  Axes random(2);
  // Through both poles of the middle angle, each between two frames, and twice around.
  const RowMatrix motion = motion_of(500, [](double t) -> Eigen::VectorXd {
    return Vector3d(3.0 * t, 4.0 * std::sin(1.1 * t + 0.005), -2.5 * t + std::sin(5.0 * t));
  });
  ASSERT_LT(largest_step(motion), 10.0 * kDegree);
  for (const std::array<Vector3d, 3>& axes :
       {kZxy,
        {Vector3d::UnitX(), Vector3d::UnitY(), Vector3d::UnitZ()},
        {Vector3d::UnitY(), Vector3d::UnitX(), Vector3d::UnitY()},
        {Vector3d(0, -1, 0), Vector3d(0, 0, 1), Vector3d(1, 0, 0)}}) {
    const Turning body(axes);
    const RowMatrix given = scrambled(body, motion, random);
    ASSERT_GT(largest_step(given), kPi);
    EXPECT_LE((continued(body, motion, given).coordinates - motion).cwiseAbs().maxCoeff(), 1e-9);
  }
}

TEST(MakeContinuous, FindsASmoothMotionAboutObliqueAxes) {
  Axes random(3);
  for (int i = 0; i < 20; ++i) {
    Turning body({random.axis(), random.axis(), random.axis()});
    const double phi = find_turn_choices(body.model, body.tree, {}).triples[0].phi;
    // Half a turn from one pole to the other is free of them.
    const RowMatrix motion = motion_of(300, [&](double t) -> Eigen::VectorXd {
      return Vector3d(2.0 * std::sin(t), phi + 0.5 * kPi + 0.9 * std::sin(2.0 * t + 1.0), -3.0 * t);
    });
    for (Eigen::Index c = 0; c < 3; ++c) {  // the first frame is the nearest to the default pose
      body.model.coordinates[static_cast<std::size_t>(c)].default_value = motion(0, c);
    }
    body.compile();
    const RowMatrix given = scrambled(body, motion, random);
    EXPECT_LE((continued(body, motion, given).coordinates - motion).cwiseAbs().maxCoeff(), 1e-9);
  }
}

TEST(MakeContinuous, LeavesASmoothMotionAsItIs) {
  const Turning body(kZxy);
  const RowMatrix motion = motion_of(200, [](double t) -> Eigen::VectorXd {
    return Vector3d(std::sin(3.0 * t), 0.5 * kPi * std::sin(2.0 * t), t);
  });
  EXPECT_EQ(continued(body, motion, motion).coordinates, motion);
}

TEST(MakeContinuous, KeepsBounds) {
  Turning body(kZxy);
  for (int c = 0; c < 3; ++c) clamp(body.model.coordinates[static_cast<std::size_t>(c)], -3.0, 3.0);
  clamp(body.model.coordinates[1], -1.5, 1.5);
  body.compile();
  const RowMatrix motion = motion_of(100, [](double t) -> Eigen::VectorXd {
    return Vector3d(2.9 * std::sin(5.0 * t), 1.4 * std::sin(4.0 * t), 2.9 * std::cos(5.0 * t));
  });
  Axes random(4);
  RowMatrix given = scrambled(body, motion, random);
  given.row(0) = motion.row(0);
  const RowMatrix found = continued(body, motion, given).coordinates;
  EXPECT_LE((found - motion).cwiseAbs().maxCoeff(), 1e-9);
}

// One whole turn is outside, so that a step remains, and is named.
TEST(MakeContinuous, NamesTheStepThatABoundKeeps) {
  Turning body(kZxy);
  for (int c = 0; c < 3; ++c) clamp(body.model.coordinates[static_cast<std::size_t>(c)], -kPi, kPi);
  clamp(body.model.coordinates[1], -1.5, 1.5);  // no other triple either
  body.compile();
  const RowMatrix motion = motion_of(100, [](double t) -> Eigen::VectorXd {
    const double angle = 5.0 * t;
    return Vector3d(angle > kPi ? angle - 2.0 * kPi : angle, 0.0, 0.1);
  });
  const TrackingResult result = continued(body, motion, motion);
  EXPECT_EQ(result.coordinates, motion);
  const std::vector<VerdictReason> reasons = angle_jumps(body.model, result);
  ASSERT_EQ(reasons.size(), 1u);
  EXPECT_EQ(reasons[0].text, "q0 steps by 357° between 0.62 s and 0.63 s");
}

// Whole turns cost where a task pulls, and nothing where it weighs nothing.
TEST(MakeContinuous, LeavesWhatATaskPulls) {
  const Turning body(kZxy);
  const RowMatrix motion =
      motion_of(100, [](double t) -> Eigen::VectorXd { return Vector3d(0.1, 0.2, 5.0 * t); });
  const MarkerFile recording = recording_of(body, motion);
  RowMatrix given = motion;
  given.col(2).tail(50).array() -= 2.0 * kPi;
  for (const double weight : {0.0, 1e-3}) {
    TrackingProblem problem = bind_recording(body.model, body.tree, recording, nullptr, nullptr);
    problem.coordinates.push_back({2, weight, 0.0, {}});
    problem.problem.coordinates.push_back({2, 2, weight});
    TrackingResult result =
        evaluate_coordinates(body.model, body.tree, problem, recording.markers, 0, given);
    make_continuous(body.model, body.tree, problem, recording.markers, 0, result);
    if (weight > 0.0) {
      EXPECT_EQ(result.coordinates, given);
    } else {
      EXPECT_LE((result.coordinates - motion).cwiseAbs().maxCoeff(), 1e-12);
    }
  }
}

// At the pole the sum of the outer angles is all that the pose tells: frames there go along the
// line to the frame before, and the cost is the same.
TEST(MakeContinuous, GoesToTheNearestPointOfAPolesLine) {
  const Turning body(kZxy);
  for (const double pole : {0.5 * kPi, -0.5 * kPi}) {
    const double sigma = pole > 0.0 ? 1.0 : -1.0;  // z x y: R(x, π/2) ŷ = ẑ
    const RowMatrix motion = motion_of(60, [&](double t) -> Eigen::VectorXd {
      return Vector3d(0.4 + t, pole * (1.0 - 0.5 * std::cos(kPi * t / 0.3)), 0.2 - 0.5 * t);
    });
    // cos(…) = 0 in frame 15 only, where the middle angle is at the pole.
    RowMatrix given = motion;
    const Eigen::Index at = 15;
    ASSERT_NEAR(motion(at, 1), pole, 1e-12);
    given(at, 0) += 1.3;
    given(at, 2) -= sigma * 1.3 + 2.0 * kPi;
    const TrackingResult result = continued(body, motion, given);
    EXPECT_LE((result.coordinates.topRows(at) - motion.topRows(at)).cwiseAbs().maxCoeff(), 0.0);
    // The change of both is shared equally: (Δθ₁ + σΔθ₃)/2 each.
    const double share =
        0.5 * ((motion(at, 0) - motion(at - 1, 0)) + sigma * (motion(at, 2) - motion(at - 1, 2)));
    EXPECT_NEAR(result.coordinates(at, 0), motion(at - 1, 0) + share, 1e-9);
    EXPECT_NEAR(result.coordinates(at, 2), motion(at - 1, 2) + sigma * share, 1e-9);
    EXPECT_LE(result.frames[static_cast<std::size_t>(at)].marker_rms, 2e-9);
  }
}

// Near a pole noise moves the outer angles far, and the cost says so: nothing is smoothed away.
TEST(MakeContinuous, LeavesWhatTheCostTellsNearAPole) {
  const Turning body(kZxy);
  RowMatrix motion =
      motion_of(10, [](double t) -> Eigen::VectorXd { return Vector3d(t, 0.5 * kPi - 0.01, 0.0); });
  motion.row(5).head<3>() += Eigen::RowVector3d(0.4, 0.0, -0.4);
  const RowMatrix found = continued(body, motion, motion).coordinates;
  EXPECT_LE((found - motion).cwiseAbs().maxCoeff(), 1e-5);
}

// ---- solved trials

TEST(TrackedAngles, FollowASubjectWhoTurnsSeveralTimes) {
  const auto turning = [](double t) -> Eigen::VectorXd {
    Eigen::VectorXd q(6);
    q << 0.1 * std::sin(6.0 * t), 5.0 * t, 0.1 * std::cos(6.0 * t), t, 0.9, 0.1;
    return q;
  };
  // About the first and the last axis; about the middle one goes through poles.
  for (const int axis : {0, 2}) {
    const Turning body(Joint::Kind::kFree, "rrrttt");
    const RowMatrix motion = motion_of(400, [&](double t) {
      Eigen::VectorXd q = turning(t);
      std::swap(q[1], q[axis]);
      return q;
    });
    const MarkerFile recording = recording_of(body, motion);
    const TrackingResult result = solve(body, recording);
    EXPECT_LE(distance_to(motion, result.coordinates), 1e-6);
    EXPECT_LE((result.coordinates.row(0) - motion.row(0)).cwiseAbs().maxCoeff(), 1e-6);
    EXPECT_TRUE(angle_jumps(body.model, result).empty());
    const TrackingResult again = solve(body, recording, 4);
    EXPECT_EQ(result.coordinates, again.coordinates);
    // What is stored is what the coordinates have.
    const TrackingResult measured = evaluate_coordinates(
        body.model, body.tree, bind_recording(body.model, body.tree, recording, nullptr, nullptr),
        recording.markers, 0, result.coordinates);
    EXPECT_LE((measured.marker_errors - result.marker_errors).cwiseAbs().maxCoeff(), 1e-14);
  }
}

// A shoulder with OpenSim's order of axes, raised over the side beyond the horizontal: through the
// pole, exactly at it in some frames, and back.
TEST(TrackedAngles, GoThroughThePoleOfAShoulder) {
  for (const double shift : {0.0, 0.0037}) {
    const Turning body(kZxy);
    const RowMatrix motion = motion_of(400, [&](double t) -> Eigen::VectorXd {
      // −90° at 0.25 s, 0.75 s, …, which are frames, or 3.7 ms beside them.
      const double s = t + 0.25 + shift;
      return Vector3d(0.3 + 0.4 * std::sin(2.0 * s), -0.5 * kPi + 1.2 * std::sin(2.0 * kPi * s),
                      0.5 * std::sin(1.5 * s));
    });
    const MarkerFile recording = recording_of(body, motion);
    const TrackingResult result = solve(body, recording);
    EXPECT_LE(distance_to(motion, result.coordinates), 0.02);
    EXPECT_TRUE(angle_jumps(body.model, result).empty());
    EXPECT_EQ(result.coordinates, solve(body, recording, 3).coordinates);
  }
}

TEST(TrackedAngles, OfBallAndEllipsoidJointsFollow) {
  for (const Joint::Kind kind :
       {Joint::Kind::kBall, Joint::Kind::kGimbal, Joint::Kind::kEllipsoid}) {
    const Turning body(kind, "rrr");
    const RowMatrix motion = motion_of(300, [](double t) -> Eigen::VectorXd {
      return Vector3d(4.0 * t, 0.3 + 2.0 * std::sin(2.0 * t), 0.4 * std::cos(3.0 * t));
    });
    const TrackingResult result = solve(body, recording_of(body, motion));
    EXPECT_LE(distance_to(motion, result.coordinates), 1e-4);
  }
}

TEST(TrackedAngles, OfTheTurningSubjectFollowItsTruth) {
  const std::filesystem::path folder = "../shared/cases/turning-subject";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << folder << " is missing";
  Turning body(kZxy);
  body.model = read_osim(folder / "toy.osim");
  body.compile();
  const MarkerFile recording = read_trc(folder / "turn.trc");
  const TimeTable truth = read_storage(folder / "turn_truth.mot").table;
  const TrackingResult result = solve(body, recording);
  ASSERT_EQ(result.coordinates.rows(), truth.values.rows());
  for (std::size_t c = 0; c < body.model.coordinates.size(); ++c) {
    const auto label =
        std::find(truth.labels.begin(), truth.labels.end(), body.model.coordinates[c].name);
    if (label == truth.labels.end()) continue;
    const bool turns = body.model.coordinates[c].motion == Coordinate::Motion::kRotational;
    const Eigen::VectorXd expected =
        truth.values.col(label - truth.labels.begin()) * (turns ? kDegree : 1.0);
    const Eigen::VectorXd found = result.coordinates.col(static_cast<Eigen::Index>(c));
    // Markers are printed to 1e-8 m.
    EXPECT_LE(distance_to(expected, found), 1e-5) << *label;
  }
}

// ---- jumps

TEST(AngleJumps, AreNamedOnceACoordinate) {
  MusculoskeletalModel model = empty_model();
  const int root = add_body(model, 0, Joint::Kind::kFree, "rrrttt");  // 0 … 5
  const int thigh = add_body(model, root, Joint::Kind::kPin, "r");    // 6
  add_body(model, thigh, Joint::Kind::kPin, "r");                     // 7
  add_body(model, root, Joint::Kind::kPin, "r");                      // 8
  RowMatrix q = RowMatrix::Zero(5, 9);
  q.col(6) << 0.0, 0.5, 1.0, 2.0, 1.0;  // 28.6°, 28.6°, 57.3°, 57.3°
  q.col(3) << 0.0, 5.0, 0.0, 5.0, 0.0;  // metres
  q.col(2) << 0.0, 0.0, 0.0, 0.0, 6.0;
  const Eigen::VectorXd time = Eigen::VectorXd::LinSpaced(5, 1.0, 1.04);
  const std::vector<VerdictReason> reasons = angle_jumps(model, time, q);
  ASSERT_EQ(reasons.size(), 2u);
  EXPECT_EQ(reasons[0].code, "jump");
  EXPECT_EQ(reasons[0].text, "q2 steps by 344° between 1.03 s and 1.04 s");
  EXPECT_EQ(reasons[0].weight, VerdictReason::Weight::kUnusable);
  EXPECT_EQ(reasons[0].torques.size(), 9u);
  EXPECT_EQ(reasons[1].text,
            "q6 steps by 57° between 1.02 s and 1.03 s, the largest of 2 such steps");
  EXPECT_EQ(reasons[1].weight, VerdictReason::Weight::kRemark);
  EXPECT_NEAR(reasons[1].figure, 57.29578, 1e-4);
  EXPECT_NEAR(reasons[1].limit, 30.0, 1e-12);
  EXPECT_EQ(reasons[1].angles, (std::vector<std::string>{"q6"}));
  EXPECT_EQ(reasons[1].torques,
            (std::vector<std::string>{"q0", "q1", "q2", "q3", "q4", "q5", "q6", "q7"}));
}

TEST(AngleJumps, AllowForLowRates) {
  EXPECT_NEAR(jump_limit(0.01), 30.0 * kDegree, 1e-15);
  EXPECT_NEAR(jump_limit(0.1), 100.0 * kDegree, 1e-15);
  EXPECT_NEAR(jump_limit(5.0), kPi, 1e-15);
}

}  // namespace
}  // namespace sinew
