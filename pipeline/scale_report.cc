#include <fmt/format.h>

#include "pipeline/reports.h"
#include "pipeline/scale_job.h"

namespace sinew {
namespace {

using Json = nlohmann::ordered_json;

Json number(double value) { return std::isfinite(value) ? Json(value) : Json(); }

const char* fate_name(PlacedMarker::Fate fate) {
  static constexpr const char* kNames[] = {"moved", "fixed", "not measured", "removed"};
  return kNames[static_cast<int>(fate)];
}

std::string measurements_text(const ScaledModel& scaled) {
  std::string text;
  for (const MeasuredScale& m : scaled.measurements) {
    text += std::isfinite(m.factor) ? fmt::format("measurement {:<20} {:.6f}\n", m.name, m.factor)
                                    : fmt::format("measurement {:<20} not used\n", m.name);
    for (const MeasuredPair& pair : m.pairs) {
      text += fmt::format("  {:<28} {:9.2f} mm, model {:9.2f} mm, {} frames\n",
                          pair.first + " " + pair.second, 1e3 * pair.recorded, 1e3 * pair.model,
                          pair.frames);
    }
  }
  return text;
}

std::string bodies_text(const ScaledModel& scaled) {
  std::string text = fmt::format("{:<20} {:>9} {:>9} {:>9} {:>9}\n", "body", "x", "y", "z", "kg");
  const MusculoskeletalModel& model = scaled.document.model();
  for (std::size_t b = 1; b < scaled.bodies.size(); ++b) {
    const Eigen::Vector3d& f = scaled.factors.of_body[b];
    text += fmt::format("{:<20} {:9.6f} {:9.6f} {:9.6f} {:9.4f}\n", scaled.bodies[b], f[0], f[1],
                        f[2], model.bodies[b].mass);
  }
  return text +
         fmt::format("mass {:.4f} kg, was {:.4f} kg\n", model.total_mass(), scaled.mass_before);
}

std::string placement_text(const MarkerPlacementResult& p) {
  int moved = 0, fixed = 0, removed = 0;
  for (const PlacedMarker& marker : p.markers) {
    moved += marker.fate == PlacedMarker::Fate::kMoved;
    fixed += marker.fate == PlacedMarker::Fate::kFixed;
    removed += marker.fate == PlacedMarker::Fate::kRemoved;
  }
  return fmt::format(
      "static pose of {} frames from {:.6g} s: marker RMS {:.2f} mm, largest {:.2f} mm ({}); {} "
      "markers moved, {} fixed, {} not recorded and removed\n",
      p.frames, p.time, 1e3 * p.marker_rms, 1e3 * p.marker_max, p.worst_marker, moved, fixed,
      removed);
}

std::string automatic_text(const ScaledModel& scaled) {
  const AutoScaleResult& a = *scaled.automatic;
  std::string text = fmt::format("{:<24} {:>8} {:>9} {:>9} {:>9}  {}\n", "factor", "value", "prior",
                                 "rest known", "posterior", "s.d. in %");
  for (const ScaleEstimate& e : a.estimates) {
    text += fmt::format("{:<24} {:8.4f} {:9.2f} {:9.2f} {:9.2f}  {}\n", e.name, e.factor,
                        1e2 * e.prior_sd, 1e2 * e.open_sd, 1e2 * e.posterior_sd,
                        e.at_limit      ? "at the limit of what people are"
                        : e.determinate ? "measured"
                                        : "follows from the others");
  }
  for (const AutoScaleTrialFit& trial : a.trials) {
    text += fmt::format("trial of {} frames, {} poses that differ: marker RMS {:.2f} mm\n",
                        trial.frames, trial.poses, 1e3 * trial.rms);
  }
  return text + fmt::format(
                    "{} frames, {} iterations{}, marker RMS {:.2f} mm unscaled, {:.2f} mm scaled, "
                    "{:.2f} mm with markers moved\n",
                    a.frames, a.iterations, a.converged ? "" : " (not converged)",
                    1e3 * a.rms_before, 1e3 * a.rms_scaled, 1e3 * a.rms_after);
}

Json measurement_json(const MeasuredScale& m) {
  Json pairs = Json::array();
  for (const MeasuredPair& pair : m.pairs) {
    pairs.push_back({{"markers", {pair.first, pair.second}},
                     {"recorded_m", number(pair.recorded)},
                     {"model_m", number(pair.model)},
                     {"frames", pair.frames}});
  }
  return {{"name", m.name}, {"factor", number(m.factor)}, {"pairs", pairs}};
}

Json placement_json(const MarkerPlacementResult& p) {
  Json markers = Json::array();
  for (const PlacedMarker& marker : p.markers) {
    markers.push_back({{"name", marker.name},
                       {"fate", fate_name(marker.fate)},
                       {"weight", marker.weight},
                       {"distance_m", number(marker.distance)}});
  }
  return {{"time_s", p.time},
          {"frames", p.frames},
          {"termination", to_string(p.termination)},
          {"marker_rms_m", number(p.marker_rms)},
          {"marker_max_m", number(p.marker_max)},
          {"search", search_json(p.search)},
          {"markers", markers}};
}

Json automatic_json(const ScaledModel& scaled) {
  const AutoScaleResult& a = *scaled.automatic;
  Json factors = Json::array(), offsets = Json::array(), trials = Json::array();
  for (const ScaleEstimate& e : a.estimates) {
    Json bodies = Json::array();
    for (const int b : e.bodies) bodies.push_back(scaled.bodies[static_cast<std::size_t>(b)]);
    factors.push_back({{"name", e.name},
                       {"bodies", bodies},
                       {"factor", e.factor},
                       {"prior_sd", e.prior_sd},
                       {"rest_known_sd", e.open_sd},
                       {"posterior_sd", e.posterior_sd},
                       {"determinate", e.determinate},
                       {"at_limit", e.at_limit}});
  }
  for (const MarkerOffset& o : a.offsets) {
    offsets.push_back(
        {{"marker", a.markers[static_cast<std::size_t>(o.marker)].name},
         {"offset_m", {o.offset[0], o.offset[1], o.offset[2]}},
         {"posterior_sd_m", {o.posterior_sd[0], o.posterior_sd[1], o.posterior_sd[2]}},
         {"at_limit", o.at_limit}});
  }
  for (const AutoScaleTrialFit& trial : a.trials) {
    trials.push_back(
        {{"frames", trial.frames}, {"poses", trial.poses}, {"marker_rms_m", number(trial.rms)}});
  }
  return {{"converged", a.converged},
          {"iterations", a.iterations},
          {"frames", a.frames},
          {"cost", a.cost},
          {"marker_rms_unscaled_m", a.rms_before},
          {"marker_rms_scaled_m", a.rms_scaled},
          {"marker_rms_m", a.rms_after},
          {"size", a.size},
          {"trials", trials},
          {"factors", factors},
          {"marker_offsets", offsets}};
}

}  // namespace

std::string scale_text(const ScaledModel& scaled) {
  std::string text = measurements_text(scaled);
  if (scaled.automatic) text += automatic_text(scaled);
  text += bodies_text(scaled);
  if (scaled.placement) text += placement_text(*scaled.placement);
  return text;
}

nlohmann::ordered_json scale_json(const ScaledModel& scaled) {
  Json bodies = Json::array(), measurements = Json::array();
  const MusculoskeletalModel& model = scaled.document.model();
  for (std::size_t b = 1; b < scaled.bodies.size(); ++b) {
    const Eigen::Vector3d& f = scaled.factors.of_body[b];
    bodies.push_back({{"name", scaled.bodies[b]},
                      {"factors", {f[0], f[1], f[2]}},
                      {"mass_kg", model.bodies[b].mass}});
  }
  for (const MeasuredScale& m : scaled.measurements) measurements.push_back(measurement_json(m));
  Json json = {{"model", model.name},
               {"mass_kg", model.total_mass()},
               {"mass_before_kg", scaled.mass_before},
               {"bodies", bodies},
               {"measurements", measurements}};
  if (scaled.placement) json["placement"] = placement_json(*scaled.placement);
  if (scaled.automatic) json["auto"] = automatic_json(scaled);
  json["warnings"] = warning_summary(scaled.warnings);
  return json;
}

}  // namespace sinew
