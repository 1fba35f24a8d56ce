#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "data/time_table.h"
#include "ik/tracking.h"
#include "model/musculoskeletal_model.h"
#include "pipeline/output_check.h"

namespace sinew {

/// How well one marker was met over all frames.
struct MarkerError {
  std::string name;
  double weight = kNaN;
  int measured = 0;               // frames
  double rms = kNaN, max = kNaN;  // [m]
  double time_of_max = kNaN;      // [s]
};

std::vector<MarkerError> marker_errors(const TrackingProblem& tracking,
                                       const TrackingResult& result);

/// marker_errors.csv: a row a marker.
std::string marker_errors_csv(const std::vector<MarkerError>& errors);

/// frame_errors.csv: a row a frame: cost, RMS and largest marker error, worst marker, iterations,
/// how the frame ended, then the error of every marker [m], empty where it was not measured.
std::string frame_errors_csv(const TrackingProblem& tracking, const TrackingResult& result);

/// A search for the lowest minimum: starts, lowest and second-lowest cost.
nlohmann::ordered_json search_json(const ColdStartResult& search);

/// The part of summary.json about inverse kinematics.
nlohmann::ordered_json ik_summary(const TrackingProblem& tracking, const TrackingResult& result,
                                  const TrackingOptions& options);

/// The part about inverse dynamics: RMS and largest residual of every coordinate of the joints that
/// connect the model to ground, where no actuator acts and a perfect recording would give zero.
nlohmann::ordered_json id_summary(const MusculoskeletalModel& model, const TimeTable& forces);

/// Paths and SHA-256 of input files; empty paths are left out.
nlohmann::ordered_json input_summary(const InputFiles& files);

nlohmann::ordered_json warning_summary(const std::vector<Warning>& warnings);

/// RMS over all measured markers and frames [m].
double total_marker_rms(const TrackingResult& result);

/// Frames that did not converge.
int unconverged_frames(const TrackingResult& result);

/// Names the frames that did not converge, and those in which no marker is measured. `file`: of the
/// recording.
std::vector<Warning> frame_warnings(const TrackingResult& result, const std::string& file);

}  // namespace sinew
