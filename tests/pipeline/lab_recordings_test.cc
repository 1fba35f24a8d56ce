// Laboratories' own files against what others found in them.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "data/c3d_reader.h"
#include "data/storage_file.h"
#include "tests/pipeline/command_line.h"

namespace sinew {
namespace {

namespace fs = std::filesystem;
using Arguments = std::vector<std::string>;

// Pairs of samples of two results, where both have one.
struct Samples {
  std::vector<double> ours, theirs;

  double offset() const { return mean(ours) - mean(theirs); }
  double correlation() const {
    return covariance(ours, theirs) /
           std::sqrt(covariance(ours, ours) * covariance(theirs, theirs));
  }
  // Of the differences about their mean.
  double spread() const {
    return std::sqrt(covariance(ours, ours) + covariance(theirs, theirs) -
                     2.0 * covariance(ours, theirs));
  }

 private:
  static double mean(const std::vector<double>& x) {
    double sum = 0.0;
    for (const double value : x) sum += value;
    return sum / static_cast<double>(x.size());
  }
  static double covariance(const std::vector<double>& x, const std::vector<double>& y) {
    const double mx = mean(x), my = mean(y);
    double sum = 0.0;
    for (std::size_t i = 0; i < x.size(); ++i) sum += (x[i] - mx) * (y[i] - my);
    return sum / static_cast<double>(x.size());
  }
};

// A walk that Plug-in Gait was run on, its angles and moments stored among the points.
struct PluginGait {
  const char* file;
  const char* prefix;        // of labels
  const char* side;          // `right` or `left`
  double least_knee_moment;  // correlation, where the foot is on a platform
};

void PrintTo(const PluginGait& trial, std::ostream* out) {
  *out << trial.file << ", " << trial.side;
}

class PluginGaitTrial : public ::testing::TestWithParam<PluginGait> {
 protected:
  // The first component of a trajectory of the C3D file and a column of ours at its times.
  Samples compare(const std::string& computed, const TimeTable& table, const std::string& column,
                  bool loaded_only) const {
    Samples samples;
    const auto& names = file_.computed.labels;
    const auto name = std::find(names.begin(), names.end(), GetParam().prefix + computed);
    const int ours = table.find_column(column);
    EXPECT_TRUE(name != names.end()) << computed;
    EXPECT_GE(ours, 0) << column;
    if (name == names.end() || ours < 0) return samples;
    for (Eigen::Index row = 0; row < table.time.size(); ++row) {
      const auto frame =
          static_cast<Eigen::Index>(std::lround(table.time[row] * file_.markers.rate));
      const double theirs = file_.computed.values(frame, 3 * (name - names.begin()));
      if (std::isnan(theirs)) continue;
      if (loaded_only && !loaded_[static_cast<std::size_t>(frame)]) continue;
      samples.ours.push_back(table.values(row, ours));
      samples.theirs.push_back(theirs);
    }
    return samples;
  }

  C3dFile file_;
  std::vector<bool> loaded_;  // by frame: a platform measures the foot
};

// Plug-in Gait has other joint centres and axes and finds each segment by itself (Davis et al.
// 1991), so that offsets and amplitudes differ; what must agree is the course of angles over the
// whole walk and of moments in stance. Kainz et al. (2016, Gait Posture 45:125-132) find 3 to 9
// degrees between the two kinds of models.
TEST_P(PluginGaitTrial, CourseOfAnglesAndMomentsIsTheSame) {
  const fs::path shared = shared_data();
  if (shared.empty()) GTEST_SKIP() << "no ../shared/data";
  const fs::path path = shared / "c3d.org" / GetParam().file;
  file_ = read_c3d(path);
  TemporaryFolder folder;
  const Outcome outcome = run_sinew(
      folder.path(), {"run", "--c3d", path.string(), "--model", "whole-body", "--out", "."});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const std::string side = GetParam().side;
  loaded_.resize(static_cast<std::size_t>(file_.markers.frame_count()));
  std::size_t column = 0;
  for (const auto& row : csv_rows(folder.path() / "load_coverage.csv")) {
    if (row[0] == "time_s") {
      column = static_cast<std::size_t>(std::find(row.begin(), row.end(), side) - row.begin());
      continue;
    }
    const auto frame = std::lround(std::stod(row[0]) * file_.markers.rate);
    loaded_[static_cast<std::size_t>(frame)] = row.at(column) == "measured";
  }
  const std::string S = side == "right" ? "R" : "L", s = side == "right" ? "r" : "l";
  const TimeTable angles = read_storage(folder.path() / "ik.mot").table;
  const TimeTable torques = read_storage(folder.path() / "id.sto").table;
  for (const auto& [theirs, ours] :
       {std::pair{"KneeAngles", "knee_angle_"}, std::pair{"HipAngles", "hip_flexion_"}}) {
    const Samples samples = compare(S + theirs, angles, ours + s, false);
    ASSERT_GT(samples.ours.size(), 100u);
    EXPECT_GT(samples.correlation(), 0.96) << ours;
    EXPECT_LT(samples.spread(), 3.0) << ours;  // [degrees]
    // Where a pelvis has no tilt is a matter of definition, where a knee is straight is not.
    if (ours == std::string("knee_angle_")) {
      EXPECT_LT(std::abs(samples.offset()), 15.0);  // [degrees]
    }
  }
  // Theirs are [N mm/kg], and an extensor's is positive.
  const Samples ankle = compare(S + "AnkleMoment", torques, "ankle_angle_" + s + "_moment", true);
  ASSERT_GT(ankle.ours.size(), 25u);
  EXPECT_LT(ankle.correlation(), -0.98);
  const Samples knee = compare(S + "KneeMoment", torques, "knee_angle_" + s + "_moment", true);
  EXPECT_LT(knee.correlation(), -GetParam().least_knee_moment);
}

INSTANTIATE_TEST_SUITE_P(
    C3dOrg, PluginGaitTrial,
    ::testing::Values(PluginGait{"sample_03/gait-pig.c3d", "A22:", "right", 0.9},
                      PluginGait{"sample_03/gait-pig.c3d", "A22:", "left", 0.9},
                      PluginGait{"sample_03/gait-pig-nz.c3d", "", "right", 0.8},
                      PluginGait{"sample_04/sub_labels.c3d", "Matt:", "right", 0.95},
                      PluginGait{"sample_04/sub_labels.c3d", "Matt:", "left", 0.95},
                      PluginGait{"sample_09/PlugInC3D.c3d", "", "right", 0.95}));

// Shoulders and sacrum say how long a trunk is, not how its 17 joints share a turn: a weak posture
// let them bend to one side and, a frame later, to the other, for the trunk to fit.
TEST(LabPosture, SpinesDoNotBuckle) {
  const fs::path shared = shared_data();
  if (shared.empty()) GTEST_SKIP() << "no ../shared/data";
  const fs::path file = shared / "c3d.org/sample_00/Motion Analysis Corporation/Walk1.c3d";
  TemporaryFolder folder;
  const Outcome outcome = run_sinew(
      folder.path(), {"run", "--c3d", file.string(), "--model", "whole-body", "--out", "."});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const TimeTable motion = read_storage(folder.path() / "ik.mot").table;
  const Eigen::Index last = motion.time.size() - 1;
  for (std::size_t c = 0; c < motion.labels.size(); ++c) {
    const Eigen::VectorXd q = motion.values.col(static_cast<Eigen::Index>(c));
    const Eigen::VectorXd bend = q.head(last - 1) - 2.0 * q.segment(1, last - 1) + q.tail(last - 1);
    // Knees turn by 1.2 degrees more from one frame of 60 Hz to the next, nothing by more.
    EXPECT_LT(bend.cwiseAbs().maxCoeff(), 2.0) << motion.labels[c];
  }
  const nlohmann::json summary = nlohmann::json::parse(content_of(folder.path() / "summary.json"));
  EXPECT_LT(summary["inverse_kinematics"]["marker_rms_m"].get<double>(), 0.006);
  for (const char* contact : {"contact 1.1: left (", "contact 2.1: right ("}) {
    EXPECT_NE(outcome.out.find(contact), std::string::npos) << outcome.out;
  }
}

// A model without markers, a marker set, a static trial and measurements of OpenSim's tutorial.
TEST(LabScaleSetup, GivesTheModelThatScaleGives) {
  const fs::path shared = shared_data();
  if (shared.empty()) GTEST_SKIP() << "no ../shared/data";
  const fs::path from = shared / "opensim-models/Gait2354_Simbody";
  const auto file = [&](const char* name) { return (from / name).string(); };
  TemporaryFolder folder;
  const Outcome scaled =
      run_sinew(folder.path(), {"scale", "--setup", file("subject01_Setup_Scale.xml"), "--out-dir",
                                ".", "--out", "scaled.osim"});
  ASSERT_EQ(scaled.exit_code, 0) << scaled.err;
  const Outcome outcome = run_sinew(folder.path(), {"run",
                                                    "--c3d",
                                                    file("subject01_walk1.trc"),
                                                    "--static",
                                                    file("subject01_static.trc"),
                                                    "--model",
                                                    file("gait2354_simbody.osim"),
                                                    "--scale-setup",
                                                    file("subject01_Setup_Scale.xml"),
                                                    "--loads",
                                                    file("subject01_walk1_grf.xml"),
                                                    "--tasks",
                                                    file("subject01_Setup_IK.xml"),
                                                    "--marker-cutoff",
                                                    "-1",
                                                    "--cutoff",
                                                    "6",
                                                    "--from",
                                                    "0.4",
                                                    "--to",
                                                    "1.6",
                                                    "--out",
                                                    "."});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(content_of(folder.path() / "model.osim"), content_of(folder.path() / "scaled.osim"));
  EXPECT_NE(outcome.out.find("mass: 72.6 ([kg] the ScaleTool setup's) [--mass]"), std::string::npos)
      << outcome.out;
  // The published angles and torques are those of a model scaled in another pose.
  const TimeTable angles = read_storage(folder.path() / "ik.mot").table;
  const TimeTable torques = read_storage(folder.path() / "id.sto").table;
  const TimeTable published_angles = read_storage(from / "reference/subject01_walk1_ik.mot").table;
  const TimeTable published_torques = read_storage(from / "reference/inverse_dynamics.sto").table;
  // Without so many frames at either end.
  const auto largest = [](const TimeTable& a, const TimeTable& b, const std::string& column,
                          Eigen::Index ends) {
    EXPECT_EQ(a.time.size(), b.time.size());
    return (a.values.col(a.find_column(column)) - b.values.col(b.find_column(column)))
        .segment(ends, a.time.size() - 2 * ends)
        .cwiseAbs()
        .maxCoeff();
  };
  // The published motion ends with the range, and so does its filter, which bends it for a period
  // of 6 Hz; ours knows what follows.
  constexpr Eigen::Index kFilterEnds = 10;
  for (const char* joint : {"hip_flexion_r", "knee_angle_r", "ankle_angle_r", "hip_flexion_l"}) {
    EXPECT_LT(largest(angles, published_angles, joint, 0), 2.0) << joint;  // [degrees]
    const std::string moment = std::string(joint) + "_moment";
    EXPECT_LT(largest(torques, published_torques, moment, kFilterEnds), 4.0) << joint;  // [N m]
  }
}

TEST(LabScaleSetup, AModelWithoutMarkersIsRefused) {
  const fs::path shared = shared_data();
  if (shared.empty()) GTEST_SKIP() << "no ../shared/data";
  const fs::path from = shared / "opensim-models/Gait2354_Simbody";
  TemporaryFolder folder;
  const std::string model = (from / "gait2354_simbody.osim").string();
  Arguments arguments = {"run",     "--c3d", (from / "subject01_walk1.trc").string(),
                         "--model", model,   "--from",
                         "0.4",     "--to",  "0.5",
                         "--out",   "r"};
  const Outcome refused = run_sinew(folder.path(), arguments);
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_EQ(error_line(refused, folder.path()),
            model +
                ": has no markers that could be held against the recording's. Give "
                "--marker-set FILE.xml, or a model with markers.");
  arguments.insert(arguments.end(),
                   {"--marker-set", (from / "gait2354_Scale_MarkerSet.xml").string()});
  const Outcome outcome = run_sinew(folder.path(), arguments);
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
}

}  // namespace
}  // namespace sinew
