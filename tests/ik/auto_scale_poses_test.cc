// Subjects of known size who stand, sit or hold their arms in other ways than the model does.

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <random>

#include "data/marker_synonyms.h"
#include "data/statistics.h"
#include "ik/auto_scale.h"
#include "ik/auto_scale_parameters.h"
#include "ik/auto_scale_samples.h"
#include "ik/distance_sizes.h"
#include "model/osim_document.h"
#include "model/scaling.h"
#include "model/whole_body.h"

namespace sinew {
namespace {

namespace fs = std::filesystem;

const fs::path kRajagopal = "../shared/data/opensim-models/Rajagopal_run/Rajagopal2016.osim";

#define SINEW_NEEDS_RAJAGOPAL() \
  if (!fs::exists(kRajagopal)) GTEST_SKIP() << "needs the published models in ../shared/data"

// Coordinates of the right side in degrees; the left has the same.
using Pose = std::map<std::string, double>;

struct NamedPose {
  const char* name;
  Pose pose;
};

const NamedPose kPoses[] = {
    {"stands", {{"elbow_flex", 10}, {"knee_angle", 3}, {"pro_sup", 60}}},
    {"T", {{"arm_add", -90}, {"elbow_flex", 5}, {"pro_sup", 60}, {"arm_rot", -30}}},
    {"A", {{"arm_add", -45}, {"elbow_flex", 5}, {"pro_sup", 60}}},
    {"hands up", {{"arm_add", -110}, {"elbow_flex", 80}, {"arm_rot", 60}, {"pro_sup", 60}}},
    {"sits",
     {{"hip_flexion", 85},
      {"knee_angle", 88},
      {"elbow_flex", 60},
      {"pro_sup", 60},
      {"arm_flex", 20}}},
};

// A subject: the model with factors of its own and markers beside their places.
struct Subject {
  MusculoskeletalModel generic, model;
  ScaleFactors factors;
  double mean_factor = 1.0;  // geometric, over the segments
  AutoScaleOptions options;

  Subject(MusculoskeletalModel of, double size, unsigned seed)
      : generic(std::move(of)), model(generic), factors(generic) {
    std::mt19937 random(seed);
    std::normal_distribution<double> normal;
    std::map<std::string, double> of_segment;  // both sides the same
    for (std::size_t b = 1; b < generic.bodies.size(); ++b) {
      std::string name = generic.bodies[b].name;
      if (name.ends_with("_l")) name.back() = 'r';
      if (name.starts_with("patella")) name = "tibia_r";
      if (name.starts_with("calcn") || name.starts_with("toes")) name = "talus_r";
      if (name.starts_with("ulna") || name.starts_with("hand")) name = "radius_r";
      if (!of_segment.contains(name)) of_segment[name] = size * std::exp(0.05 * normal(random));
      factors.of_body[b].setConstant(of_segment[name]);
    }
    for (const auto& [segment, factor] : of_segment) {
      mean_factor *= std::pow(factor, 1.0 / static_cast<double>(of_segment.size()));
    }
    model = scale_geometry(generic, factors);
    for (Marker& marker : model.markers) {
      const bool technical = is_technical_marker(marker.name);
      if (technical) options.technical_markers.push_back(marker.name);
      for (int axis = 0; axis < 3; ++axis) {
        marker.p_BM[axis] += (technical ? 0.02 : 0.007) * normal(random);
      }
    }
  }

  // Five frames at 10 Hz with noise of 1 mm; without the joints' virtual markers.
  MarkerFile record(const Pose& pose, unsigned seed) const {
    std::mt19937 random(seed);
    std::normal_distribution<double> normal;
    const KinematicTree tree = compile_tree(model);
    KinematicWorkspace ws(tree);
    for (const auto& [name, degrees] : pose) {
      for (const char* side : {"_r", "_l"}) {
        const int c = model.find_coordinate(name + side);
        EXPECT_GE(c, 0) << name;
        ws.q[static_cast<std::size_t>(tree.q_of_coordinate[static_cast<std::size_t>(c)])] =
            degrees * M_PI / 180.0;
      }
    }
    update_poses(tree, ws);
    MarkerFile file;
    file.path = "synthetic.trc";
    std::vector<Eigen::Vector3d> places;
    for (const Marker& marker : model.markers) {
      if (marker.name.ends_with("JC") || marker.name.ends_with("plateau")) continue;
      file.markers.names.push_back(marker.name);
      places.push_back(ws.X_WB[static_cast<std::size_t>(marker.body)] * marker.p_BM);
    }
    constexpr int kFrames = 5;
    file.markers.rate = 10.0;
    file.markers.time = Eigen::VectorXd::LinSpaced(kFrames, 0.0, 0.4);
    file.markers.p_WM.resize(kFrames, 3 * static_cast<Eigen::Index>(places.size()));
    for (int f = 0; f < kFrames; ++f) {
      file.markers.frame_numbers.push_back(f + 1);
      for (std::size_t m = 0; m < places.size(); ++m) {
        for (int axis = 0; axis < 3; ++axis) {
          file.markers.p_WM(f, 3 * static_cast<Eigen::Index>(m) + axis) =
              places[m][axis] + 0.001 * normal(random);
        }
      }
    }
    return file;
  }
};

// From one joint to the next, along a body: the distance of the joint's centre from its carrier's.
double length(const MusculoskeletalModel& model, const char* joint) {
  return model.joints[static_cast<std::size_t>(model.find_joint(joint))].X_PF.p.norm();
}

// Bounds: what misplaced markers of 7 mm leave of a segment's length, and of RMS.
TEST(AutoScalePoses, SizesAndPlacesComeOutOfAnyStaticPose) {
  SINEW_NEEDS_RAJAGOPAL();
  const Subject subject(OsimDocument(kRajagopal).model(), 0.92, 5);
  for (const NamedPose& pose : kPoses) {
    const MarkerFile recording = subject.record(pose.pose, 11);
    const AutoScaleResult result =
        auto_scale(subject.generic, {{&recording, {}, {}}}, subject.options);
    EXPECT_TRUE(result.converged) << pose.name;
    EXPECT_LT(result.rms_after, 0.003) << pose.name;
    EXPECT_NEAR(result.size, 0.92, 0.03) << pose.name;
    const MusculoskeletalModel ours = scale_geometry(subject.generic, result.factors);
    for (const char* joint :
         {"walker_knee_r", "ankle_r", "elbow_r", "radius_hand_r", "walker_knee_l"}) {
      EXPECT_NEAR(length(ours, joint), length(subject.model, joint), 0.015)
          << pose.name << ": " << joint << " was " << length(subject.generic, joint);
    }
    std::vector<double> off;
    for (const MarkerOffset& offset : result.offsets) {
      const auto m = static_cast<std::size_t>(offset.marker);
      off.push_back((result.markers[m].p_BM - subject.model.markers[m].p_BM).norm());
    }
    EXPECT_LT(median(off), 0.012) << pose.name;
    for (const VerdictReason& reason : result.reasons) {
      ADD_FAILURE() << pose.name << ": " << reason.text;
    }
  }
}

// A child of 1.05 m in the model of a man.
TEST(AutoScalePoses, ChildrenAreFoundAtTheirSize) {
  SINEW_NEEDS_RAJAGOPAL();
  const Subject subject(OsimDocument(kRajagopal).model(), 0.6, 8);
  for (const NamedPose& pose : kPoses) {
    const MarkerFile recording = subject.record(pose.pose, 3);
    const AutoScaleResult result =
        auto_scale(subject.generic, {{&recording, {}, {}}}, subject.options);
    EXPECT_NEAR(result.size, 0.6, 0.03) << pose.name;
    EXPECT_LT(result.rms_after, 0.003) << pose.name;
  }
}

// Distances alone tell sizes, whatever the pose.
TEST(DistanceSizes, DoNotDependOnThePose) {
  SINEW_NEEDS_RAJAGOPAL();
  for (const double size : {0.5, 0.75, 1.1}) {
    const Subject subject(OsimDocument(kRajagopal).model(), size, 4);
    for (const NamedPose& pose : kPoses) {
      const MarkerFile recording = subject.record(pose.pose, 2);
      const FrameSample sample = take_frames({&recording, {}, {}}, subject.options);
      std::vector<int> tracked;
      for (const std::string& name : recording.markers.names) {
        tracked.push_back(subject.generic.find_marker(name));
      }
      const AutoScaleParameters parameters =
          choose_parameters(subject.generic, tracked, subject.options);
      const Eigen::VectorXd theta =
          sizes_from_distances(subject.generic, parameters, {sample}, subject.options);
      EXPECT_NEAR(std::exp(theta[0]) / subject.mean_factor, 1.0, 0.06) << size << " " << pose.name;
      const MusculoskeletalModel rough = parameters.apply(subject.generic, theta);
      for (const char* joint : {"walker_knee_r", "ankle_r", "elbow_r"}) {
        EXPECT_NEAR(length(rough, joint) / length(subject.model, joint), 1.0, 0.12)
            << size << " " << pose.name << " " << joint;
      }
    }
  }
}

// A marker that was taken for another is held where people's markers can be, and named.
TEST(AutoScalePoses, MarkersStayOnTheSkinAndSizesAreThoseOfPeople) {
  SINEW_NEEDS_RAJAGOPAL();
  const Subject subject(OsimDocument(kRajagopal).model(), 1.0, 6);
  MarkerFile recording = subject.record(kPoses[0].pose, 9);
  const int elbow = recording.markers.find_marker("RLEL");
  ASSERT_GE(elbow, 0);
  recording.markers.p_WM.middleCols(3 * elbow, 3).array() += 0.2;
  const AutoScaleResult result =
      auto_scale(subject.generic, {{&recording, {}, {}}}, subject.options);
  const SizeLimits limits;
  bool named = false;
  for (const VerdictReason& reason : result.reasons) {
    named = named || (reason.code == "moved-marker" && reason.text.starts_with("RLEL sits 50 mm"));
  }
  EXPECT_TRUE(named);
  for (const MarkerOffset& offset : result.offsets) {
    const std::string& name = subject.generic.markers[static_cast<std::size_t>(offset.marker)].name;
    const double most =
        is_technical_marker(name) ? limits.technical_marker_offset : limits.marker_offset;
    EXPECT_LE(offset.offset.cwiseAbs().maxCoeff(), most) << name;
    EXPECT_EQ(offset.at_limit, offset.offset.cwiseAbs().maxCoeff() >= most) << name;
  }
  for (const ScaleEstimate& estimate : result.estimates) {
    const double ratio = estimate.factor / result.size;
    EXPECT_GE(ratio, limits.smallest_ratio * (1.0 - 1e-12)) << estimate.name;
    EXPECT_LE(ratio, limits.largest_ratio * (1.0 + 1e-12)) << estimate.name;
  }
}

// Segments that nobody has, by factors given.
TEST(SizeLimits, NameWhatNobodyHas) {
  const MusculoskeletalModel model = whole_body({.level = WholeBodyOptions::Level::kSimplified});
  ScaleFactors factors(model);
  for (Eigen::Vector3d& f : factors.of_body) f.setConstant(0.9);
  EXPECT_TRUE(size_reasons(model, factors, {}).empty());
  factors.of_body[3].y() = 0.49;
  std::vector<VerdictReason> reasons = size_reasons(model, factors, {});
  ASSERT_EQ(reasons.size(), 1u);
  EXPECT_EQ(reasons[0].code, "size-limit");
  EXPECT_EQ(reasons[0].text, "the length of " + model.bodies[3].name +
                                 " is 54 % of what the body's size lets expect");
  EXPECT_EQ(reasons[0].limit, 78.0);
  EXPECT_EQ(reasons[0].weight, VerdictReason::Weight::kRemark);
  for (Eigen::Vector3d& f : factors.of_body) f.setConstant(0.001);
  reasons = size_reasons(model, factors, {});
  ASSERT_EQ(reasons.size(), 1u);
  EXPECT_EQ(reasons[0].weight, VerdictReason::Weight::kUnusable);
}

TEST(SizeLimits, RefusesLimitsThatHoldNobody) {
  SizeLimits limits;
  limits.smallest_ratio = 1.2;
  try {
    limits.validate();
    FAIL() << "accepted";
  } catch (const std::invalid_argument& error) {
    EXPECT_STREQ(error.what(),
                 "SizeLimits.smallest_ratio is 1.2; expected a number between 0 and 1");
  }
}

}  // namespace
}  // namespace sinew
