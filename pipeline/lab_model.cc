#include "pipeline/lab_model.h"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

#include "data/carried_mass.h"
#include "data/input_file.h"
#include "data/marker_synonyms.h"
#include "data/output_file.h"
#include "model/osim_file.h"
#include "model/osim_writer.h"
#include "model/whole_body.h"
#include "pipeline/command.h"
#include "pipeline/scale_job.h"

namespace sinew {
namespace {

void set_mass(const ScaledModel& scaled, const std::optional<double>& mass) {
  double sum = 0.0;
  for (const Body& body : scaled.document.model().bodies) sum += body.mass;
  fmt::print("model: {:.1f} kg before, {:.1f} kg{}\n", scaled.mass_before, sum,
             mass ? " as the subject" : "");
}

std::string quality(const AutoScaleResult& fit) {
  int determinate = 0;
  for (const ScaleEstimate& estimate : fit.estimates) determinate += estimate.determinate ? 1 : 0;
  std::string text = fmt::format(
      "scale factors: {} of {} follow from the markers, the others from what people are like; "
      "marker RMS {:.1f} mm before, {:.1f} mm scaled, {:.1f} mm with markers moved",
      determinate, fit.estimates.size(), 1e3 * fit.rms_before, 1e3 * fit.rms_scaled,
      1e3 * fit.rms_after);
  if (fit.trials.size() == 2) {
    text += fmt::format(" ({:.1f} mm in the static trial, {:.1f} mm in the walk)",
                        1e3 * fit.trials[0].rms, 1e3 * fit.trials[1].rms);
  }
  return text;
}

Decision mass_decision(const std::vector<ForcePlatformRecording>& standing_plates,
                       const SubjectParameters& entered, const LabOptions& options) {
  Decision decision{"mass", {}, {}, "", {}, "", "--mass", Decision::Range::kAboveZero};
  if (!options.scale_setup.empty()) {
    const std::optional<double> mass = read_scale_setup(options.scale_setup).mass;
    if (mass) decision.found = *mass;
    decision.why = mass ? "[kg] the ScaleTool setup's" : "the ScaleTool setup does not say it";
  } else if (const std::optional<double> found = standing_mass(standing_plates)) {
    decision.found = *found;
    decision.why = "[kg] what the platforms carry in the static trial";
    decision.confidence = 0.9;
    if (entered.mass) {
      decision.why += fmt::format("; PROCESSING:BODYMASS of the walk is {:.1f}", *entered.mass);
    }
  } else if (entered.mass) {
    decision.found = *entered.mass;
    decision.why = "[kg] PROCESSING:BODYMASS of the trial";
  } else {
    decision.why =
        "neither --mass, standing on platforms nor the trial's file says it: the model's own";
  }
  return decision;
}

Decision scaling_decision(const GenericModel& generic, bool standing, const LabOptions& options,
                          bool mass_known) {
  Decision decision{"scaling", {}, {}, "", {}, "", "--scale"};
  if (!options.scale_setup.empty()) {
    decision.found = "setup";
    decision.why = "a ScaleTool setup was given";
  } else if (standing) {
    decision.found = "both";
    decision.why = "segments and marker places are fitted to the static trial and the walk";
  } else if (generic.built_in) {
    decision.found = "walk";
    decision.why = "there is no static trial; segments are fitted to the walk";
  } else {
    decision.found = mass_known ? "mass" : "none";
    decision.why = mass_known ? "there is no static trial: only masses are scaled"
                              : "there is neither a static trial nor a mass: the model is taken as "
                                "it is; --static and --mass fit it to the subject";
  }
  return decision;
}

ScaledModel scale_by_setup(const GenericModel& generic, const MarkerFile* standing,
                           const std::optional<double>& mass, const LabOptions& options) {
  ScaleJob job;
  job.setup = read_scale_setup(options.scale_setup);
  job.setup.generic.model_file = generic.file;
  job.setup.generic.marker_set_file.clear();  // the model has them already
  if (mass) job.setup.mass = *mass;
  if (standing != nullptr) job.static_trial = *standing;
  require_files(job.setup, {.model = true, .static_trial = standing != nullptr});
  return run_scale(job);
}

std::vector<std::string> settle_technical(const MusculoskeletalModel& model,
                                          const std::vector<MarkerFile>& trials, DecisionLog& log) {
  std::vector<std::string> tracked;
  for (const MarkerFile& trial : trials) {
    for (const std::string& name : trial.markers.names) {
      const bool known = std::find(tracked.begin(), tracked.end(), name) != tracked.end();
      if (!known && model.find_marker(name) >= 0) tracked.push_back(name);
    }
  }
  return log.settle_texts({"technical markers",
                           {},
                           technical_markers(tracked),
                           "called as those on wands and in clusters, which may sit anywhere",
                           {},
                           "",
                           "--technical"});
}

ScaledModel scale_by_markers(const GenericModel& generic, std::vector<MarkerFile> trials,
                             const std::optional<double>& mass, int threads, DecisionLog& log) {
  AutoScaleJob job;
  job.model_file = generic.file;
  job.mass = mass;
  job.trials = std::move(trials);
  // More would only take longer: together they weigh no more than so many independent ones.
  job.options.frames = static_cast<int>(job.options.independent_frames);
  job.options.threads = threads;
  job.options.name_unmatched = false;
  job.technical = settle_technical(generic.model, job.trials, log);
  job.options.progress = progress_bar("scaling", "steps at most");
  ScaledModel scaled = run_auto_scale(job);
  if (scaled.automatic && scaled.automatic->stopped) {
    throw std::runtime_error("stopped; nothing was solved");
  }
  return scaled;
}

std::string scale_by_mass(const GenericModel& generic, double mass,
                          std::vector<Warning>& warnings) {
  OsimDocument document(generic.file);
  ScaleOptions options;
  options.mass = mass;
  options.preserve_mass_distribution = true;
  report(warnings, document.scale(ScaleFactors(document.model()), options));
  return document.to_string();
}

// Where markers come from that the model does not have.
std::filesystem::path marker_set_file(const LabOptions& options) {
  if (!options.marker_set.empty()) return options.marker_set;
  if (options.scale_setup.empty()) return {};
  return read_scale_setup(options.scale_setup).generic.marker_set_file;
}

WholeBodyOptions settle_body(WholeBodyOptions body, const SubjectParameters& entered,
                             const LabOptions& options, DecisionLog& log) {
  Decision height{"height", {}, body.height, "[m] the built-in body's own",
                  {},       "", "--height",  Decision::Range::kAboveZero};
  if (entered.height) {
    height.found = *entered.height;
    height.why = "[m] PROCESSING:HEIGHT of the trial";
  }
  body.height = log.settle_number(height, !entered.height);
  body.mass = options.mass.value_or(body.mass);
  if (options.sex == "female") body.sex = WholeBodyOptions::Sex::kFemale;
  body.validate();
  return body;
}

// What the way of scaling needs.
void require_inputs(const std::string& by, const MarkerFile* standing, const LabOptions& options) {
  if ((by == "static" || by == "both") && standing == nullptr) {
    throw std::invalid_argument("scaling by the static trial needs --static FILE");
  }
  if (by == "setup" && options.scale_setup.empty()) {
    throw std::invalid_argument("scaling by a setup needs --scale-setup FILE.xml");
  }
}

}  // namespace

GenericModel generic_model(const std::string& name, const SubjectParameters& entered,
                           const LabOptions& options, const std::filesystem::path& folder,
                           DecisionLog& log) {
  GenericModel generic;
  const std::optional<WholeBodyOptions> body = find_whole_body(name);
  generic.built_in = body.has_value();
  generic.file = name;
  if (!body && (options.height || !options.sex.empty())) {
    throw std::invalid_argument(
        fmt::format("--height and --sex are for the built-in bodies; '{}' is a file", name));
  }
  const std::filesystem::path marker_set = marker_set_file(options);
  if (body || !marker_set.empty()) {
    OsimDocument document =
        body ? OsimDocument(name, write_osim(whole_body(settle_body(*body, entered, options, log))))
             : OsimDocument(name);
    if (!marker_set.empty()) document.merge_markers(marker_set);
    generic.file = folder / "model_generic.osim";
    write_file_atomically(generic.file, document.to_string());
  }
  generic.model = read_osim(generic.file);
  if (generic.model.markers.empty()) {
    throw InputError({name}, {"has no markers that could be held against the recording's", "", "",
                              "Give --marker-set FILE.xml, or a model with markers."});
  }
  return generic;
}

SettledModel settle_model(const GenericModel& generic, const MarkerFile& walk,
                          const MarkerFile* standing,
                          const std::vector<ForcePlatformRecording>& standing_plates,
                          const SubjectParameters& entered, const LabOptions& options, int threads,
                          const std::filesystem::path& file, DecisionLog& log,
                          std::vector<Warning>& warnings) {
  const std::optional<double> mass =
      log.settle_number_or_none(mass_decision(standing_plates, entered, options));
  if (options.no_scale) log.say("scaling", "none", options.given_now.contains("--no-scale"));
  const std::string by =
      log.settle_text(scaling_decision(generic, standing != nullptr, options, mass.has_value()));
  constexpr const char* kWays[] = {"both", "static", "walk", "setup", "mass", "none"};
  if (std::find(std::begin(kWays), std::end(kWays), by) == std::end(kWays)) {
    throw std::invalid_argument(fmt::format(
        "scaling is '{}'; expected both, static, walk, setup, mass or none: correct --scale or the "
        "decision 'scaling'",
        by));
  }
  if (by == "none") {
    write_file_atomically(file, read_file(generic.file));
    return {read_osim(file), by, mass, {}, {}};
  }
  if (by == "mass") {
    if (!mass) throw std::invalid_argument("scaling by mass needs --mass");
    write_file_atomically(file, scale_by_mass(generic, *mass, warnings));
    return {read_osim(file), by, mass, {}, {}};
  }
  require_inputs(by, standing, options);
  std::vector<MarkerFile> trials;
  if (by != "walk" && standing != nullptr) trials.push_back(*standing);
  if (by != "static") trials.push_back(walk);
  ScaledModel scaled = by == "setup"
                           ? scale_by_setup(generic, standing, mass, options)
                           : scale_by_markers(generic, std::move(trials), mass, threads, log);
  report(warnings, scaled.warnings);
  set_mass(scaled, mass);
  if (scaled.automatic) fmt::print("{}\n", quality(*scaled.automatic));
  write_file_atomically(file, scaled.document.to_string());
  return {read_osim(file), by, mass, std::move(scaled.automatic), std::move(scaled.reasons)};
}

}  // namespace sinew
