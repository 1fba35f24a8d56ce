#include "ik/auto_scale.h"

#include <gtest/gtest.h>

#include <cmath>

#include "data/marker_synonyms.h"
#include "data/storage_file.h"
#include "data/trc_file.h"
#include "ik/auto_scale_parameters.h"
#include "ik/marker_placement.h"
#include "ik/tracking.h"
#include "model/osim_document.h"
#include "model/scaling.h"

namespace sinew {
namespace {

using Eigen::Vector3d;
namespace fs = std::filesystem;

const fs::path kGait = "../shared/data/opensim-models/Gait2354_Simbody";
const fs::path kArnold = "../shared/data/nimblephysics/Arnold2013Synthetic";

#define SINEW_NEEDS_GAIT() \
  if (!fs::exists(kGait)) GTEST_SKIP() << "needs the published models in ../shared/data"

MusculoskeletalModel generic_gait() {
  OsimDocument document(kGait / "gait2354_simbody.osim");
  document.merge_markers(kGait / "gait2354_Scale_MarkerSet.xml");
  return document.model();
}

// Factors of both sides, tied.
ScaleFactors true_factors(const MusculoskeletalModel& model) {
  ScaleFactors factors(model);
  const auto set = [&](std::initializer_list<const char*> bodies, double f) {
    for (const char* body : bodies) {
      factors.of_body[static_cast<std::size_t>(model.find_body(body))].setConstant(f);
    }
  };
  set({"pelvis"}, 1.06);
  set({"femur_r", "femur_l"}, 1.10);
  set({"tibia_r", "tibia_l"}, 1.04);
  set({"talus_r", "talus_l", "calcn_r", "calcn_l", "toes_r", "toes_l"}, 1.08);
  set({"torso"}, 1.12);
  return factors;
}

// Markers of `model`, without noise, along the published walk.
MarkerFile synthesize(const MusculoskeletalModel& model) {
  const TimeTable motion = read_storage(kGait / "reference/subject01_walk1_ik.mot").table;
  const KinematicTree tree = compile_tree(model);
  KinematicWorkspace ws(tree);
  MarkerFile file;
  file.path = "synthetic.trc";
  MarkerTrajectories& markers = file.markers;
  for (const Marker& marker : model.markers) markers.names.push_back(marker.name);
  markers.rate = 60.0;
  markers.time = motion.time;
  markers.p_WM.resize(motion.time.size(), 3 * static_cast<Eigen::Index>(model.markers.size()));
  for (Eigen::Index frame = 0; frame < motion.time.size(); ++frame) {
    markers.frame_numbers.push_back(static_cast<int>(frame) + 1);
    for (std::size_t c = 0; c < model.coordinates.size(); ++c) {
      const int column = motion.find_column(model.coordinates[c].name);
      if (column < 0) continue;
      const bool angle = model.coordinates[c].motion == Coordinate::Motion::kRotational;
      ws.q[static_cast<std::size_t>(tree.q_of_coordinate[c])] =
          motion.values(frame, column) * (angle ? M_PI / 180.0 : 1.0);
    }
    update_poses(tree, ws);
    for (std::size_t m = 0; m < model.markers.size(); ++m) {
      markers.p_WM.row(frame).segment<3>(3 * static_cast<Eigen::Index>(m)) =
          (ws.X_WB[static_cast<std::size_t>(model.markers[m].body)] * model.markers[m].p_BM)
              .transpose();
    }
  }
  return file;
}

double truth_of(const ScaleEstimate& estimate, const ScaleFactors& truth) {
  return truth.of_body[static_cast<std::size_t>(estimate.bodies[0])][std::max(0, estimate.axis)];
}

// Known factors, markers where the model has them, no noise: what the recording determines comes
// out, whichever way the axes are parameterized, and the rest says that it is not.
TEST(AutoScale, RecoversKnownFactors) {
  SINEW_NEEDS_GAIT();
  const MusculoskeletalModel model = generic_gait();
  const ScaleFactors truth = true_factors(model);
  const MarkerFile walk = synthesize(scale_geometry(model, truth));
  for (const auto axes : {AutoScaleOptions::Axes::kUniform, AutoScaleOptions::Axes::kEach}) {
    AutoScaleOptions options;
    options.axes = axes;
    options.frames = 12;
    const AutoScaleResult result = auto_scale(model, {{&walk, {}, {}}}, options);
    EXPECT_TRUE(result.converged) << result.iterations;
    EXPECT_LT(result.rms_after, 2e-3);
    EXPECT_GT(result.rms_before, 1e-2);
    int determinate = 0;
    for (const ScaleEstimate& estimate : result.estimates) {
      EXPECT_LT(estimate.posterior_sd, estimate.prior_sd) << estimate.name;
      if (!estimate.determinate) continue;
      ++determinate;
      const double error = std::log(estimate.factor / truth_of(estimate, truth));
      EXPECT_LT(std::abs(error), 0.02) << estimate.name << " " << estimate.factor;
      // Errors come from the priors alone, and are what the posterior says at most.
      EXPECT_LT(std::abs(error), 3.0 * estimate.posterior_sd) << estimate.name;
    }
    EXPECT_GE(determinate, 4);
  }
}

// Wands that hold a marker a hand's breadth off the skin say nothing of the segment's size.
TEST(AutoScale, IsNotMisledByWands) {
  SINEW_NEEDS_GAIT();
  const MusculoskeletalModel model = generic_gait();
  const ScaleFactors truth = true_factors(model);
  MusculoskeletalModel subject = scale_geometry(model, truth);
  AutoScaleOptions options;
  options.frames = 12;
  for (Marker& marker : subject.markers) {
    if (!is_technical_marker(marker.name)) continue;
    options.technical_markers.push_back(marker.name);
    marker.p_BM += Eigen::Vector3d(0.05, 0.03, marker.name[0] == 'R' ? 0.08 : -0.08);
  }
  ASSERT_GE(options.technical_markers.size(), 12u);
  const MarkerFile walk = synthesize(subject);
  const auto worst = [&](const AutoScaleOptions& with) {
    const AutoScaleResult result = auto_scale(model, {{&walk, {}, {}}}, with);
    EXPECT_TRUE(result.converged) << result.iterations;
    double error = 0.0;
    int determinate = 0;
    for (const ScaleEstimate& estimate : result.estimates) {
      if (!estimate.determinate) continue;
      ++determinate;
      error = std::max(error, std::abs(std::log(estimate.factor / truth_of(estimate, truth))));
    }
    EXPECT_GE(determinate, 3);
    return error;
  };
  EXPECT_LT(worst(options), 0.025);
  options.technical_markers.clear();
  EXPECT_GT(worst(options), 0.05);
}

// A third of the samples are gone, each marker at other times.
TEST(AutoScale, EnduresOcclusion) {
  SINEW_NEEDS_GAIT();
  const MusculoskeletalModel model = generic_gait();
  const ScaleFactors truth = true_factors(model);
  MarkerFile walk = synthesize(scale_geometry(model, truth));
  for (int frame = 0; frame < walk.markers.frame_count(); ++frame) {
    for (int m = 0; m < walk.markers.marker_count(); ++m) {
      if ((frame * 7 + m * 5) % 9 < 3) {
        walk.markers.p_WM.row(frame).segment<3>(3 * m).setConstant(kNaN);
      }
    }
  }
  AutoScaleOptions options;
  options.axes = AutoScaleOptions::Axes::kUniform;
  options.frames = 12;
  const AutoScaleResult result = auto_scale(model, {{&walk, {}, {}}}, options);
  EXPECT_TRUE(result.converged);
  for (const ScaleEstimate& estimate : result.estimates) {
    if (!estimate.determinate) continue;
    EXPECT_NEAR(estimate.factor, truth_of(estimate, truth), 0.025) << estimate.name;
  }
}

TEST(AutoScale, DoesNotDependOnTheThreads) {
  SINEW_NEEDS_GAIT();
  const MusculoskeletalModel model = generic_gait();
  const MarkerFile walk = synthesize(scale_geometry(model, true_factors(model)));
  AutoScaleOptions options;
  options.axes = AutoScaleOptions::Axes::kUniform;
  options.frames = 9;
  options.max_iterations = 3;
  options.threads = 1;
  const AutoScaleResult one = auto_scale(model, {{&walk, {}, {}}}, options);
  options.threads = 3;
  const AutoScaleResult three = auto_scale(model, {{&walk, {}, {}}}, options);
  EXPECT_EQ(one.factors, three.factors);
  EXPECT_EQ(one.cost, three.cost);
}

// Left with right; a foot is one from talus to toes; a torso without markers goes with the pelvis.
TEST(AutoScaleParameters, TieSidesAndUnmarkedBodies) {
  SINEW_NEEDS_GAIT();
  const MusculoskeletalModel model = generic_gait();
  std::vector<int> tracked;
  for (const char* name :
       {"R.ASIS", "L.ASIS", "R.Knee.Lat", "L.Knee.Lat", "R.Ankle.Lat", "R.Heel"}) {
    tracked.push_back(model.find_marker(name));
  }
  AutoScaleOptions options;
  options.axes = AutoScaleOptions::Axes::kUniform;
  const AutoScaleParameters parameters = choose_parameters(model, tracked, options);
  std::string groups;
  for (const auto& factor : parameters.factors) {
    groups += factor.name + ":";
    for (const int b : factor.bodies)
      groups += " " + model.bodies[static_cast<std::size_t>(b)].name;
    groups += "\n";
  }
  EXPECT_EQ(groups,
            "pelvis: pelvis torso\nfemur_r: femur_r femur_l\ntibia_r: tibia_r tibia_l\n"
            "talus_r: talus_r calcn_r toes_r talus_l calcn_l toes_l\n");
  EXPECT_EQ(parameters.count(), 1 + 4 + 3 * 6);
  const Eigen::MatrixXd& C = parameters.prior_covariance_of_factors;
  EXPECT_DOUBLE_EQ(C(0, 1), 0.15 * 0.15);
  EXPECT_DOUBLE_EQ(C(0, 0), 0.15 * 0.15 + 0.05 * 0.05);
}

TEST(AutoScale, RefusesOptionsOutOfBounds) {
  const auto refusal = [](auto change) {
    AutoScaleOptions options;
    change(options);
    try {
      options.validate();
    } catch (const std::invalid_argument& error) {
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  EXPECT_EQ(refusal([](AutoScaleOptions& o) { o.segment_sd = 0.0; }),
            "AutoScaleOptions.segment_sd is 0; expected a finite number above 0");
  EXPECT_EQ(refusal([](AutoScaleOptions& o) { o.frames = 0; }),
            "AutoScaleOptions.frames is 0; expected 1 or more");
}

// Row 8 of the index: on the walk of the same subject, the fitted model meets the markers at least
// as well as the one that OpenSim scaled and whose markers it placed.
TEST(AutoScale, FitsAWalkAtLeastAsWellAsOpenSimsScaling) {
  SINEW_NEEDS_GAIT();
  const MusculoskeletalModel model = generic_gait();
  const MarkerFile stand = read_trc(kGait / "subject01_static.trc"),
                   walk = read_trc(kGait / "subject01_walk1.trc");
  AutoScaleOptions options;
  options.axes = AutoScaleOptions::Axes::kUniform;
  options.frames = 12;
  const AutoScaleResult result = auto_scale(model, {{&stand, 1.0, 2.0}, {&walk, {}, {}}}, options);
  const auto rms = [&](const MusculoskeletalModel& scaled) {
    const KinematicTree tree = compile_tree(scaled);
    const TrackingProblem tracking = bind_recording(scaled, tree, walk, nullptr, nullptr);
    const TrackingResult tracked = track(scaled, tree, tracking, walk.markers, {});
    double sum = 0.0;
    int count = 0;
    for (const double e : tracked.marker_errors.reshaped()) {
      if (std::isnan(e)) continue;
      sum += e * e;
      ++count;
    }
    return std::sqrt(sum / count);
  };
  MusculoskeletalModel ours = scale_geometry(model, result.factors);
  ours.markers = result.markers;
  const double theirs = rms(OsimDocument(kGait / "subject01_simbody.osim").model());
  const double mine = rms(ours);
  RecordProperty("ours_mm", std::to_string(1e3 * mine));
  RecordProperty("opensim_mm", std::to_string(1e3 * theirs));
  EXPECT_LT(mine, theirs);
}

// Row 7: the truth is a model of another author's fit; markers are exact for it.
TEST(AutoScale, NearsABlindModel) {
  if (!fs::exists(kArnold)) GTEST_SKIP() << "needs the published models in ../shared/data";
  const MusculoskeletalModel model = OsimDocument(kArnold / "unscaled_generic.osim").model();
  const MusculoskeletalModel truth = OsimDocument(kArnold / "subject01/subject01.osim").model();
  const MarkerFile walk = read_trc(kArnold / "subject01/trials/walk2/markers.trc");
  AutoScaleOptions options;
  options.frames = 12;
  const AutoScaleResult result = auto_scale(model, {{&walk, {}, {}}}, options);
  const MusculoskeletalModel ours = scale_geometry(model, result.factors);
  // Lengths between joints, of the generic model, of ours and in truth.
  for (const auto& [joint, next] :
       {std::pair{"hip_r", "walker_knee_r"}, std::pair{"walker_knee_r", "ankle_r"}}) {
    const auto length = [&](const MusculoskeletalModel& m) {
      return m.joints[static_cast<std::size_t>(m.find_joint(next))].X_PF.p.norm();
    };
    const double before = std::abs(length(model) - length(truth)),
                 after = std::abs(length(ours) - length(truth));
    RecordProperty(std::string(next) + "_mm",
                   std::to_string(1e3 * after) + " was " + std::to_string(1e3 * before));
    EXPECT_LT(after, std::max(before, 0.01)) << next;
  }
  EXPECT_LT(result.rms_after, 0.5 * result.rms_before);
}

}  // namespace
}  // namespace sinew
