#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <vector>

#include "data/reference_walk.h"
#include "model/kinematic_tree.h"
#include "model/osim_file.h"
#include "model/path_length.h"
#include "model/whole_body.h"
#include "tests/model/shared_models.h"

namespace sinew {
namespace {

using Level = WholeBodyOptions::Level;

// --- Moment arms against a published model. ---

struct Counterpart {
  const char* published;  // of Gait2354
  const char* ours;       // at level simplified
};

constexpr Counterpart kMuscles[] = {
    {"glut_med1_r", "gluteus_medius_anterior_r"},
    {"glut_med2_r", "gluteus_medius_middle_r"},
    {"glut_med3_r", "gluteus_medius_posterior_r"},
    {"bifemlh_r", "biceps_femoris_long_r"},
    {"bifemsh_r", "biceps_femoris_short_r"},
    {"sar_r", "sartorius_r"},
    {"add_mag2_r", "adductor_magnus_middle_r"},
    {"tfl_r", "tensor_fasciae_latae_r"},
    {"pect_r", "pectineus_r"},
    {"grac_r", "gracilis_r"},
    {"glut_max1_r", "gluteus_maximus_superior_r"},
    {"glut_max2_r", "gluteus_maximus_middle_r"},
    {"glut_max3_r", "gluteus_maximus_inferior_r"},
    {"iliacus_r", "iliacus_r"},
    {"psoas_r", "psoas_r"},
    {"quad_fem_r", "quadratus_femoris_r"},
    {"gem_r", "obturator_internus_r"},
    {"peri_r", "piriformis_r"},
    {"rect_fem_r", "rectus_femoris_r"},
    {"vas_int_r", "vastus_intermedius_r"},
    {"med_gas_r", "gastrocnemius_medial_r"},
    {"soleus_r", "soleus_r"},
    {"tib_post_r", "tibialis_posterior_r"},
    {"tib_ant_r", "tibialis_anterior_r"},
};

// A coordinate of the right leg; `sign` takes Gait2354's value to ours: its knee extends upward.
struct LegCoordinate {
  const char* name;
  double sign;
};
constexpr LegCoordinate kCoordinates[] = {
    {"hip_flexion_r", 1.0}, {"knee_angle_r", -1.0}, {"ankle_angle_r", 1.0}};

constexpr int kPhases = 40;

// A model posed along the stride, the hip, knee and ankle of the right leg moving in the sagittal
// plane.
class Walker {
 public:
  explicit Walker(MusculoskeletalModel model, bool published)
      : model_(std::move(model)),
        published_(published),
        tree_(compile_tree(model_)),
        ws_(tree_),
        walk_(reference_walk()),
        arms_(tree_.unknown_v.size()) {}

  const MusculoskeletalModel& model() const { return model_; }

  void pose(double phase) {
    for (const LegCoordinate& c : kCoordinates) {
      for (const WalkCurve& curve : walk_.curves) {
        if (curve.coordinate != c.name) continue;
        ws_.q[q_of(c.name)] = (published_ ? c.sign : 1.0) * evaluate(curve.series, phase)[0];
      }
    }
    update_kinematics(tree_, ws_);
  }

  // By the sweep, in our sign of the coordinate [m].
  double moment_arm(const std::string& path, const LegCoordinate& c) {
    moment_arms(find(path), tree_, ws_, arms_);
    return (published_ ? c.sign : 1.0) * arms_[unknown_of(c.name)];
  }

  // By central differences of the length, likewise.
  double moment_arm_by_differences(const std::string& path, const LegCoordinate& c) {
    constexpr double kStep = 1e-5;
    const double q = ws_.q[q_of(c.name)];
    double length[2];
    for (const int side : {0, 1}) {
      ws_.q[q_of(c.name)] = q + (side == 0 ? -kStep : kStep);
      update_poses(tree_, ws_);
      length[side] = path_length(find(path), tree_, ws_);
    }
    ws_.q[q_of(c.name)] = q;
    update_poses(tree_, ws_);
    return -(published_ ? c.sign : 1.0) * (length[1] - length[0]) / (2.0 * kStep);
  }

  double leg_length() const {
    const auto at = [&](const char* body) {
      return ws_.X_WB[static_cast<std::size_t>(model_.find_body(body))].p;
    };
    const char* foot = published_ ? "talus_r" : "calcn_r";
    return (at("tibia_r") - at("femur_r")).norm() + (at(foot) - at("tibia_r")).norm();
  }

 private:
  std::size_t coordinate(const std::string& name) const {
    return static_cast<std::size_t>(model_.find_coordinate(name));
  }
  std::size_t q_of(const std::string& name) const {
    return static_cast<std::size_t>(tree_.q_of_coordinate[coordinate(name)]);
  }
  std::size_t unknown_of(const std::string& name) const {
    return static_cast<std::size_t>(
        tree_.unknown_of_v[static_cast<std::size_t>(tree_.v_of_coordinate[coordinate(name)])]);
  }
  const PathElement& find(const std::string& name) const {
    for (const PathElement& path : model_.paths) {
      if (path.name == name) return path;
    }
    throw std::logic_error("no path " + name);
  }

  MusculoskeletalModel model_;
  bool published_;
  KinematicTree tree_;
  KinematicWorkspace ws_;
  ReferenceWalk walk_;
  std::vector<double> arms_;
};

// Range of a moment arm along the stride [m].
struct Course {
  double low = 1e9, high = -1e9;
  void add(double value) {
    low = std::min(low, value);
    high = std::max(high, value);
  }
};

// Compared: every muscle about every coordinate at every phase. Left out by rule: where the
// published arm comes below 5 mm somewhere in the stride or changes its sign, because a ratio of
// what is nearly nothing says nothing. The published arms are scaled by the lengths of the legs.
TEST(WholeBodyLeg, HasMomentArmsOfGait2354) {
  SINEW_SKIP_WITHOUT_SHARED_DATA();
  constexpr double kLeastArm = 0.005;  // [m]
  Walker theirs(read_osim(kSharedData / "opensim-models/Gait2354_Simbody/gait2354_simbody.osim"),
                true);
  Walker ours(whole_body({.level = Level::kSimplified}), false);
  theirs.pose(0.0);
  ours.pose(0.0);
  const double scale = ours.leg_length() / theirs.leg_length();
  EXPECT_NEAR(scale, 1.07, 0.01);
  std::set<std::string> compared;
  int pairs = 0;
  for (const Counterpart& muscle : kMuscles) {
    for (const LegCoordinate& c : kCoordinates) {
      SCOPED_TRACE(std::string(muscle.ours) + " about " + c.name);
      Course arm, ratio;
      for (int i = 0; i < kPhases; ++i) {
        theirs.pose(static_cast<double>(i) / kPhases);
        ours.pose(static_cast<double>(i) / kPhases);
        const double expected = scale * theirs.moment_arm(muscle.published, c);
        const double found = ours.moment_arm(muscle.ours, c);
        EXPECT_NEAR(ours.moment_arm_by_differences(muscle.ours, c), found, 1e-9);
        EXPECT_NEAR(scale * theirs.moment_arm_by_differences(muscle.published, c), expected, 1e-9);
        arm.add(expected);
        ratio.add(found / expected);
      }
      const bool changes_sign = arm.low < 0.0 && arm.high > 0.0;
      if (changes_sign || std::min(std::abs(arm.low), std::abs(arm.high)) < kLeastArm) continue;
      EXPECT_GE(ratio.low, 0.6);
      EXPECT_LE(ratio.high, 1.7);
      compared.insert(muscle.ours);
      ++pairs;
    }
  }
  EXPECT_EQ(compared.size(), 21u);
  EXPECT_EQ(pairs, 25);
}

// --- Reach: no wire is too short for walking. ---

// All coordinates of the embedded walk, its back shared by the lumbar joints and the lowest
// thoracic one.
void pose_walking(const MusculoskeletalModel& model, const KinematicTree& tree, double phase,
                  KinematicWorkspace& ws) {
  static const ReferenceWalk walk = reference_walk();
  static const std::vector<std::string> kBack = {"L5", "L4", "L3", "L2", "L1", "T12"};
  const auto set = [&](const std::string& name, double q) {
    const int c = model.find_coordinate(name);
    ASSERT_GE(c, 0) << name;
    ws.q[static_cast<std::size_t>(tree.q_of_coordinate[static_cast<std::size_t>(c)])] = q;
  };
  for (const WalkCurve& curve : walk.curves) {
    const double q = evaluate(curve.series, phase - curve.delay)[0];
    const std::string back = "lumbar_";
    if (!curve.coordinate.starts_with(back)) {
      set(curve.coordinate, q);
      continue;
    }
    for (const std::string& vertebra : kBack) {
      set(vertebra + "_" + curve.coordinate.substr(back.size()),
          q / static_cast<double>(kBack.size()));
    }
  }
  update_kinematics(tree, ws);
}

bool is_of_leg(const PathElement& path) {
  return path.source.file == "model/whole_body/wires_leg.csv";
}

// Moves the virtual links so that no wire of the leg is longer than its natural length, as far as
// that can be: each is drawn back by the mean of what its wires are too long by.
void settle(const MusculoskeletalModel& model, const KinematicTree& tree, KinematicWorkspace& ws) {
  for (int sweep = 0; sweep < 500; ++sweep) {
    std::vector<Eigen::Vector3d> pull(model.bodies.size(), Eigen::Vector3d::Zero());
    std::vector<int> count(model.bodies.size(), 0);
    for (const PathElement& path : model.paths) {
      if (!is_of_leg(path)) continue;
      const double excess = path_length(path, tree, ws) - path.natural_length;
      if (excess <= 0.0) continue;
      for (std::size_t i = 0; i < path.points.size(); ++i) {
        const auto b = static_cast<std::size_t>(path.points[i].body);
        if (!model.bodies[b].virtual_link) continue;
        const PathPoint& other = path.points[i == 0 ? 1 : i - 1];
        const Eigen::Vector3d to = ws.X_WB[static_cast<std::size_t>(other.body)] * other.p_BP -
                                   ws.X_WB[b] * path.points[i].p_BP;
        pull[b] += excess * to.normalized();
        ++count[b];
      }
    }
    for (std::size_t b = 1; b < model.bodies.size(); ++b) {
      if (count[b] == 0) continue;
      const Joint& joint = model.joints[b - 1];
      const Eigen::Matrix3d R_WP = ws.X_WB[static_cast<std::size_t>(joint.parent)].R;
      const Eigen::Vector3d step = R_WP.transpose() * pull[b] / count[b];
      for (int k = 0; k < 3; ++k) {
        const int c = joint.coordinates[static_cast<std::size_t>(3 + k)];
        ws.q[static_cast<std::size_t>(tree.q_of_coordinate[static_cast<std::size_t>(c)])] +=
            step[k];
      }
    }
    update_poses(tree, ws);
  }
}

TEST(WholeBodyLeg, ReachesThroughTheWalk) {
  for (const Level level : {Level::kSimplified, Level::kDetailed}) {
    const MusculoskeletalModel model = whole_body({.level = level});
    const KinematicTree tree = compile_tree(model);
    KinematicWorkspace ws(tree);
    std::map<std::string, double> worst;
    for (int i = 0; i < 20; ++i) {
      ws.q = tree.default_q;
      pose_walking(model, tree, i / 20.0, ws);
      settle(model, tree, ws);
      for (const PathElement& path : model.paths) {
        if (!is_of_leg(path)) continue;
        const double strain = path_length(path, tree, ws) / path.natural_length - 1.0;
        const auto [entry, first] = worst.try_emplace(path.name, strain);
        if (!first) entry->second = std::max(entry->second, strain);
      }
    }
    for (const auto& [name, strain] : worst) EXPECT_LE(strain, 0.01) << name;
  }
}

}  // namespace
}  // namespace sinew
