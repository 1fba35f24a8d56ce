#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "data/marker_trajectories.h"
#include "data/time_table.h"
#include "data/tool_setup.h"
#include "dynamics/coordinate_table.h"
#include "ik/tracking.h"
#include "model/kinematic_tree.h"
#include "model/musculoskeletal_model.h"

namespace sinew {

/// What an inverse kinematics run starts from, gathered from the command line and a setup file.
struct IkInputs {
  std::filesystem::path model_file, marker_file;
  std::optional<IkTaskSet> tasks;
  std::filesystem::path coordinate_file;  // for tasks that take values from a file; may be empty
  std::optional<double> from, to;         // [s]; the whole recording where empty
  std::string method = "gauss-newton";
  double tolerance = MinimizerOptions{}.gradient_tolerance;
  int threads = 0;
};

/// Everything read and bound, ready to be solved.
struct IkJob {
  MusculoskeletalModel model;
  KinematicTree tree;
  MarkerFile recording;
  TrackingProblem tracking;
  TrackingOptions options;
  std::vector<Warning> warnings;  // of reading and binding
};

/// Reads model, markers and tasks and binds them. Throws InputError for unusable input and for a
/// time range without frames.
IkJob prepare_ik(const IkInputs& inputs);

/// Frames of `time` within [from, to], to a thousandth of a step; first and one past the last.
/// Throws InputError, naming `file`, if there are none.
std::pair<int, int> frames_within(const Eigen::VectorXd& time, std::optional<double> from,
                                  std::optional<double> to, const std::string& file);

/// The solution as ik.mot has it: a column a coordinate, angles in degrees.
TimeTable coordinate_motion(const MusculoskeletalModel& model, const TrackingResult& result);

/// The solution as inverse dynamics takes it.
CoordinateTable coordinate_table(const MusculoskeletalModel& model, const TrackingResult& result);

/// Throws InputError at the setup's own line if a file that it names does not exist.
void require_file(const std::filesystem::path& file, const SourceLocation& named_at,
                  const std::string& element);

}  // namespace sinew
