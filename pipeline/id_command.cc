#include <fmt/format.h>

#include "data/storage_file.h"
#include "data/tool_setup.h"
#include "dynamics/coordinate_table.h"
#include "model/osim_file.h"
#include "pipeline/command.h"
#include "pipeline/dynamics_evidence.h"
#include "pipeline/filter_reasons.h"
#include "pipeline/id_job.h"
#include "pipeline/id_options.h"
#include "pipeline/ik_job.h"
#include "pipeline/load_placement.h"
#include "pipeline/motion_reasons.h"
#include "pipeline/option_checks.h"
#include "pipeline/output_check.h"
#include "pipeline/undetermined.h"
#include "pipeline/verdict_evidence.h"
#include "pipeline/verdict_reasons.h"
#include "pipeline/verdict_report.h"

namespace sinew {
namespace {

struct IdCommand {
  std::string setup, model, coordinates, out;
  IdOptions dynamics;
  TimeRange range;
  int threads = 0;
  bool accept = false;
  std::optional<double> setup_cutoff;  // [Hz]

  // What the command line left open comes from the setup.
  void merge(const IdSetup& tool) {
    const auto fill = [&](std::string& option, const std::filesystem::path& file,
                          const char* element, const char* name) {
      if (!option.empty()) return;
      require_file(file, location_of(tool, element), element, name);
      option = file.string();
    };
    fill(model, tool.model_file, "model_file", "--model");
    fill(coordinates, tool.coordinates_file, "coordinates_file", "--coordinates");
    if (!tool.external_loads_file.empty()) {
      fill(dynamics.loads, tool.external_loads_file, "external_loads_file", "--loads");
    }
    if (out.empty()) {
      require_own_path(tool.output_file, location_of(tool, "results_directory"),
                       "results_directory");
      out = tool.output_file.string();
    }
    range.fill(tool.from, tool.to, location_of(tool, "time_range"));
    setup_cutoff = tool.cutoff;
  }

  void require_options() const {
    if (model.empty()) throw std::invalid_argument("no model: give --model FILE.osim");
    if (coordinates.empty()) {
      throw std::invalid_argument("no coordinates: give --coordinates FILE.mot");
    }
    if (out.empty()) throw std::invalid_argument("no output file: give --out FILE.sto");
  }

  InputFiles inputs() const {
    return {{"setup", setup},
            {"model", model},
            {"coordinates", coordinates},
            {"loads", dynamics.loads},
            {"load_data", dynamics.load_data}};
  }

  int run() {
    std::vector<Warning> warnings;
    if (!setup.empty()) {
      const IdSetup tool = read_id_setup(setup);
      report(warnings, tool.warnings);
      merge(tool);
    }
    require_options();
    check_outputs({out, verdict_path(out)}, inputs());
    const MusculoskeletalModel description = read_osim(model);
    report(warnings, description.warnings);
    const TimeTableFile motion_file = read_storage(coordinates);
    std::vector<std::string> undetermined = undetermined_in(motion_file.table);
    std::erase_if(undetermined,
                  [&](const std::string& name) { return description.find_coordinate(name) < 0; });
    const CoordinateTable motion = coordinate_table(description, motion_file);
    report(warnings, motion.warnings);
    IdJob job = prepare_id(description, dynamics, setup_cutoff, threads, warnings);
    check_outputs({out, verdict_path(out)}, {{"load_data", job.load_data_file}});
    std::vector<Warning> of_range;
    const auto [first, end] = frames_within(motion.time, range, coordinates, of_range);
    report(warnings, of_range);
    job.options.from = motion.time[first];
    job.options.to = motion.time[end - 1];
    std::optional<InverseDynamicsResult> result = solve_id(description, motion, job);
    if (!result) return kExitFailed;
    report(warnings, result->warnings);
    if (!undetermined.empty()) {
      report(warnings,
             {{{coordinates},
               fmt::format("no marker told {} of its columns: torques of {} cannot be used",
                           undetermined.size(), some_names(undetermined))}});
      mark_undetermined(undetermined, result->forces);
    }
    write_storage(out, result->forces);
    const VerdictEvidence evidence = gather(description, motion, result->forces, job);
    const Verdict verdict = judge(evidence);
    write_verdict(verdict_path(out), verdict);
    const std::string root = root_text(*evidence.dynamics);
    fmt::print("{} frames, coordinates {}\n{}{}{}{}\n", result->forces.time.size(),
               filter_text(job.options.cutoff), root, root.empty() ? "" : "\n",
               verdict_text(verdict, kMostLines - 3), out);
    return exit_code(verdict, accept);
  }

  static VerdictEvidence gather(const MusculoskeletalModel& description,
                                const CoordinateTable& motion, const TimeTable& forces,
                                const IdJob& job) {
    VerdictEvidence evidence;
    evidence.joints = joint_evidence(description);
    evidence.torques = true;
    evidence.model = model_evidence(description);
    evidence.dynamics = dynamics_evidence(description, forces, job.loads, {});
    evidence.dynamics->not_given = coordinates_not_given(description, motion);
    // Loads say nothing beyond the frames that were solved.
    Eigen::Index first = 0;
    while (motion.time[first] < job.options.from) ++first;
    const Eigen::Index count = std::min(forces.time.size(), motion.time.size() - first);
    evidence.found =
        load_placement_reasons(description,
                               load_placements(description, motion.time.segment(first, count),
                                               motion.q.middleRows(first, count), job.loads),
                               evidence.dynamics->supporting);
    append(evidence.found, angle_filter_reasons(description, motion, job.options.cutoff));
    append(evidence.found, motion_reasons(description, motion));
    return evidence;
  }
};

}  // namespace

void add_id_command(CLI::App& app, int& exit_code) {
  auto command = std::make_shared<IdCommand>();
  CLI::App* sub = app.add_subcommand("id", "Joint angles and ground forces to joint torques");
  sub->add_option("--setup", command->setup,
                  "OpenSim InverseDynamicsTool setup; options given here take precedence over it");
  sub->add_option("--model", command->model, "OpenSim model (.osim)");
  sub->add_option("--coordinates", command->coordinates,
                  "Joint angles (.mot or .sto), in degrees or radians as their header says");
  command->dynamics.add_to(*sub);
  sub->add_option("--from", command->range.from, "First time to solve [s]")->check(a_time());
  sub->add_option("--to", command->range.to, "Last time to solve [s]")->check(a_time());
  sub->add_option("--threads", command->threads,
                  "Threads to use, 0 for all; results do not depend on it")
      ->check(a_thread_count())
      ->capture_default_str();
  sub->add_option("--out", command->out, "Generalized forces to write (.sto) [N m, N]");
  sub->add_flag("--accept", command->accept, kAcceptHelp);
  sub->callback([command, &exit_code] { exit_code = command->run(); });
}

}  // namespace sinew
