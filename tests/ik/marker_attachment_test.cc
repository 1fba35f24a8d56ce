#include "ik/marker_attachment.h"

#include <gtest/gtest.h>

#include <numbers>
#include <random>

#include "ik/marker_clusters.h"
#include "ik/marker_coverage.h"
#include "ik/upright_posture.h"
#include "tests/ik/walker.h"

namespace sinew {
namespace {

using Eigen::Vector3d;
using Fate = MarkerAttachment::Fate;

constexpr int kFrames = 60;

// The walker in as many poses as there are frames, its markers, and room for others.
struct Recorded {
  Walker walker;
  MarkerFile file;
  TrackingResult solved;
  std::vector<std::vector<RigidTransform>> X_WB;  // frames × bodies

  explicit Recorded(const std::vector<std::string>& others, const std::vector<int>& bare = {}) {
    std::erase_if(walker.model.markers, [&](const Marker& m) {
      return std::find(bare.begin(), bare.end(), m.body) != bare.end();
    });
    walker.compile();
    MarkerTrajectories& markers = file.markers;
    for (const Marker& m : walker.model.markers) markers.names.push_back(m.name);
    markers.names.insert(markers.names.end(), others.begin(), others.end());
    markers.rate = 100.0;
    markers.time = Eigen::VectorXd::LinSpaced(kFrames, 0.0, (kFrames - 1) / 100.0);
    markers.p_WM.setConstant(kFrames, 3 * markers.marker_count(), kNaN);
    solved.coordinates.resize(kFrames, static_cast<Eigen::Index>(walker.model.coordinates.size()));
    solved.frames.resize(kFrames);
    for (int f = 0; f < kFrames; ++f) {
      KinematicWorkspace ws(walker.tree);
      ws.q = walker.pose(static_cast<unsigned>(f + 1), 0.4);
      update_poses(walker.tree, ws);
      X_WB.push_back(ws.X_WB);
      markers.frame_numbers.push_back(f + 1);
      for (std::size_t c = 0; c < walker.model.coordinates.size(); ++c) {
        solved.coordinates(f, static_cast<Eigen::Index>(c)) =
            ws.q[static_cast<std::size_t>(walker.tree.q_of_coordinate[c])];
      }
      for (std::size_t m = 0; m < walker.model.markers.size(); ++m) {
        const Marker& marker = walker.model.markers[m];
        set(f, static_cast<int>(m), body(f, marker.body) * marker.p_BM);
      }
      solved.frames[static_cast<std::size_t>(f)].measured_markers =
          static_cast<int>(walker.model.markers.size());
    }
  }

  const RigidTransform& body(int frame, int b) const {
    return X_WB[static_cast<std::size_t>(frame)][static_cast<std::size_t>(b)];
  }
  void set(int frame, int marker, const Vector3d& p) {
    file.markers.p_WM.block<1, 3>(frame, 3 * marker) = p.transpose();
  }
  int column(const std::string& name) const { return file.markers.find_marker(name); }

  TrackingProblem tracking() const {
    BindingOptions options;
    options.name_unmatched = false;
    return bind_recording(walker.model, walker.tree, file, nullptr, nullptr, options);
  }
  BodyPoses poses() const {
    return body_poses(walker.model, walker.tree, tracking(), file.markers, solved);
  }
};

constexpr int kThigh = 5, kShank = 6, kFoot = 8, kLocked = 9, kUnseen = 10;

TEST(MarkerAttachment, FindsTheBodyThatAMarkerIsOnAndRefusesOthers) {
  Recorded recorded({"thigh", "floor", "ball", "seldom", "hat", "stick", "toe"});
  std::mt19937 random(4);
  std::normal_distribution<double> noise(0.0, 0.003);
  const Vector3d place(0.05, -0.2, 0.06);
  for (int f = 0; f < kFrames; ++f) {
    const Vector3d skin(noise(random), noise(random), noise(random));
    recorded.set(f, recorded.column("thigh"), recorded.body(f, kThigh) * (place + skin));
    recorded.set(f, recorded.column("floor"), Vector3d(1.0, 0.0, 0.3));
    recorded.set(f, recorded.column("ball"), Vector3d(0.1 * f, 1.0 + 0.3 * noise(random), 0.5));
    if (f < 10) recorded.set(f, recorded.column("seldom"), recorded.body(f, kThigh) * place);
    // No marker tells how this body turns.
    recorded.set(f, recorded.column("hat"), recorded.body(f, kUnseen) * Vector3d(0.1, 0.1, 0.0));
    recorded.set(f, recorded.column("stick"), recorded.body(f, kThigh) * Vector3d(0.6, 0.3, 0.3));
    // The locked joint makes two bodies one.
    recorded.set(f, recorded.column("toe"), recorded.body(f, kLocked) * Vector3d(0.05, 0.0, 0.0));
  }
  std::vector<int> candidates;
  for (const char* name : {"thigh", "floor", "ball", "seldom", "hat", "stick", "toe"}) {
    candidates.push_back(recorded.column(name));
  }
  const std::vector<MarkerAttachment> found =
      find_attachments(recorded.walker.model, recorded.poses(), recorded.file.markers, candidates);
  ASSERT_EQ(found.size(), 7u);
  EXPECT_EQ(found[0].fate, Fate::kAttached);
  EXPECT_EQ(found[0].body, kThigh);
  // Of 60 samples: 3 mm / √60 along each axis.
  EXPECT_LT((found[0].p_BM - place).norm(), 0.0015);
  EXPECT_NEAR(found[0].spread, 0.003 * std::sqrt(3.0), 0.001);
  EXPECT_GT(found[0].confidence(), 0.8);
  EXPECT_EQ(found[1].fate, Fate::kStill);
  EXPECT_EQ(found[2].fate, Fate::kLoose);
  EXPECT_EQ(found[3].fate, Fate::kSeldom);
  EXPECT_EQ(found[4].fate, Fate::kLoose);
  EXPECT_EQ(found[5].fate, Fate::kFar);
  EXPECT_EQ(found[5].body, kThigh);
  EXPECT_EQ(found[6].fate, Fate::kAttached);
  EXPECT_TRUE(found[6].body == kLocked || found[6].body == kFoot);
}

TEST(MarkerAttachment, PosesThatNoMarkerTellsAreNotDetermined) {
  const Recorded recorded({}, {kShank, kFoot, kLocked});
  const BodyPoses poses = recorded.poses();
  for (std::size_t b = 0; b < poses.determined.size(); ++b) {
    // Without the shank's markers only the coupled patella tells the knee.
    const bool open = b == kFoot || b == kLocked || b == kUnseen;
    EXPECT_EQ(poses.determined[b], !open) << b;
  }
}

TEST(MarkerClusters, GroupsAreFoundAndCarriedToTheBodyWhoseJointsStay) {
  // Thigh, shank, patella and foot without markers of the model, each with a cluster that no name
  // tells; 1 mm of noise.
  Recorded recorded({"a1", "s1", "a2", "s2", "a3", "s3", "a4", "loose"}, {5, 6, 7, 8, 9});
  const Vector3d places[] = {
      {0.06, -0.2, 0.05}, {0.08, -0.3, 0.0}, {0.0, -0.25, 0.08}, {-0.05, -0.22, 0.04}};
  std::mt19937 random(7);
  std::normal_distribution<double> noise(0.0, 0.001);
  for (int f = 0; f < kFrames; ++f) {
    for (int i = 0; i < 4; ++i) {
      const Vector3d skin(noise(random), noise(random), noise(random));
      const std::string number = std::to_string(i + 1);
      recorded.set(f, recorded.column("a" + number), recorded.body(f, kThigh) * (places[i] + skin));
      if (i == 3) continue;
      recorded.set(f, recorded.column("s" + number),
                   recorded.body(f, kShank) * (places[i] - 0.5 * skin));
    }
    recorded.set(f, recorded.column("loose"), Vector3d(0.02 * f, 0.5, 0.01 * (f % 7)));
  }
  std::vector<int> candidates;
  for (const char* name : {"a1", "s1", "a2", "s2", "a3", "s3", "a4", "loose"}) {
    candidates.push_back(recorded.column(name));
  }
  const std::vector<std::vector<int>> groups = rigid_groups(recorded.file.markers, candidates, {});
  ASSERT_EQ(groups.size(), 2u);
  EXPECT_EQ(groups[0].size(), 4u);
  EXPECT_EQ(groups[1].size(), 3u);

  // The static trial: the first frame, in which every pose is known.
  MarkerTrajectories standing = some_frames(recorded.file.markers, 0, 0, 1);
  const std::vector<bool> known(recorded.walker.model.bodies.size(), true);
  const BodyPoses poses = recorded.poses();
  EXPECT_FALSE(poses.determined[kThigh]);
  const std::vector<ClusterAttachment> found =
      attach_clusters(recorded.walker.model, groups, standing, recorded.X_WB[0], known,
                      recorded.file.markers, poses);
  // The shank has no neighbour yet whose place markers tell.
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].body, kThigh);
  EXPECT_EQ(found[0].group, groups[0]);
  EXPECT_LT(found[0].joint_error, 0.01);
  for (int i = 0; i < 4; ++i) {
    EXPECT_LT((found[0].p_BM[static_cast<std::size_t>(i)] - places[i]).norm(), 0.005) << i;
  }
  BodyPoses later = poses;
  later.determined[kThigh] = true;
  const std::vector<ClusterAttachment> next =
      attach_clusters(recorded.walker.model, {groups[1]}, standing, recorded.X_WB[0], known,
                      recorded.file.markers, later);
  ASSERT_EQ(next.size(), 1u);
  EXPECT_EQ(next[0].body, kShank);
}

// A pelvis that carries a trunk; markers on the pelvis.
struct Upright {
  MusculoskeletalModel model = empty_model();
  KinematicTree tree;
  MarkerFile file;
  static constexpr double kDegree = std::numbers::pi / 180.0;

  explicit Upright(int frames, double rate) {
    const int pelvis = add_body(model, 0, Joint::Kind::kFree, "rrrttt", {0, 0, 0});
    const int torso = add_body(model, pelvis, Joint::Kind::kGimbal, "rrr", {0, 0.1, 0});
    model.bodies[1].name = "pelvis";
    model.bodies[2].name = "torso";
    const int arm = add_body(model, torso, Joint::Kind::kPin, "r", {0, 0.4, 0.2});
    model.bodies[static_cast<std::size_t>(arm)].name = "humerus_r";
    const Vector3d places[] = {{0.1, 0, 0.12}, {0.1, 0, -0.12}, {-0.1, 0.02, 0}, {0, 0.1, 0.1}};
    for (const Vector3d& place : places) {
      Marker& marker = model.markers.emplace_back();
      marker.name = "m" + std::to_string(model.markers.size());
      marker.body = pelvis;
      marker.p_BM = place;
      file.markers.names.push_back(marker.name);
    }
    tree = compile_tree(model);
    file.markers.rate = rate;
    file.markers.time = Eigen::VectorXd::LinSpaced(frames, 0.0, (frames - 1) / rate);
    file.markers.p_WM.resize(frames, 12);
    for (int f = 0; f < frames; ++f) {
      file.markers.frame_numbers.push_back(f + 1);
      const RigidTransform X_WP = pelvis_pose(f);
      for (int m = 0; m < 4; ++m) {
        file.markers.p_WM.block<1, 3>(f, 3 * m) = (X_WP * places[m]).transpose();
      }
    }
  }

  // Tilted by 12°, dropping by 5° and turning by 8° with strides of 1.1 s, going along a way that
  // is 30° off the laboratory's axis.
  RigidTransform pelvis_pose(int frame) const {
    const double t = file.markers.time[frame], phase = 2.0 * std::numbers::pi * t / 1.1;
    using Eigen::AngleAxisd;
    RigidTransform X;
    X.R = (AngleAxisd((30.0 + 8.0 * std::sin(phase)) * kDegree, Vector3d::UnitY()) *
           AngleAxisd(-12.0 * kDegree, Vector3d::UnitZ()) *
           AngleAxisd(5.0 * std::cos(phase) * kDegree, Vector3d::UnitX()))
              .toRotationMatrix();
    X.p = {t, 1.0, 0.0};
    return X;
  }

  IkTaskSet tasks(double weight) const {
    IkTaskSet set;
    for (const std::string& name : file.markers.names) set.tasks.push_back({.name = name});
    for (std::size_t c = 6; c < model.coordinates.size(); ++c) {
      IkTask task;
      task.kind = IkTask::Kind::kCoordinate;
      task.name = model.coordinates[c].name;
      task.weight = weight;
      set.tasks.push_back(task);
    }
    return set;
  }
};

TEST(UprightPosture, TrunkWithoutMarkersStaysUprightAndFacesTheWay) {
  const Upright walk(221, 100.0);
  const UprightPosture posture =
      upright_posture(walk.model, walk.tree, walk.file, walk.tasks(0.01), 0.01, {});
  ASSERT_EQ(posture.segments, (std::vector<Segment>{{"trunk", Side::kNone, true}}));
  // Not the arm's.
  ASSERT_EQ(posture.coordinates, (std::vector<int>{6, 7, 8}));
  ASSERT_EQ(posture.values.rows(), 221);
  for (int f = 55; f < 166; ++f) {
    const Eigen::Matrix3d R_WT =
        walk.pelvis_pose(f).R * rotation_from_body_xyz(posture.values.row(f).transpose());
    // 1 % of what it is turned by stays: 0.14° of tilt; a stride's mean of the heading is exact.
    EXPECT_LT(std::acos(R_WT(1, 1)), 0.2 * Upright::kDegree) << f;
    const double yaw = std::atan2(-R_WT(2, 0), R_WT(0, 0)) / Upright::kDegree;
    EXPECT_NEAR(yaw, 30.0, 0.3) << f;
  }
  EXPECT_TRUE(upright_posture(walk.model, walk.tree, walk.file, walk.tasks(0.01), 0.0, {}).empty());
}

TEST(UprightPosture, TrunkWithMarkersIsLeftToThem) {
  Upright walk(60, 100.0);
  walk.model.markers[3].body = 2;
  walk.tree = compile_tree(walk.model);
  EXPECT_TRUE(
      upright_posture(walk.model, walk.tree, walk.file, walk.tasks(0.01), 0.01, {}).empty());
}

TEST(MarkerCoverage, NamesSegmentsWithoutMarkersInWords) {
  const Upright walk(3, 100.0);
  const IkTaskSet tasks = walk.tasks(1.0);
  const TrackingProblem tracking =
      bind_recording(walk.model, walk.tree, walk.file, &tasks, nullptr, {});
  const MarkerCoverage coverage =
      marker_coverage(walk.model, walk.tree, tracking, walk.file.markers, 0, nullptr);
  // Although tasks draw them somewhere.
  EXPECT_EQ(coverage.undetermined, (std::vector<int>{6, 7, 8, 9}));
  const std::vector<VerdictReason> reasons = coverage_reasons(walk.model, coverage);
  ASSERT_EQ(reasons.size(), 1u);
  EXPECT_EQ(reasons[0].code, "segment-without-marker");
  EXPECT_EQ(
      reasons[0].text,
      "the trunk and the right upper arm have no marker: no measurement tells q6, q7, q8, q9");
  EXPECT_EQ(reasons[0].angles, (std::vector<std::string>{"q6", "q7", "q8", "q9"}));
  EXPECT_EQ(reasons[0].torques, reasons[0].angles);
}

TEST(MarkerCoverage, MisfitsNameTheirCauses) {
  Upright walk(3, 100.0);
  const TrackingProblem tracking =
      bind_recording(walk.model, walk.tree, walk.file, nullptr, nullptr, {});
  EXPECT_EQ(misfit_causes(walk.model, walk.tree, tracking, 0.05), "");
  EXPECT_NE(misfit_causes(walk.model, walk.tree, tracking, 0.3).find("unit or axes"),
            std::string::npos);
  for (Marker& marker : walk.model.markers) marker.body = 0;
  EXPECT_NE(misfit_causes(walk.model, walk.tree, tracking, 0.3)
                .find("none that is tracked is on a body that moves"),
            std::string::npos);
}

TEST(SegmentWords, BodiesOfPublishedModels) {
  const auto words = [](const std::vector<std::string>& bodies) {
    std::vector<Segment> segments;
    for (const std::string& body : bodies) segments.push_back(segment_of_body(body));
    return segments_in_words(segments);
  };
  EXPECT_EQ(words({"femur_l"}), "the left thigh");
  EXPECT_EQ(words({"femur_l", "femur_r"}), "both thighs");
  EXPECT_EQ(words({"calcn_r", "toes_r", "tibia_l", "torso"}),
            "the right foot, the left shank and the trunk");
  EXPECT_EQ(words({"L3", "T10", "scapula_r"}), "the trunk");
  EXPECT_EQ(words({"ulna_r", "radius_l", "hand_l", "skull"}),
            "both forearms, the left hand and the head");
  EXPECT_EQ(words({"rod1"}), "the segment 'rod1'");
}

}  // namespace
}  // namespace sinew
