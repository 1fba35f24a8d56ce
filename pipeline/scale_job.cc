#include "pipeline/scale_job.h"

#include <fmt/format.h>

#include <stdexcept>

#include "data/marker_synonyms.h"
#include "data/storage_file.h"
#include "data/trc_file.h"
#include "model/limb_paths.h"
#include "model/osim_writer.h"
#include "model/whole_body.h"
#include "pipeline/coordinate_values.h"
#include "pipeline/ik_job.h"
#include "pipeline/spikes.h"

namespace sinew {
namespace {

void append(std::vector<Warning>& all, const std::vector<Warning>& more) {
  all.insert(all.end(), more.begin(), more.end());
}

std::vector<std::string> body_names(const MusculoskeletalModel& model) {
  std::vector<std::string> names;
  for (const Body& body : model.bodies) names.push_back(body.name);
  return names;
}

// The recording of a step of the setup: the job's own, or the file that the step names.
template <typename Setup>
MarkerFile recording_of(const ScaleJob& job, const Setup& step, std::vector<Warning>& warnings) {
  if (job.static_trial) return *job.static_trial;
  MarkerFile recording = read_trc(step.marker_file);
  append(warnings, recording.warnings);
  leave_out_spikes(recording.markers, recording.path, "", warnings);
  return recording;
}

void scale_document(const ScaleJob& job, ScaledModel& scaled) {
  const ModelScalerSetup& scaler = job.setup.scaler;
  std::optional<MarkerFile> recording;
  if (needs_recording(scaler)) recording = recording_of(job, scaler, scaled.warnings);
  MeasuredFactors measured =
      measured_factors(scaled.document.model(), scaler, recording ? &*recording : nullptr);
  append(scaled.warnings, measured.warnings);
  scaled.factors = measured.factors;
  scaled.measurements = std::move(measured.measurements);
  append(scaled.warnings, scaled.document.scale(
                              scaled.factors, {job.setup.mass, scaler.preserve_mass_distribution}));
}

// What the coordinate file of the placer says at the first frame of its range.
RowMatrix task_values(const MarkerPlacerSetup& placer, const MusculoskeletalModel& model,
                      const MarkerFile& trial, std::vector<Warning>& warnings) {
  if (placer.coordinate_file.empty()) return {};
  const CoordinateTable table = coordinate_table(model, read_storage(placer.coordinate_file));
  append(warnings, table.warnings);
  const int first = frames_around(trial.markers, placer.from, placer.to).first;
  return coordinate_values_at(trial.markers.time.segment(first, 1), table);
}

void place_in_document(const ScaleJob& job, ScaledModel& scaled) {
  const MarkerPlacerSetup& placer = job.setup.placer;
  const MarkerFile trial = recording_of(job, placer, scaled.warnings);
  const MusculoskeletalModel& model = scaled.document.model();
  const RowMatrix values = task_values(placer, model, trial, scaled.warnings);
  MarkerPlacementOptions options = job.placement;
  options.from = placer.from;
  options.to = placer.to;
  options.max_marker_movement = placer.max_marker_movement;
  scaled.placement =
      place_markers(model, trial, &placer.task_set, values.size() > 0 ? &values : nullptr, options);
  append(scaled.warnings, scaled.placement->warnings);
  if (options.move_markers) scaled.document.set_markers(scaled.placement->model.markers);
}

ScaledModel start(OsimDocument document, const std::filesystem::path& marker_set) {
  if (!marker_set.empty()) document.merge_markers(marker_set);
  const ScaleFactors ones(document.model());
  ScaledModel scaled{std::move(document), {}, kNaN, {}, ones, {}, {}, {}, {}, {}};
  scaled.mass_before = scaled.document.model().total_mass();
  scaled.bodies = body_names(scaled.document.model());
  append(scaled.warnings, scaled.document.model().warnings);
  return scaled;
}

std::vector<std::string> technical_in(const AutoScaleJob& job, const MusculoskeletalModel& model) {
  std::vector<std::string> names;
  for (const Marker& marker : model.markers) names.push_back(marker.name);
  if (!job.technical) return technical_markers(names);
  for (const std::string& name : *job.technical) {
    if (model.find_marker(name) >= 0) continue;
    throw std::invalid_argument(
        fmt::format("--technical names '{}', which is no marker of the model", name));
  }
  return *job.technical;
}

}  // namespace

bool needs_recording(const ModelScalerSetup& scaler) {
  if (!scaler.apply) return false;
  for (const ModelScalerSetup::Step step : scaler.order) {
    if (step != ModelScalerSetup::Step::kMeasurements) continue;
    for (const ScaleMeasurement& measurement : scaler.measurements) {
      if (measurement.apply) return true;
    }
  }
  return false;
}

void require_files(const ScaleSetup& setup, const ScaleJobFiles& given) {
  const auto require = [](bool is_given, const auto& step, const std::filesystem::path& file,
                          const char* element, const char* option) {
    if (!is_given) require_file(file, location_of(step, element), element, option);
  };
  const GenericModelSetup& generic = setup.generic;
  require(given.model, generic, generic.model_file, "model_file", "--model");
  if (!generic.marker_set_file.empty()) {
    require(given.marker_set, generic, generic.marker_set_file, "marker_set_file", "--marker-set");
  }
  if (needs_recording(setup.scaler)) {
    require(given.static_trial, setup.scaler, setup.scaler.marker_file, "marker_file", "--static");
  }
  if (!setup.placer.apply) return;
  require(given.static_trial, setup.placer, setup.placer.marker_file, "marker_file", "--static");
  if (!setup.placer.coordinate_file.empty()) {
    require(given.coordinates, setup.placer, setup.placer.coordinate_file, "coordinate_file",
            "--task-coordinates");
  }
}

InputFiles input_files(const ScaleSetup& setup) {
  return {{"setup", setup.path},
          {"model", setup.generic.model_file},
          {"marker_set", setup.generic.marker_set_file},
          {"static", setup.scaler.marker_file},
          {"placement", setup.placer.marker_file},
          {"task_coordinates", setup.placer.coordinate_file}};
}

OsimDocument open_model(const std::filesystem::path& file_or_name) {
  if (const auto body = find_whole_body(file_or_name.string())) {
    return {file_or_name.string(), write_osim(whole_body(*body))};
  }
  return OsimDocument(file_or_name);
}

ScaledModel run_scale(const ScaleJob& job) {
  const GenericModelSetup& generic = job.setup.generic;
  ScaledModel scaled = start(open_model(generic.model_file), generic.marker_set_file);
  if (!job.setup.name.empty()) scaled.document.rename(job.setup.name);
  if (job.setup.scaler.apply) scale_document(job, scaled);
  scaled.scaled_only = scaled.document.to_string();
  if (stands_for_a_person(scaled.document.model())) {
    scaled.reasons = size_reasons(scaled.document.model(), scaled.factors, {});
  }
  if (job.setup.placer.apply) place_in_document(job, scaled);
  return scaled;
}

ScaledModel run_auto_scale(const AutoScaleJob& job) {
  ScaledModel scaled = start(open_model(job.model_file), job.marker_set_file);
  if (!job.name.empty()) scaled.document.rename(job.name);
  std::vector<AutoScaleTrial> trials;
  std::vector<MarkerFile> recordings = job.trials;
  for (MarkerFile& trial : recordings) {
    append(scaled.warnings, trial.warnings);
    leave_out_spikes(trial.markers, trial.path, "", scaled.warnings);
    trials.push_back({&trial, job.from, job.to});
  }
  AutoScaleOptions options = job.options;
  options.technical_markers = technical_in(job, scaled.document.model());
  scaled.automatic = auto_scale(scaled.document.model(), trials, options);
  append(scaled.warnings, scaled.automatic->warnings);
  scaled.reasons = scaled.automatic->reasons;
  scaled.factors = scaled.automatic->factors;
  append(scaled.warnings,
         scaled.document.scale(scaled.factors, {job.mass, job.preserve_mass_distribution}));
  scaled.scaled_only = scaled.document.to_string();
  std::vector<Marker> markers = scaled.document.model().markers;
  for (const MarkerOffset& offset : scaled.automatic->offsets) {
    markers[static_cast<std::size_t>(offset.marker)].p_BM += offset.offset;
  }
  scaled.document.set_markers(markers);
  return scaled;
}

ScaleSet applied_scales(const ScaledModel& scaled) {
  ScaleSet set;
  for (std::size_t b = 0; b < scaled.bodies.size(); ++b) {
    set.scales.push_back({scaled.bodies[b], scaled.factors.of_body[b], true, 0});
  }
  return set;
}

TimeTable static_motion(const MusculoskeletalModel& model, const MarkerPlacementResult& placement) {
  TrackingResult pose;
  pose.time = Eigen::VectorXd::Constant(1, placement.time);
  pose.coordinates = placement.coordinates.transpose();
  TimeTable table = coordinate_motion(model, pose);
  table.name = "static pose";
  return table;
}

}  // namespace sinew
