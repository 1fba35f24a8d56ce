#include <fmt/format.h>

#include "data/storage_file.h"
#include "dynamics/coordinate_table.h"
#include "model/osim_file.h"
#include "pipeline/command.h"
#include "pipeline/id_job.h"
#include "pipeline/ik_job.h"

namespace sinew {
namespace {

struct IdCommand {
  std::string setup, model, coordinates, loads, load_data, out;
  std::optional<double> from, to, cutoff;
  bool project_couplers = false;
  int threads = 0;

  // What the command line left open comes from the setup.
  void merge(const IdSetup& tool) {
    const auto fill = [&](std::string& option, const std::filesystem::path& file,
                          const char* element) {
      if (!option.empty()) return;
      require_file(file, location_of(tool, element), element);
      option = file.string();
    };
    fill(model, tool.model_file, "model_file");
    fill(coordinates, tool.coordinates_file, "coordinates_file");
    if (!tool.external_loads_file.empty()) {
      fill(loads, tool.external_loads_file, "external_loads_file");
    }
    if (out.empty()) out = tool.output_file.string();
    if (!from) from = tool.from;
    if (!to) to = tool.to;
    if (!cutoff) cutoff = tool.cutoff;
  }

  void require_options() const {
    if (model.empty()) throw std::invalid_argument("no model: give --model FILE.osim");
    if (coordinates.empty()) {
      throw std::invalid_argument("no coordinates: give --coordinates FILE.mot");
    }
    if (out.empty()) throw std::invalid_argument("no output file: give --out FILE.sto");
  }

  int run() {
    std::vector<Warning> warnings;
    if (!setup.empty()) {
      const IdSetup tool = read_id_setup(setup);
      warnings = tool.warnings;
      merge(tool);
    }
    require_options();
    const MusculoskeletalModel description = read_osim(model);
    const CoordinateTable motion = coordinate_table(description, read_storage(coordinates));
    std::filesystem::path data = load_data;
    const ExternalLoads external = read_loads(description, loads, data, warnings);
    const SimbodyModel compiled(description);
    InverseDynamicsOptions options;
    options.cutoff = cutoff.value_or(kDefaultCutoff);
    options.from = from;
    options.to = to;
    options.project_couplers = project_couplers;
    options.threads = threads;
    const InverseDynamicsResult result =
        inverse_dynamics(description, compiled, motion, external, options);
    for (const std::vector<Warning>* more :
         {&description.warnings, &motion.warnings, &result.warnings}) {
      warnings.insert(warnings.end(), more->begin(), more->end());
    }
    print_warnings(warnings);
    write_storage(out, result.forces);
    fmt::print("{} frames, coordinates {}\n{}\n", result.forces.time.size(),
               options.cutoff > 0.0 ? fmt::format("low-passed at {} Hz", options.cutoff)
                                    : std::string("not filtered"),
               out);
    return kExitOk;
  }
};

}  // namespace

void add_id_command(CLI::App& app, int& exit_code) {
  auto command = std::make_shared<IdCommand>();
  CLI::App* sub = app.add_subcommand("id", "Joint angles and ground forces to joint torques");
  sub->add_option("--setup", command->setup,
                  "OpenSim InverseDynamicsTool setup; options given here take precedence over it");
  sub->add_option("--model", command->model, "OpenSim model (.osim)");
  sub->add_option("--coordinates", command->coordinates, "Joint angles (.mot or .sto)");
  sub->add_option("--loads", command->loads, "OpenSim ExternalLoads (.xml)");
  sub->add_option("--load-data", command->load_data,
                  "Force data (.mot or .sto) instead of the one that --loads names");
  sub->add_option(
      "--cutoff", command->cutoff,
      fmt::format("Zero-lag low-pass of the coordinates [Hz], negative for none; {} without "
                  "a setup",
                  kDefaultCutoff));
  sub->add_option("--from", command->from, "First time to solve [s]");
  sub->add_option("--to", command->to, "Last time to solve [s]");
  sub->add_flag("--project-couplers", command->project_couplers,
                "Fold the forces of coupled coordinates onto the coordinates that drive them");
  sub->add_option("--threads", command->threads,
                  "Threads to use, 0 for all; results do not depend on it")
      ->capture_default_str();
  sub->add_option("--out", command->out, "Generalized forces to write (.sto) [N m, N]");
  sub->callback([command, &exit_code] { exit_code = command->run(); });
}

}  // namespace sinew
