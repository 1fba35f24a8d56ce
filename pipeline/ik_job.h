#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "data/marker_trajectories.h"
#include "data/time_table.h"
#include "data/tool_setup.h"
#include "data/verdict_reason.h"
#include "dynamics/coordinate_table.h"
#include "ik/filled_weights.h"
#include "ik/tracking.h"
#include "ik/undetermined_stretches.h"
#include "model/kinematic_tree.h"
#include "model/musculoskeletal_model.h"
#include "pipeline/output_check.h"

namespace sinew {

/// The part of a record to solve [s]; its ends where empty.
struct TimeRange {
  std::optional<double> from, to;
  SourceLocation at;  // of the setup that says so; no file where the command line does

  /// Takes from a setup what the command line left open.
  void fill(std::optional<double> setup_from, std::optional<double> setup_to,
            const SourceLocation& setup_at);
};

/// What an inverse kinematics run starts from, gathered from the command line and a setup file.
struct IkInputs {
  std::filesystem::path model_file, marker_file;
  std::filesystem::path task_file;  // of `tasks`, where they come from a file of their own
  std::optional<IkTaskSet> tasks;
  std::filesystem::path coordinate_file;  // for tasks that take values from a file; may be empty
  TimeRange range;
  std::string method = "gauss-newton";
  double tolerance = MinimizerOptions{}.gradient_tolerance;
  int starts = ColdStartOptions{}.starts;
  WireOptions wires;
  bool name_unmatched = true;   // as BindingOptions'
  bool check_recording = true;  // for exchanged names and frozen frames; false where others did
  std::filesystem::path filled_file;     // which samples were filled in; may be empty
  double filled_weight = kFilledWeight;  // of these, where nothing tells how well
  bool leave_out_spikes = true;          // of markers (data/marker_spikes.h)
  // What markers of the model are called in the recording, where that is something else.
  std::map<std::string, std::string> recorded_names;
  double reach = 0.0;  // as far as filters carry what is filled into a gap [s]
  int threads = 0;
  bool record_iterations = false;  // for a trace
};

/// Everything read and bound, ready to be solved.
struct IkJob {
  MusculoskeletalModel model;
  KinematicTree tree;
  MarkerFile recording;
  TrackingProblem tracking;
  TrackingOptions options;
  bool check_recording = true;                        // IkInputs'
  int reach = 0;                                      // IkInputs' in frames
  std::map<std::string, std::string> recorded_names;  // IkInputs'
  std::vector<Warning> warnings;                      // of reading and binding
  // Complete after solve_ik():
  std::vector<UndeterminedStretch> stretches;
  std::vector<VerdictReason> reasons;  // of gaps
};

/// A marker of the model as its user knows it: `LKNE (the model's LLFC)`.
std::string shown_marker(const std::map<std::string, std::string>& recorded_names,
                         const std::string& name);

/// The files among the inputs, for check_output and summary.json.
InputFiles input_files(const IkInputs& inputs);

/// Reads model, markers and tasks and binds them. Throws InputError for unusable input and for a
/// time range without frames.
IkJob prepare_ik(const IkInputs& inputs);

/// Solves the job with a progress bar, a second time where markers are missing that the pose hangs
/// on (ik/undetermined_stretches.h), and adds job.reasons; nothing if Ctrl-C stopped it, which is
/// said on standard error. Throws std::runtime_error if a result is not finite.
std::optional<TrackingResult> solve_ik(IkJob& job);

/// Frames of `time` within the range, to a thousandth of a step; first and one past the last.
/// Warns where the range reaches more than a step beyond the record. Throws InputError, naming
/// what says the range and `file`, if it ends before it begins or if it holds no frame.
std::pair<int, int> frames_within(const Eigen::VectorXd& time, const TimeRange& range,
                                  const std::string& file, std::vector<Warning>& warnings);

/// The solution as ik.mot has it: a column a coordinate, angles in degrees.
TimeTable coordinate_motion(const MusculoskeletalModel& model, const TrackingResult& result);

/// The solution as inverse dynamics takes it.
CoordinateTable coordinate_table(const MusculoskeletalModel& model, const TrackingResult& result);

/// The same with recorded frames before and after the range that was solved, up to `seconds` of
/// them, so that filters and derivatives end beside it: as many as have all the markers that the
/// range's end has. They are solved for themselves and shifted onto its first and last frame, which
/// keeps whole turns. Nothing if Ctrl-C stopped it, which is said on standard error.
std::optional<CoordinateTable> motion_around(const IkJob& job, const TrackingResult& result,
                                             double seconds);

/// Throws InputError at the setup's own line if it names no file or one that does not exist;
/// `option` is what to give on the command line instead.
void require_file(const std::filesystem::path& file, const SourceLocation& named_at,
                  const std::string& element, const std::string& option);

/// Throws InputError at the setup's own line if an output path is one of another system, `C:\...`,
/// which here would be the name of a file in the current folder.
void require_own_path(const std::filesystem::path& output, const SourceLocation& named_at,
                      const std::string& element);

}  // namespace sinew
