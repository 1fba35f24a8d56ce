#include "dynamics/reference_recording.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "dynamics/reference_dynamics.h"
#include "dynamics/reference_motion.h"
#include "model/whole_body.h"

namespace sinew {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double kLoaded = 20.0;  // vertical force that plates count as contact from on [N]

struct Fixture {
  ReferenceWalk walk = reference_walk();
  ReferenceRecording recording = make_reference_recording(whole_body(), walk);
};

const Fixture& fixture() {
  static const Fixture made;
  return made;
}

double weight() { return fixture().recording.model.total_mass() * 9.80665; }

VectorXd column(const TimeTable& table, const std::string& label) {
  const int found = table.find_column(label);
  EXPECT_GE(found, 0) << label;
  return table.values.col(found);
}

// A foot's columns of the forces.
struct FootForces {
  Eigen::MatrixX3d force, point;
  VectorXd torque;
};

FootForces forces_of(const WalkFoot& foot) {
  const TimeTable& forces = fixture().recording.forces;
  const int first = forces.find_column("ground_force_" + foot.side + "_vx");
  return {forces.values.middleCols<3>(first), forces.values.middleCols<3>(first + 3),
          column(forces, "ground_torque_" + foot.side + "_y")};
}

// Phase since the foot's last strike, and the strides before it.
std::pair<double, double> since_strike(const WalkFoot& foot, double time) {
  const double phase = time / fixture().walk.stride_time - foot.strike;
  return {phase - std::floor(phase), std::floor(phase)};
}

// A point of the world in the frame of the flat foot that stands on the floor.
Vector3d in_footprint(const WalkFoot& foot, double time, Vector3d p_WQ) {
  p_WQ.x() -= since_strike(foot, time).second * fixture().walk.stride_length;
  const double heading = foot.side == "l" ? foot.toe_out : -foot.toe_out;
  return Eigen::AngleAxisd(-heading, Vector3d::UnitY()) * (p_WQ - foot.p_WB);
}

// Distance to the outline's nearest edge line, positive inside.
double depth_inside(const WalkFoot& foot, const Vector3d& p_BQ) {
  const double turn = foot.side == "r" ? 1.0 : -1.0;
  double depth = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < foot.outline.size(); ++i) {
    const Vector3d edge = foot.outline[(i + 1) % foot.outline.size()] - foot.outline[i];
    depth = std::min(depth, turn * edge.cross(p_BQ - foot.outline[i]).y() / edge.norm());
  }
  return depth;
}

// de Leva's parts make 100 % of the body, so pelvis, torso and limbs make 75 kg; the mass centre of
// a standing man is at 0.55 to 0.58 of his stature (Winter 2009, ch. 4: 0.567 in men).
TEST(ReferenceModel, HasTheMassesOfAMan) {
  const MusculoskeletalModel& model = fixture().recording.model;
  EXPECT_NEAR(model.total_mass(), 75.0, 1e-12);
  ReferenceDynamics dynamics(model);
  std::vector<double> q, zero(model.coordinates.size(), 0.0);
  for (const Coordinate& c : model.coordinates) q.push_back(c.default_value);
  dynamics.set_motion(q, zero, zero);
  EXPECT_GT(dynamics.mass_center().y() / 1.80, 0.55);
  EXPECT_LT(dynamics.mass_center().y() / 1.80, 0.58);
  EXPECT_NEAR(dynamics.mass_center().z(), 0.0, 1e-15);
}

TEST(ReferenceModel, WalksWithinItsRanges) {
  const ReferenceRecording& r = fixture().recording;
  for (std::size_t c = 0; c < r.model.coordinates.size(); ++c) {
    const auto q = r.true_coordinates.values.col(static_cast<Eigen::Index>(c));
    EXPECT_GE(q.minCoeff(), r.model.coordinates[c].range_min) << r.model.coordinates[c].name;
    EXPECT_LE(q.maxCoeff(), r.model.coordinates[c].range_max) << r.model.coordinates[c].name;
  }
}

TEST(ReferenceRecording, HasTheSamplesItPromises) {
  const ReferenceRecording& r = fixture().recording;
  EXPECT_EQ(r.markers.frame_count(), 221);
  EXPECT_EQ(r.forces.time.size(), 2210);
  EXPECT_EQ(r.markers.time[220], 2.2);
  EXPECT_EQ(r.forces.time[2200], 2.2);
  EXPECT_TRUE(r.markers.p_WM.allFinite());
  EXPECT_TRUE(r.forces.values.allFinite());
}

// Against Simbody's own kinematics.
TEST(ReferenceRecording, MarkersStandWhereTheTruthPutsThem) {
  const ReferenceRecording& r = fixture().recording;
  const SimbodyModel compiled(r.model);
  SimTK::State state = compiled.default_state();
  for (int i = 0; i < r.markers.frame_count(); i += 7) {
    compiled.set_q(state, {r.true_coordinates.values.row(i).data(),
                           static_cast<std::size_t>(r.true_coordinates.values.cols())});
    compiled.system().realize(state, SimTK::Stage::Position);
    for (int m = 0; m < r.markers.marker_count(); ++m) {
      const Marker& marker = r.model.markers[static_cast<std::size_t>(m)];
      const SimTK::MobilizedBody& body =
          compiled.matter().getMobilizedBody(compiled.body(marker.body));
      const SimTK::Vec3 p_WM = body.findStationLocationInGround(state, to_simtk(marker.p_BM));
      EXPECT_LE((to_eigen(p_WM) - r.markers.position(i, m)).norm(), 1e-12) << marker.name;
    }
  }
}

TEST(ReferenceMotion, ReturnsAfterAStrideAndHasExactDerivatives) {
  const Fixture& f = fixture();
  const ReferenceMotion motion(f.recording.model, f.walk);
  const std::size_t n = f.recording.model.coordinates.size();
  const auto tx = static_cast<std::size_t>(f.recording.model.find_coordinate("pelvis_tx"));
  std::vector<double> q(n), v(n), a(n), q1(n), v1(n), a1(n), v0(n), q0(n), unused(n);
  constexpr double kStep = 1e-5;  // [s]; error step²/6 times a third derivative near 1e4
  for (const double t : {0.0, 0.13, 0.7}) {
    motion.evaluate(t, q, v, a);
    motion.evaluate(t + f.walk.stride_time, q1, v1, a1);
    for (std::size_t c = 0; c < n; ++c) {
      EXPECT_NEAR(q1[c], q[c] + (c == tx ? f.walk.stride_length : 0.0), 1e-12);
      EXPECT_NEAR(v1[c], v[c], 1e-11);
      EXPECT_NEAR(a1[c], a[c], 1e-9);
    }
    motion.evaluate(t - kStep, q0, v0, unused);
    motion.evaluate(t + kStep, q1, v1, unused);
    for (std::size_t c = 0; c < n; ++c) {
      EXPECT_NEAR((q1[c] - q0[c]) / (2 * kStep), v[c], 1e-6);
      EXPECT_NEAR((v1[c] - v0[c]) / (2 * kStep), a[c], 1e-5);
    }
  }
}

// Newton: F = m (C̈ − g), C̈ by differences of the mass centre.
TEST(ReferenceDynamics, FloorCarriesTheMassCentre) {
  const Fixture& f = fixture();
  const ReferenceMotion motion(f.recording.model, f.walk);
  ReferenceDynamics dynamics(f.recording.model);
  const std::size_t n = f.recording.model.coordinates.size();
  std::vector<double> q(n), v(n), a(n);
  constexpr double kStep = 1e-3;  // [s]; error step²/12 · C⁗ ~ 1e-7 · 1e3 m/s²
  for (const double t : {0.1, 0.3, 0.5, 0.77}) {
    Eigen::Matrix3d C;
    for (int k = 0; k < 3; ++k) {
      motion.evaluate(t + (k - 1) * kStep, q, v, a);
      dynamics.set_motion(q, v, a);
      C.col(k) = dynamics.mass_center();
    }
    motion.evaluate(t, q, v, a);
    dynamics.set_motion(q, v, a);
    const Vector3d acceleration = (C.col(0) - 2.0 * C.col(1) + C.col(2)) / (kStep * kStep);
    const Vector3d expected = 75.0 * (acceleration - f.recording.model.gravity);
    EXPECT_LE((dynamics.required_wrench().tail<3>() - expected).norm(), 0.05);
  }
}

TEST(ShareWrench, FeetTogetherAreTheWrench) {
  const ReferenceWalk& walk = fixture().walk;
  Vector6d wrench;
  wrench << -20.0, 15.0, 40.0, 30.0, 800.0, -25.0;
  for (const double t : {0.0, 0.03, 0.07, 0.2, 0.57, 0.6, 1.1, 2.0}) {
    Vector6d sum = Vector6d::Zero();
    for (const FloorLoad& load : share_wrench(walk, t, {0.2, 1.0, 0.0}, wrench)) {
      EXPECT_EQ(load.point.y(), 0.0);
      sum.head<3>() += load.point.cross(load.force) + load.torque;
      sum.tail<3>() += load.force;
    }
    EXPECT_LE((sum - wrench).norm(), 1e-10) << t;
  }
}

TEST(ShareWrench, RefusesToPull) {
  try {
    share_wrench(fixture().walk, 0.5, {0.2, 1.0, 0.0}, Vector6d::Zero());
    FAIL() << "no error";
  } catch (const std::invalid_argument& error) {
    EXPECT_STREQ(error.what(),
                 "the reference walk would have to pull at the floor at 0.5 s: its vertical force "
                 "is 0 N. Move the body less up and down.");
  }
}

TEST(ReferenceRecording, LeavesNothingForTheRoot) {
  const TimeTable& forces = fixture().recording.true_forces;
  EXPECT_EQ(forces.labels[0], "pelvis_tilt_moment");
  EXPECT_EQ(forces.labels[5], "pelvis_tz_force");
  EXPECT_LE(forces.values.leftCols(6).cwiseAbs().maxCoeff(), 1e-8);
}

// Winter 2009 and Perry & Burnfield 2010: peaks of 1.0 to 1.3 body weights in each half of stance,
// a valley of 0.6 to 0.9 between; braking and propulsion of 0.1 to 0.3; some hundredths sideways;
// free moments of a few newton metres.
TEST(ReferenceRecording, FloorPushesAsInPublishedWalks) {
  const Fixture& f = fixture();
  for (const WalkFoot& foot : f.walk.feet) {
    const FootForces floor = forces_of(foot);
    double first = 0.0, valley = 10.0, second = 0.0;
    for (Eigen::Index i = 0; i < floor.force.rows(); ++i) {
      const double since = since_strike(foot, f.recording.forces.time[i]).first;
      const double up = floor.force(i, 1) / weight();
      EXPECT_GE(up, 0.0);
      if (since > 0.05 && since < 0.25) first = std::max(first, up);
      if (since > 0.25 && since < 0.37) valley = std::min(valley, up);
      if (since > 0.37 && since < 0.60) second = std::max(second, up);
    }
    EXPECT_GT(first, 1.0);
    EXPECT_LT(first, 1.3);
    EXPECT_GT(valley, 0.6);
    EXPECT_LT(valley, 0.9);
    EXPECT_GT(second, 1.0);
    EXPECT_LT(second, 1.3);
    EXPECT_GT(floor.force.col(0).maxCoeff() / weight(), 0.1);
    EXPECT_LT(floor.force.col(0).maxCoeff() / weight(), 0.3);
    EXPECT_LT(floor.force.col(0).minCoeff() / weight(), -0.1);
    EXPECT_GT(floor.force.col(0).minCoeff() / weight(), -0.3);
    EXPECT_LT(floor.force.col(2).cwiseAbs().maxCoeff() / weight(), 0.1);
    EXPECT_LT(floor.torque.cwiseAbs().maxCoeff(), 10.0);
  }
}

TEST(ReferenceRecording, CentreOfPressureKeepsUnderTheFoot) {
  const Fixture& f = fixture();
  for (const WalkFoot& foot : f.walk.feet) {
    const FootForces floor = forces_of(foot);
    int loaded = 0;
    for (Eigen::Index i = 0; i < floor.force.rows(); ++i) {
      EXPECT_EQ(floor.point(i, 1), 0.0);
      if (floor.force(i, 1) == 0.0) {
        EXPECT_TRUE(floor.point.row(i).isZero(0.0));
      }
      if (floor.force(i, 1) < kLoaded) continue;
      const double t = f.recording.forces.time[i];
      const Vector3d p_BQ = in_footprint(foot, t, floor.point.row(i).transpose());
      EXPECT_GT(depth_inside(foot, p_BQ), 0.0) << foot.side << " at " << t;
      ++loaded;
    }
    EXPECT_GT(loaded, 1000);
  }
}

// The foot lands within 7 % and lifts its heel at about 35 % of the stride. Flat in between, it
// moves by less than the markers of a real foot would wobble; nowhere does it sink in by more than
// the sole of a shoe gives, 5 mm, the tip's 20 mm of toe spring aside.
TEST(ReferenceRecording, FeetStandOnTheFloor) {
  const Fixture& f = fixture();
  const ReferenceRecording& r = f.recording;
  const KinematicTree tree = compile_tree(r.model);
  KinematicWorkspace workspace(tree);
  for (Eigen::Index i = 0; i < r.true_coordinates.time.size(); ++i) {
    for (std::size_t c = 0; c < r.model.coordinates.size(); ++c) {
      workspace.q[static_cast<std::size_t>(tree.q_of_coordinate[c])] =
          r.true_coordinates.values(i, static_cast<Eigen::Index>(c));
    }
    update_poses(tree, workspace);
    const double t = r.true_coordinates.time[i];
    for (const WalkFoot& foot : f.walk.feet) {
      const auto& X_WB = workspace.X_WB[static_cast<std::size_t>(r.model.find_body(foot.body))];
      const double since = since_strike(foot, t).first;
      for (const Vector3d& p_BS : foot.outline) {
        const Vector3d p_WS = X_WB * p_BS;
        EXPECT_GT(p_WS.y(), p_BS.x() > 0.15 ? -0.025 : -0.005) << foot.side << " at " << t;
        if (since < 0.15 || since > 0.32) continue;
        EXPECT_LT((in_footprint(foot, t, p_WS) - p_BS).norm(), 0.005) << foot.side << " at " << t;
      }
    }
  }
}

// Winter 2009, moments per body mass at natural cadence, mean ± two standard deviations or so; and
// Kadaba MP et al. (1989) J Orthop Res 7:849-860 for the frontal plane. In the model's signs:
// flexors, adductors, dorsiflexors positive.
TEST(ReferenceRecording, TorquesAreThoseOfAWalk) {
  const TimeTable& forces = fixture().recording.true_forces;
  const Eigen::Index stride = 110;
  const auto per_mass = [&](const char* label, double from, double to) -> VectorXd {
    const auto first = static_cast<Eigen::Index>(from * stride);
    const auto last = static_cast<Eigen::Index>(to * stride);
    return column(forces, label).segment(first, last - first + 1) / 75.0;
  };
  const auto expect_within = [](double value, double low, double high, const char* what) {
    EXPECT_GT(value, low) << what;
    EXPECT_LT(value, high) << what;
  };
  expect_within(per_mass("ankle_angle_r_moment", 0.4, 0.6).minCoeff(), -1.9, -1.2, "push-off");
  expect_within(per_mass("ankle_angle_r_moment", 0.65, 1.0).cwiseAbs().maxCoeff(), 0, 0.1, "swing");
  expect_within(per_mass("knee_angle_r_moment", 0.1, 0.25).minCoeff(), -1.0, -0.3, "knee loading");
  expect_within(per_mass("knee_angle_r_moment", 0.35, 0.5).maxCoeff(), 0.0, 0.6, "late stance");
  expect_within(per_mass("hip_flexion_r_moment", 0.0, 0.25).minCoeff(), -1.2, -0.3, "hip loading");
  expect_within(per_mass("hip_flexion_r_moment", 0.4, 0.65).maxCoeff(), 0.3, 1.2, "pull-off");
  expect_within(per_mass("hip_adduction_r_moment", 0.1, 0.5).minCoeff(), -1.3, -0.6, "abductors");
}

TEST(ReferenceRecordingOptions, NameTheFieldThatIsWrong) {
  const auto error_of = [](const ReferenceRecordingOptions& options) {
    try {
      make_reference_recording(options);
    } catch (const std::invalid_argument& error) {
      return std::string(error.what());
    }
    return std::string("no error");
  };
  ReferenceRecordingOptions options;
  options.strides = -1.0;
  EXPECT_EQ(error_of(options), "ReferenceRecordingOptions::strides is -1; it must be positive");
  options = {};
  options.artifacts.occlusion = 1.0;
  EXPECT_EQ(error_of(options), "MarkerArtifacts::occlusion is 1; it must be from 0 to below 1");
}

TEST(ReferenceRecordingOptions, NoiseAndGapsAreAsAskedAndRepeatable) {
  ReferenceRecordingOptions options;
  options.artifacts.noise = 0.001;
  options.artifacts.occlusion = 0.1;
  options.force_rate = 100.0;
  const ReferenceRecording a = make_reference_recording(options);
  const ReferenceRecording b = make_reference_recording(options);
  const MarkerTrajectories& exact = fixture().recording.markers;
  EXPECT_EQ(std::memcmp(a.markers.p_WM.data(), b.markers.p_WM.data(),
                        sizeof(double) * static_cast<std::size_t>(a.markers.p_WM.size())),
            0);
  EXPECT_EQ(a.true_coordinates.values, fixture().recording.true_coordinates.values);
  double squares = 0.0, measured = 0.0;
  for (Eigen::Index i = 0; i < exact.p_WM.rows(); ++i) {
    for (Eigen::Index j = 0; j < exact.p_WM.cols(); ++j) {
      const double error = a.markers.p_WM(i, j) - exact.p_WM(i, j);
      if (std::isnan(error)) continue;
      squares += error * error;
      measured += 1.0;
    }
  }
  // 26 000 samples estimate a standard deviation to 0.5 %.
  EXPECT_NEAR(std::sqrt(squares / measured), 0.001, 3e-5);
  EXPECT_NEAR(measured / static_cast<double>(exact.p_WM.size()), 0.9, 0.01);
  options.artifacts.seed = 2;
  EXPECT_NE(make_reference_recording(options).markers.p_WM(0, 0), a.markers.p_WM(0, 0));
}

}  // namespace
}  // namespace sinew
