#include "pipeline/id_options.h"

#include <fmt/format.h>

#include "pipeline/command.h"
#include "pipeline/option_checks.h"

namespace sinew {

void IdOptions::add_to(CLI::App& command) {
  command.add_option("--loads", loads,
                     "OpenSim ExternalLoads (.xml): forces [N], points [m] and torques [N m]");
  command.add_option("--load-data", load_data,
                     "Force data (.mot or .sto) instead of the one that --loads names");
  command
      .add_option("--cutoff", cutoff,
                  fmt::format("Zero-lag low-pass of the coordinates before they are differentiated "
                              "[Hz]; negative for none; {} unless given here or in a setup",
                              kDefaultCutoff))
      ->check(a_cutoff());
  command
      .add_option("--force-spikes", force_spikes,
                  "Samples of forces that no force makes: auto leaves them out, none does not")
      ->check(CLI::IsMember({"auto", "none"}))
      ->capture_default_str();
  command.add_flag("--project-couplers", project_couplers,
                   "Fold the forces of coupled coordinates onto the coordinates that drive them");
  command.add_flag("--exact-custom-joints", exact_custom_joints,
                   "Correct Simbody's accelerations of custom joints; without, torques are those "
                   "that OpenSim gives");
}

InverseDynamicsOptions IdOptions::dynamics(std::optional<double> setup_cutoff, int threads) const {
  InverseDynamicsOptions options;
  options.cutoff = cutoff.value_or(setup_cutoff.value_or(kDefaultCutoff));
  options.project_couplers = project_couplers;
  options.exact_custom_joints = exact_custom_joints;
  options.threads = threads;
  return options;
}

std::string filter_text(double cutoff) {
  return cutoff > 0.0 ? fmt::format("low-passed at {} Hz", cutoff) : "not filtered";
}

}  // namespace sinew
