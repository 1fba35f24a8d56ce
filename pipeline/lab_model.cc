#include "pipeline/lab_model.h"

#include <fmt/format.h>

#include <stdexcept>

#include "data/input_file.h"
#include "data/output_file.h"
#include "data/standing_mass.h"
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
  return fmt::format(
      "scale factors: {} of {} follow from the markers, the others from what people are like; "
      "marker RMS {:.1f} mm before, {:.1f} mm scaled, {:.1f} mm with markers moved",
      determinate, fit.estimates.size(), 1e3 * fit.rms_before, 1e3 * fit.rms_scaled,
      1e3 * fit.rms_after);
}

Decision scaling_decision(const GenericModel& generic, bool standing, const LabOptions& options,
                          bool mass_known) {
  Decision decision{"scaling", {}, {}, "", {}, "", "--scale"};
  if (!options.scale_setup.empty()) {
    decision.found = "setup";
    decision.why = "a ScaleTool setup was given";
  } else if (standing) {
    decision.found = "static";
    decision.why = "segments and marker places are fitted to the static trial";
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
  if (mass) job.setup.mass = *mass;
  if (standing != nullptr) job.static_trial = *standing;
  require_files(job.setup, {.model = true, .static_trial = standing != nullptr});
  return run_scale(job);
}

ScaledModel scale_by_markers(const GenericModel& generic, const MarkerFile& recording,
                             const std::optional<double>& mass, int threads) {
  AutoScaleJob job;
  job.model_file = generic.file;
  job.mass = mass;
  job.trials = {recording};
  // More would only take longer: together they weigh no more than so many independent ones.
  job.options.frames = static_cast<int>(job.options.independent_frames);
  job.options.threads = threads;
  job.options.progress = progress_bar("scaling");
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

}  // namespace

GenericModel generic_model(const std::string& name, const LabOptions& options,
                           const std::filesystem::path& folder) {
  GenericModel generic;
  std::optional<WholeBodyOptions> body = find_whole_body(name);
  if (!body) {
    if (options.height || !options.sex.empty()) {
      throw std::invalid_argument(
          fmt::format("--height and --sex are for the built-in bodies; '{}' is a file", name));
    }
    generic.file = name;
    generic.model = read_osim(name);
    return generic;
  }
  generic.built_in = true;
  body->height = options.height.value_or(body->height);
  body->mass = options.mass.value_or(body->mass);
  if (options.sex == "female") body->sex = WholeBodyOptions::Sex::kFemale;
  body->validate();
  generic.file = folder / "model_generic.osim";
  write_file_atomically(generic.file, write_osim(whole_body(*body)));
  generic.model = read_osim(generic.file);
  return generic;
}

MusculoskeletalModel settle_model(const GenericModel& generic, const MarkerFile& walk,
                                  const MarkerFile* standing,
                                  const std::vector<ForcePlatformRecording>& standing_plates,
                                  const LabOptions& options, int threads,
                                  const std::filesystem::path& file, DecisionLog& log,
                                  std::vector<Warning>& warnings) {
  Decision mass_decision{"mass", {}, {}, "", {}, "", "--mass"};
  if (const std::optional<double> found = standing_mass(standing_plates)) {
    mass_decision.found = *found;
    mass_decision.why = "[kg] what the platforms carry in the static trial";
    mass_decision.confidence = 0.9;
  } else {
    mass_decision.why = "neither --mass nor standing on platforms says it: the model's own";
  }
  std::optional<double> mass;
  const nlohmann::ordered_json settled = log.settle(mass_decision);
  if (settled.is_number()) mass = settled.get<double>();
  if (options.no_scale) log.say("scaling", "none", options.given_now.contains("--no-scale"));
  const std::string by =
      log.settle_text(scaling_decision(generic, standing != nullptr, options, mass.has_value()));
  if (by == "none") {
    write_file_atomically(file, read_file(generic.file));
    return read_osim(file);
  }
  if (by == "mass") {
    if (!mass) throw std::invalid_argument("scaling by mass needs --mass");
    write_file_atomically(file, scale_by_mass(generic, *mass, warnings));
    return read_osim(file);
  }
  if (by == "static" && standing == nullptr) {
    throw std::invalid_argument("scaling by the static trial needs --static FILE");
  }
  if (by == "setup" && options.scale_setup.empty()) {
    throw std::invalid_argument("scaling by a setup needs --scale-setup FILE.xml");
  }
  if (by != "static" && by != "walk" && by != "setup") {
    throw std::invalid_argument(
        fmt::format("scaling is '{}'; expected setup, static, walk, mass or none", by));
  }
  const ScaledModel scaled =
      by == "setup" ? scale_by_setup(generic, standing, mass, options)
                    : scale_by_markers(generic, by == "walk" ? walk : *standing, mass, threads);
  report(warnings, scaled.warnings);
  set_mass(scaled, mass);
  if (scaled.automatic) fmt::print("{}\n", quality(*scaled.automatic));
  write_file_atomically(file, scaled.document.to_string());
  return read_osim(file);
}

}  // namespace sinew
