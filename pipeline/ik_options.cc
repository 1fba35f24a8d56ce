#include "pipeline/ik_options.h"

#include <fmt/format.h>

#include "pipeline/option_checks.h"

namespace sinew {

void IkOptions::add_to(CLI::App& command) {
  command.add_option("--model", model, "OpenSim model (.osim)");
  command.add_option("--markers", markers, "Marker trajectories (.trc)");
  command.add_option(
      "--tasks", tasks,
      "IK tasks with the weight of each marker and coordinate (.xml); without, every "
      "marker weighs 1");
  command.add_option("--task-coordinates", coordinates,
                     "Motion file for tasks that take their values from a file");
  command.add_option("--from", from, "First time to solve [s]")->check(a_time());
  command.add_option("--to", to, "Last time to solve [s]")->check(a_time());
  command.add_option("--method", method, "One of " + method_names())->capture_default_str();
  command
      .add_option("--gradient-tolerance", tolerance,
                  "A frame has converged when no entry of the gradient exceeds this times the sum "
                  "of weights")
      ->check(more_than_zero())
      ->capture_default_str();
  command
      .add_option("--starts", starts,
                  "Most starts of the search for the lowest minimum where no solved frame leads to "
                  "a frame; 1: the default pose alone")
      ->check(a_start_count())
      ->capture_default_str();
  command
      .add_option(
          "--wires", wires,
          "Whether muscles, tendons and ligaments may not exceed their natural length: all, "
          "none or auto, in models with virtual links")
      ->check(CLI::IsMember({"auto", "all", "none"}))
      ->capture_default_str();
  const auto weight = [&](const char* name, double& value, const char* text) {
    command.add_option(name, value, text)->check(zero_or_more())->capture_default_str();
  };
  weight("--wire-penalty", wire_options.penalty, "Weight of wires against markers");
  weight("--muscle-weight", wire_options.muscle_weight, "Of muscles among the wires");
  weight("--tendon-weight", wire_options.tendon_weight, "Of tendons among the wires");
  weight("--ligament-weight", wire_options.ligament_weight, "Of ligaments among the wires");
  weight("--virtual-link-weight", wire_options.virtual_link_weight,
         "Draws virtual links to their places where wires leave them free");
  command.add_option("--filled", filled,
                     "List of the markers' samples that were filled in, as `sinew convert` and "
                     "`sinew run --c3d` write it (.csv); they weigh less");
  command
      .add_option(
          "--filled-weight", filled_weight,
          "What a filled sample weighs beside a measured one where nothing tells how well it "
          "was filled, 0 to 1; one off by less than 15 mm weighs more")
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str();
  command
      .add_option("--spikes", spikes,
                  "Markers that are for a moment where they cannot be: auto takes them as not "
                  "measured then, none takes all as measured")
      ->check(CLI::IsMember({"auto", "none"}))
      ->capture_default_str();
  command.add_option("--trace", trace, "Write cost, gradient and step of every iteration (.csv)");
  command
      .add_option("--threads", threads, "Threads to use, 0 for all; results do not depend on it")
      ->check(a_thread_count())
      ->capture_default_str();
}

IkInputs IkOptions::inputs() const {
  IkInputs inputs;
  inputs.model_file = model;
  inputs.marker_file = markers;
  method_from_string(method);  // an unknown name is told before any file is read
  if (!tasks.empty()) inputs.tasks = read_ik_task_set(tasks);
  inputs.task_file = tasks;
  inputs.coordinate_file = coordinates;
  inputs.filled_file = filled;
  inputs.filled_weight = filled_weight;
  inputs.leave_out_spikes = spikes == "auto";
  inputs.range.from = from;
  inputs.range.to = to;
  inputs.method = method;
  inputs.tolerance = tolerance;
  inputs.starts = starts;
  inputs.wires = wire_options;
  inputs.wires.use = wires == "all"    ? WireOptions::Use::kAll
                     : wires == "none" ? WireOptions::Use::kNone
                                       : WireOptions::Use::kAuto;
  inputs.threads = threads;
  inputs.record_iterations = !trace.empty();
  return inputs;
}

void IkOptions::require_files(const IkInputs& inputs) const {
  if (inputs.model_file.empty()) throw std::invalid_argument("no model: give --model FILE.osim");
  if (inputs.marker_file.empty())
    throw std::invalid_argument("no markers: give --markers FILE.trc");
}

void merge(const IkSetup& setup, IkInputs& inputs) {
  if (inputs.model_file.empty()) {
    require_file(setup.model_file, location_of(setup, "model_file"), "model_file", "--model");
    inputs.model_file = setup.model_file;
  }
  if (inputs.marker_file.empty()) {
    require_file(setup.marker_file, location_of(setup, "marker_file"), "marker_file", "--markers");
    inputs.marker_file = setup.marker_file;
  }
  if (inputs.coordinate_file.empty() && !setup.coordinate_file.empty()) {
    require_file(setup.coordinate_file, location_of(setup, "coordinate_file"), "coordinate_file",
                 "--task-coordinates");
    inputs.coordinate_file = setup.coordinate_file;
  }
  // An empty task set means what no task set means: every marker weighs 1.
  if (!inputs.tasks && !setup.task_set.tasks.empty()) inputs.tasks = setup.task_set;
  inputs.range.fill(setup.from, setup.to, location_of(setup, "time_range"));
}

}  // namespace sinew
