#pragma once

#include <cmath>
#include <filesystem>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "data/storage_file.h"
#include "data/tool_setup.h"
#include "data/trc_file.h"
#include "ik/tracking.h"
#include "model/osim_file.h"

/// Recordings with published inverse kinematics, where ../shared/data holds them.
namespace sinew {

inline const std::filesystem::path kPublishedData = "../shared/data";

struct PublishedFiles {
  std::string name;
  std::filesystem::path model, markers, tasks, coordinates;  // relative to kPublishedData
  bool in_degrees = true;                                    // what the coordinates' angles are in
  bool exact_markers = false;  // made from the published coordinates, without noise
};

inline std::vector<PublishedFiles> published_files() {
  const std::filesystem::path gait2354 = "opensim-models/Gait2354_Simbody";
  const std::filesystem::path gait10 = "opensim-models/Gait10dof18musc";
  const std::filesystem::path core = "opensim-core/Applications/IK/tests/resources";
  const std::filesystem::path arnold = "nimblephysics/Arnold2013Synthetic";
  const auto synthetic = [&](const std::string& subject) {
    return PublishedFiles{"Arnold2013 " + subject,
                          arnold / subject / (subject + ".osim"),
                          arnold / subject / "trials/walk2/markers.trc",
                          "",
                          arnold / subject / "coordinates.sto",
                          false,
                          true};
  };
  return {
      {"Gait2354", gait2354 / "subject01_simbody.osim", gait2354 / "subject01_walk1.trc",
       gait2354 / "subject01_Setup_IK.xml", gait2354 / "reference/subject01_walk1_ik.mot"},
      {"Gait10dof18musc", gait10 / "subject01.osim", gait10 / "ExperimentalData/subject01_walk.trc",
       gait10 / "IK/walk_Setup_IK.xml", gait10 / "reference/subject01_walk_IK.mot"},
      {"OpenSim's IK test", core / "subject01_simbody.osim",
       core / "subject01_synthetic_marker_data.trc", core / "gait2354_IK_Tasks_uniform.xml",
       core / "std_subject01_walk1_ik.mot"},
      synthetic("subject01"),
      synthetic("subject02"),
  };
}

inline bool is_present(const PublishedFiles& files) {
  return std::filesystem::exists(kPublishedData / files.model);
}

/// A published trial, bound and compiled.
struct PublishedTrial {
  std::string name;
  MusculoskeletalModel model;
  KinematicTree tree;
  MarkerFile recording;
  TrackingProblem tracking;
  int first_frame = -1;            // of the recording, that the first published row is for
  RowMatrix coordinates;           // published rows × coordinates of the model [rad or m]
  std::vector<bool> in_published;  // per coordinate of the model

  int frame_count() const { return static_cast<int>(coordinates.rows()); }
  TrackingOptions options() const {
    TrackingOptions result;
    result.first_frame = first_frame;
    result.end_frame = first_frame + frame_count();
    result.threads = 1;
    return result;
  }
};

// Columns by the model's names; coordinates without one stay at their default.
inline void set_published_coordinates(PublishedTrial& trial, const TimeTable& table,
                                      bool in_degrees) {
  const auto count = trial.model.coordinates.size();
  trial.coordinates.resize(table.time.size(), static_cast<Eigen::Index>(count));
  trial.in_published.assign(count, false);
  for (std::size_t c = 0; c < count; ++c) {
    const Coordinate& coordinate = trial.model.coordinates[c];
    const auto column = static_cast<Eigen::Index>(c);
    const int from = table.find_column(coordinate.name);
    trial.coordinates.col(column).setConstant(coordinate.default_value);
    if (from < 0) continue;
    trial.in_published[c] = true;
    const bool angle = coordinate.motion == Coordinate::Motion::kRotational;
    trial.coordinates.col(column) =
        (angle && in_degrees ? std::numbers::pi / 180.0 : 1.0) * table.values.col(from);
  }
}

inline PublishedTrial read_published(const PublishedFiles& files) {
  PublishedTrial trial;
  trial.name = files.name;
  trial.model = read_osim(kPublishedData / files.model);
  trial.tree = compile_tree(trial.model);
  trial.recording = read_trc(kPublishedData / files.markers);
  std::optional<IkTaskSet> tasks;
  if (!files.tasks.empty()) tasks = read_ik_task_set(kPublishedData / files.tasks);
  trial.tracking =
      bind_recording(trial.model, trial.tree, trial.recording, tasks ? &*tasks : nullptr, nullptr);
  const TimeTable table = read_storage(kPublishedData / files.coordinates).table;
  set_published_coordinates(trial, table, files.in_degrees);
  // Row i is for the frame i after the first; times are printed with seven digits.
  const Eigen::VectorXd& time = trial.recording.markers.time;
  (time.array() - table.time[0]).abs().minCoeff(&trial.first_frame);
  const Eigen::VectorXd shift = time.segment(trial.first_frame, table.time.size()) - table.time;
  if (!(shift.cwiseAbs().maxCoeff() < 2e-3)) {  // a quarter of the shortest frame at most
    throw std::runtime_error(trial.name + ": published rows are not at the recording's frames");
  }
  return trial;
}

}  // namespace sinew
