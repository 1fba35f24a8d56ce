#include "pipeline/id_job.h"

#include <fmt/format.h>

#include "data/storage_file.h"
#include "data/tool_setup.h"
#include "pipeline/command.h"
#include "pipeline/ik_job.h"
#include "pipeline/output_check.h"
#include "pipeline/spikes.h"

namespace sinew {

IdJob prepare_id(const MusculoskeletalModel& model, const IdOptions& options,
                 std::optional<double> setup_cutoff, int threads, std::vector<Warning>& warnings) {
  IdJob job;
  job.options = options.dynamics(setup_cutoff, threads);
  if (options.loads.empty() && !options.load_data.empty()) {
    throw std::invalid_argument(
        "--load-data needs --loads, which says what its columns act on: give --loads FILE.xml");
  }
  if (options.loads.empty()) {
    report(warnings, {{{"inverse dynamics"},
                       "no external loads are given: whatever carries the body is missing, and the "
                       "root's residuals hold its weight; --loads FILE.xml gives them"}});
    return job;
  }
  ExternalLoadsSetup setup = read_external_loads(options.loads);
  job.load_data_file = options.load_data;
  if (options.load_data.empty()) {
    require_file(setup.data_file, location_of(setup, "datafile"), "datafile", "--load-data");
    job.load_data_file = setup.data_file;
  }
  TimeTableFile data = read_storage(job.load_data_file);
  bind_columns(setup, data.table.labels, job.load_data_file.string());
  if (options.force_spikes == "auto") {
    std::vector<Warning> left_out;
    leave_out_spikes(data.table, job.load_data_file.string(), left_out);
    report(warnings, left_out);
  }
  job.loads = ExternalLoads(model, setup, data);
  report(warnings, setup.warnings);
  report(warnings, data.warnings);
  report(warnings, job.loads.warnings());
  return job;
}

void check_motion_times(const Eigen::VectorXd& time, const IdJob& job, const std::string& file) {
  // A motion of one coordinate that stands still meets the same conditions at little cost.
  MusculoskeletalModel still;
  still.coordinates.resize(1);
  CoordinateTable motion;
  motion.path = file;
  motion.time = time;
  motion.q = RowMatrix::Zero(time.size(), 1);
  motion.measured = {true};
  motion_spline(still, motion, job.options.cutoff);
  job.loads.require_coverage(time[0], time[time.size() - 1]);
}

std::optional<InverseDynamicsResult> solve_id(const MusculoskeletalModel& model,
                                              const CoordinateTable& motion, IdJob& job) {
  job.options.progress = progress_bar("inverse dynamics");
  const SimbodyModel compiled(model);
  InverseDynamicsResult result = inverse_dynamics(model, compiled, motion, job.loads, job.options);
  if (result.stopped) {
    fmt::print(stderr, "stopped; no results were written\n");
    return std::nullopt;
  }
  require_finite_results(result.forces, "inverse dynamics");
  return result;
}

}  // namespace sinew
