#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "dynamics/external_loads.h"
#include "dynamics/inverse_dynamics.h"
#include "model/musculoskeletal_model.h"
#include "pipeline/id_options.h"

namespace sinew {

/// Inverse dynamics as a subcommand asks for it, with everything read.
struct IdJob {
  ExternalLoads loads;
  std::filesystem::path load_data_file;  // empty without loads
  InverseDynamicsOptions options;
};

/// Reads the ExternalLoads and the data that `options` name and prints warnings. Without, there are
/// no loads and a warning that the root's residuals will carry the body's weight.
IdJob prepare_id(const MusculoskeletalModel& model, const IdOptions& options,
                 std::optional<double> setup_cutoff, int threads, std::vector<Warning>& warnings);

/// Asks before the motion is known whether its inverse dynamics can be solved: throws InputError
/// naming `file` if these times are too few or too far apart for the cutoff, or if the loads do not
/// cover them.
void check_motion_times(const Eigen::VectorXd& time, const IdJob& job, const std::string& file);

/// Solves the job with a progress bar; nothing if Ctrl-C stopped it, which is said on standard
/// error. Throws std::runtime_error if a result is not finite.
std::optional<InverseDynamicsResult> solve_id(const MusculoskeletalModel& model,
                                              const CoordinateTable& motion, IdJob& job);

}  // namespace sinew
