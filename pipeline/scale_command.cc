#include <fmt/format.h>

#include <memory>

#include "data/output_file.h"
#include "data/storage_file.h"
#include "data/trc_file.h"
#include "pipeline/command.h"
#include "pipeline/ik_job.h"
#include "pipeline/option_checks.h"
#include "pipeline/scale_job.h"
#include "pipeline/verdict_evidence.h"
#include "pipeline/verdict_report.h"

namespace sinew {
namespace {

namespace fs = std::filesystem;

// What is written where; empty: not at all.
struct ScaleOutputs {
  fs::path model, scaled_only, scale_set, motion, marker_set, json;

  fs::path verdict() const { return verdict_path(model.empty() ? scaled_only : model); }

  std::vector<fs::path> all() const {
    return {model, scaled_only, scale_set, motion, marker_set, json, verdict()};
  }
};

constexpr const char* kTechnicalHelp =
    "--auto: markers A,B,... on wands and in clusters, that sit anywhere; or none; their names "
    "(THI, TIB, Shank...) tell unless given";

// What --auto adds.
struct AutoOptions {
  bool use = false, uniform = false, free_sides = false;
  std::vector<std::string> markers, groups;
  std::optional<std::string> technical;
  AutoScaleOptions options;

  void add_to(CLI::App& command) {
    const auto number = [&](const char* name, double& value, const char* text) {
      command.add_option(name, value, text)->check(more_than_zero())->capture_default_str();
    };
    command.add_flag("--auto", use,
                     "Fit segment sizes and marker places to the recordings, instead of measuring");
    command.add_option("--markers", markers, "Movements to fit with --auto (.trc)");
    command.add_flag("--uniform", uniform, "--auto: one factor a segment, not one an axis");
    command.add_flag("--free-sides", free_sides, "--auto: left and right sizes may differ");
    command.add_option("--group", groups, "--auto: bodies a,b,c share their factors; repeatable");
    number("--size-sd", options.size_sd, "--auto: prior s.d. of the whole body's size, a fraction");
    number("--segment-sd", options.segment_sd, "--auto: of a segment's size beyond that");
    number("--axis-sd", options.axis_sd, "--auto: of an axis beyond its segment");
    number("--offset-sd", options.marker_offset_sd,
           "--auto: of a marker from its place in the model [m]");
    command.add_option("--technical", technical, kTechnicalHelp);
    number("--technical-sd", options.technical_marker_sd,
           "--auto: of a technical marker from its place in the model [m]");
    number("--marker-sd", options.marker_sd,
           "--auto: of a marker in a frame from its place on the bone [m]");
    number("--posture-sd", options.posture_sd,
           "--auto: of a joint that the markers do not determine from its default [rad]");
    number("--independent-frames", options.independent_frames,
           "--auto: a recording counts as no more than this many independent frames");
    command.add_option("--frames", options.frames, "--auto: frames of a recording to use")
        ->check(CLI::Range(1, 100000))
        ->capture_default_str();
    command.add_option("--threads", options.threads, "--auto: threads to use, 0 for all")
        ->check(a_thread_count())
        ->capture_default_str();
  }

  AutoScaleOptions gather() const {
    AutoScaleOptions result = options;
    result.axes = uniform ? AutoScaleOptions::Axes::kUniform : AutoScaleOptions::Axes::kEach;
    result.tie_sides = !free_sides;
    for (const std::string& group : groups) result.groups.push_back(split_names(group));
    result.progress = progress_bar("fitting sizes", "steps at most");
    return result;
  }
};

struct ScaleCommand {
  AutoOptions automatic;
  std::string setup_file, model, marker_set, static_trial, factors, tasks, coordinates, name;
  std::string out, out_dir, scale_set, motion, json;
  std::optional<double> mass, from, until;
  int starts = ColdStartOptions{}.starts;
  bool preserve_masses = false, keep_markers = false, accept = false;

  MarkerPlacementOptions placement_options() const {
    MarkerPlacementOptions options;
    options.cold_start.starts = starts;
    return options;
  }

  // Setup and options in one; what the command line says goes first.
  ScaleSetup gather() const {
    ScaleSetup setup;
    if (!setup_file.empty()) {
      setup = read_scale_setup(setup_file);
    } else {
      setup.placer.apply = !static_trial.empty();
      setup.scaler.apply = true;
    }
    if (!model.empty()) setup.generic.model_file = model;
    if (!marker_set.empty()) setup.generic.marker_set_file = marker_set;
    if (!name.empty()) setup.name = name;
    if (mass) setup.mass = mass;
    if (preserve_masses) setup.scaler.preserve_mass_distribution = true;
    if (keep_markers) setup.placer.apply = false;
    if (!factors.empty()) {
      setup.scaler.manual =
          factors.ends_with(".xml") ? read_scale_set(factors) : read_scale_table(factors);
      setup.scaler.order.push_back(ModelScalerSetup::Step::kManual);
    }
    if (!tasks.empty()) setup.placer.task_set = read_ik_task_set(tasks);
    if (!coordinates.empty()) setup.placer.coordinate_file = coordinates;
    if (!static_trial.empty()) {
      setup.scaler.marker_file = setup.placer.marker_file = static_trial;
    }
    for (std::optional<double>* time : {&setup.scaler.from, &setup.placer.from}) {
      if (from) *time = from;
    }
    for (std::optional<double>* time : {&setup.scaler.to, &setup.placer.to}) {
      if (until) *time = until;
    }
    if (setup.generic.model_file.empty() && setup_file.empty()) {
      throw std::invalid_argument("no model: give --model FILE.osim, or --setup FILE.xml");
    }
    require_files(
        setup, {!model.empty(), !marker_set.empty(), !static_trial.empty(), !coordinates.empty()});
    return setup;
  }

  // A path of the setup, moved to --out-dir if that was given.
  template <typename Step>
  fs::path placed(const Step& step, const fs::path& path, const char* element) const {
    if (path.empty()) return path;
    if (!out_dir.empty()) return fs::path(out_dir) / path.filename();
    require_own_path(path, location_of(step, element), element);
    return path;
  }

  ScaleOutputs outputs(const ScaleSetup& setup) const {
    ScaleOutputs to;
    const fs::path scaled_model =
        setup.scaler.apply
            ? placed(setup.scaler, setup.scaler.output_model_file, "output_model_file")
            : fs::path();
    if (setup.placer.apply) {
      to.scaled_only = scaled_model;
      to.model = placed(setup.placer, setup.placer.output_model_file, "output_model_file");
      to.motion = placed(setup.placer, setup.placer.output_motion_file, "output_motion_file");
      to.marker_set = placed(setup.placer, setup.placer.output_marker_file, "output_marker_file");
    } else {
      to.model = scaled_model;
    }
    if (setup.scaler.apply) {
      to.scale_set = placed(setup.scaler, setup.scaler.output_scale_file, "output_scale_file");
    }
    if (!out.empty()) to.model = out;
    if (!scale_set.empty()) to.scale_set = scale_set;
    if (!motion.empty()) to.motion = motion;
    to.json = json;
    if (to.model.empty() && to.scaled_only.empty()) {
      throw std::invalid_argument(
          "no output file: give --out FILE.osim, or name <output_model_file> in the setup");
    }
    return to;
  }

  int run() const { return automatic.use ? run_auto() : run_setup(); }

  int run_auto() const {
    if (!setup_file.empty() || !factors.empty()) {
      throw std::invalid_argument(
          "--auto finds the factors itself: leave out --setup and --factors");
    }
    if (model.empty()) throw std::invalid_argument("no model: give --model FILE.osim");
    std::vector<std::string> recordings = automatic.markers;
    if (!static_trial.empty()) recordings.insert(recordings.begin(), static_trial);
    if (recordings.empty()) {
      throw std::invalid_argument(
          "no recording: give --static FILE.trc, --markers FILE.trc or both");
    }
    ScaleOutputs to;
    to.model = out;
    to.scale_set = scale_set;
    to.json = json;
    if (to.model.empty()) throw std::invalid_argument("no output file: give --out FILE.osim");
    InputFiles inputs = {{"model", model}, {"marker_set", marker_set}};
    AutoScaleJob job;
    job.model_file = model;
    job.marker_set_file = marker_set;
    job.name = name;
    job.mass = mass;
    job.preserve_mass_distribution = preserve_masses;
    job.from = from;
    job.to = until;
    job.options = automatic.gather();
    job.options.cold_start.starts = starts;
    if (automatic.technical) job.technical = split_names(*automatic.technical);
    for (const std::string& recording : recordings) inputs.emplace_back("markers", recording);
    check_outputs(to.all(), inputs);
    for (const std::string& recording : recordings) job.trials.push_back(read_trc(recording));
    const ScaledModel scaled = run_auto_scale(job);
    if (scaled.automatic->stopped) {
      fmt::print(stderr, "stopped; no results were written\n");
      return kExitFailed;
    }
    std::vector<Warning> warnings;
    report(warnings, scaled.warnings);
    return write(scaled, to);
  }

  int run_setup() const {
    const ScaleSetup setup = gather();
    std::vector<Warning> warnings;
    report(warnings, setup.warnings);
    const ScaleOutputs to = outputs(setup);
    if (!to.motion.empty() && !setup.placer.apply) {
      throw std::invalid_argument("--motion needs the static pose: give --static FILE.trc");
    }
    check_outputs(to.all(), input_files(setup));
    const ScaledModel scaled = run_scale({setup, std::nullopt, placement_options()});
    report(warnings, scaled.warnings);
    return write(scaled, to);
  }

  // Returns the exit code.
  int write(const ScaledModel& scaled, const ScaleOutputs& to) const {
    const MusculoskeletalModel& model = scaled.document.model();
    const auto write = [](const fs::path& path, const std::string& content) {
      if (!path.empty()) write_file_atomically(path, content);
    };
    write(to.scaled_only, scaled.scaled_only);
    write(to.model, scaled.document.to_string());
    if (!to.scale_set.empty()) write(to.scale_set, write_scale_set(applied_scales(scaled)));
    if (!to.marker_set.empty()) write(to.marker_set, write_marker_set(model));
    if (!to.motion.empty() && scaled.placement) {
      write_storage(to.motion, static_motion(model, *scaled.placement));
    }
    VerdictEvidence evidence;
    evidence.joints = joint_evidence(model);
    evidence.model = model_evidence(model);
    evidence.scale = scale_evidence(scaled);
    evidence.found = scaled.reasons;
    // The limits of sizes are people's.
    if (!evidence.model.stands) {
      std::erase_if(evidence.found, [](const VerdictReason& r) { return r.code == "size-limit"; });
    }
    const Verdict verdict = judge(evidence);
    write_verdict(to.verdict(), verdict);
    if (!to.json.empty()) {
      nlohmann::ordered_json summary = scale_json(scaled);
      summary["verdict"] = verdict_json(verdict);
      write(to.json, summary.dump(2) + "\n");
    }
    fmt::print("{}{}", scale_text(scaled), verdict_text(verdict, kMostLines / 2));
    for (const fs::path& path : to.all()) {
      if (!path.empty()) fmt::print("{}\n", path.string());
    }
    return exit_code(verdict, accept);
  }
};

}  // namespace

void add_scale_command(CLI::App& app, int& exit_code) {
  auto command = std::make_shared<ScaleCommand>();
  CLI::App* sub = app.add_subcommand("scale", "Fits a model's size, mass and markers to a subject");
  ScaleCommand& c = *command;
  sub->add_option("--setup", c.setup_file,
                  "OpenSim ScaleTool setup; options given here take precedence over it");
  sub->add_option("--model", c.model,
                  "Generic model (.osim), or a built-in body: whole-body or whole-body-detailed");
  sub->add_option("--marker-set", c.marker_set, "Markers to add to the model (.xml)");
  sub->add_option("--static", c.static_trial, "Static trial (.trc)");
  sub->add_option("--mass", c.mass, "Mass of the subject [kg]")->check(more_than_zero());
  sub->add_flag("--preserve-masses", c.preserve_masses,
                "Bodies keep their shares of the mass, whatever their size");
  sub->add_option("--factors", c.factors,
                  "Scale factors: a table (.csv) of body,factor or body,x,y,z, or a scale set "
                  "(.xml); applied last");
  sub->add_option("--tasks", c.tasks,
                  "Weights of markers and coordinates in the static pose (.xml)");
  sub->add_option("--task-coordinates", c.coordinates,
                  "Motion file for tasks that take their values from a file");
  sub->add_flag("--keep-markers", c.keep_markers, "Leave the markers where scaling puts them");
  sub->add_option("--from", c.from, "First time of the static trial to use [s]")->check(a_time());
  sub->add_option("--to", c.until, "Last time of the static trial to use [s]")->check(a_time());
  sub->add_option("--name", c.name, "Name of the scaled model");
  sub->add_option("--starts", c.starts,
                  "Most starts of the search for a pose; 1: the default pose alone")
      ->check(a_start_count())
      ->capture_default_str();
  sub->add_option("--out", c.out, "Scaled model to write (.osim)");
  sub->add_option("--out-dir", c.out_dir, "Folder for the outputs that the setup names");
  sub->add_option("--scale-set", c.scale_set, "Write the factors applied, as a scale set (.xml)");
  sub->add_option("--motion", c.motion, "Write the static pose (.mot)");
  sub->add_option("--json", c.json, "Write factors, masses and marker distances (.json)");
  sub->add_flag("--accept", c.accept, kAcceptHelp);
  c.automatic.add_to(*sub);
  sub->callback([command, &exit_code] { exit_code = command->run(); });
}

}  // namespace sinew
