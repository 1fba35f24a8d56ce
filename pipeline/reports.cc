#include "pipeline/reports.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "data/input_file.h"

namespace sinew {
namespace {

using Json = nlohmann::ordered_json;

// JSON has no NaN; null is its "there is none".
Json number(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

std::string cell(double value) { return std::isnan(value) ? "" : fmt::format("{}", value); }

// Names may hold commas or quotes (RFC 4180).
std::string cell(const std::string& text) {
  if (text.find_first_of(",\"\n\r") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + "\"";
}

// "0.4 s, 0.41 s and 12 more": enough to find the place, short enough for one line.
std::string some_of(const std::vector<std::string>& items) {
  constexpr std::size_t kShown = 8;
  std::string text;
  for (std::size_t i = 0; i < std::min(items.size(), kShown); ++i) {
    text += (i == 0 ? "" : ", ") + items[i];
  }
  if (items.size() > kShown) text += fmt::format(" and {} more", items.size() - kShown);
  return text;
}

Json not_converged(const TrackingResult& result) {
  Json json = Json::array();
  for (std::size_t i = 0; i < result.frames.size(); ++i) {
    const Termination termination = result.frames[i].termination;
    if (converged(termination)) continue;
    json.push_back({{"time_s", result.time[static_cast<Eigen::Index>(i)]},
                    {"termination", to_string(termination)}});
  }
  return json;
}

}  // namespace

Json search_json(const ColdStartResult& search) {
  return {{"starts", search.starts},
          {"starts_at_lowest", search.agreeing},
          {"independent_starts_agree", search.agreed},
          {"lowest_cost", number(search.lowest)},
          {"second_lowest_cost", number(search.second_lowest)}};
}

namespace {

// What the frames that started cold, or were doubted, were compared with.
Json search_summary(const TrackingResult& result, const TrackingOptions& options) {
  Json json;
  json["most_starts"] = options.cold_start.starts;
  json["doubtful_frames"] = result.looked_again;
  json["lowered_frames"] = result.lowered;
  json["frames"] = Json::array();
  for (const SearchedFrame& searched : result.searched) {
    Json frame = {{"time_s", result.time[searched.frame]}};
    frame.update(search_json(searched.search));
    json["frames"].push_back(frame);
  }
  return json;
}

}  // namespace

std::vector<MarkerError> marker_errors(const TrackingProblem& tracking,
                                       const TrackingResult& result) {
  std::vector<MarkerError> errors;
  for (std::size_t m = 0; m < tracking.markers.size(); ++m) {
    MarkerError error;
    error.name = tracking.markers[m].name;
    error.weight = tracking.markers[m].weight;
    double sum = 0.0;
    for (Eigen::Index frame = 0; frame < result.marker_errors.rows(); ++frame) {
      const double e = result.marker_errors(frame, static_cast<Eigen::Index>(m));
      if (std::isnan(e)) continue;
      ++error.measured;
      sum += e * e;
      if (!(e <= error.max)) {
        error.max = e;
        error.time_of_max = result.time[frame];
      }
    }
    if (error.measured > 0) error.rms = std::sqrt(sum / error.measured);
    errors.push_back(error);
  }
  return errors;
}

std::string marker_errors_csv(const std::vector<MarkerError>& errors) {
  std::string text = "marker,weight,frames_measured,rms_m,max_m,time_of_max_s\n";
  for (const MarkerError& e : errors) {
    text += fmt::format("{},{},{},{},{},{}\n", cell(e.name), cell(e.weight), e.measured,
                        cell(e.rms), cell(e.max), cell(e.time_of_max));
  }
  return text;
}

std::string frame_errors_csv(const TrackingProblem& tracking, const TrackingResult& result) {
  std::string text = "time_s,cost,rms_m,max_m,worst_marker,iterations,termination";
  for (const TrackedMarker& marker : tracking.markers) text += "," + cell(marker.name);
  text += "\n";
  for (std::size_t i = 0; i < result.frames.size(); ++i) {
    const FrameResult& f = result.frames[i];
    const std::string worst =
        f.worst_marker < 0 ? "" : tracking.markers[static_cast<std::size_t>(f.worst_marker)].name;
    text += fmt::format("{},{},{},{},{},{},{}", result.time[static_cast<Eigen::Index>(i)], f.cost,
                        cell(f.marker_rms), cell(f.marker_max), cell(worst), f.iterations,
                        to_string(f.termination));
    for (const double e : result.marker_errors.row(static_cast<Eigen::Index>(i))) {
      text += "," + cell(e);
    }
    text += "\n";
  }
  return text;
}

double total_marker_rms(const TrackingResult& result) {
  double sum = 0.0;
  long count = 0;
  for (const FrameResult& f : result.frames) {
    if (f.measured_markers == 0) continue;
    sum += f.marker_rms * f.marker_rms * f.measured_markers;
    count += f.measured_markers;
  }
  return count > 0 ? std::sqrt(sum / static_cast<double>(count)) : kNaN;
}

int unconverged_frames(const TrackingResult& result) {
  int count = 0;
  for (const FrameResult& f : result.frames) count += converged(f.termination) ? 0 : 1;
  return count;
}

std::vector<Warning> frame_warnings(const TrackingResult& result, const std::string& file) {
  std::vector<std::string> unconverged, unmeasured;
  for (std::size_t i = 0; i < result.frames.size(); ++i) {
    const FrameResult& f = result.frames[i];
    const double time = result.time[static_cast<Eigen::Index>(i)];
    if (!converged(f.termination)) {
      unconverged.push_back(fmt::format("{:.6g} s ({})", time, to_string(f.termination)));
    }
    if (f.measured_markers == 0) unmeasured.push_back(fmt::format("{:.6g} s", time));
  }
  std::vector<Warning> warnings;
  if (!unconverged.empty()) {
    warnings.push_back({{file, 0},
                        fmt::format("{} of {} frames did not converge: {}", unconverged.size(),
                                    result.frames.size(), some_of(unconverged))});
  }
  if (!unmeasured.empty()) {
    warnings.push_back({{file, 0},
                        fmt::format("no tracked marker is measured in {} of {} frames, "
                                    "where angles go on from what is known beside them: {}",
                                    unmeasured.size(), result.frames.size(), some_of(unmeasured))});
  }
  return warnings;
}

Json ik_summary(const TrackingProblem& tracking, const TrackingResult& result,
                const TrackingOptions& options) {
  const std::vector<MarkerError> errors = marker_errors(tracking, result);
  const MarkerError* worst_marker = nullptr;
  for (const MarkerError& e : errors) {
    if (e.measured > 0 && (worst_marker == nullptr || e.rms > worst_marker->rms)) worst_marker = &e;
  }
  std::size_t worst_frame = 0;
  long iterations = 0;
  for (std::size_t i = 0; i < result.frames.size(); ++i) {
    iterations += result.frames[i].iterations;
    if (!(result.frames[i].marker_rms <= result.frames[worst_frame].marker_rms) &&
        result.frames[i].measured_markers > 0) {
      worst_frame = i;
    }
  }
  const auto frames = static_cast<double>(result.frames.size());
  Json json;
  json["method"] = to_string(options.minimizer.method);
  json["gradient_tolerance"] = options.minimizer.gradient_tolerance;
  json["frames"] = result.frames.size();
  json["markers"] = tracking.markers.size();
  json["seconds"] = result.seconds;
  json["ms_per_frame"] = 1e3 * result.seconds / frames;
  json["iterations_per_frame"] = static_cast<double>(iterations) / frames;
  json["frames_not_converged"] = unconverged_frames(result);
  json["not_converged"] = not_converged(result);
  json["searches"] = search_summary(result, options);
  json["marker_rms_m"] = number(total_marker_rms(result));
  if (worst_marker != nullptr) {
    json["worst_marker"] = {{"name", worst_marker->name},
                            {"rms_m", worst_marker->rms},
                            {"max_m", worst_marker->max},
                            {"time_of_max_s", worst_marker->time_of_max}};
  }
  json["worst_frame"] = {{"time_s", result.time[static_cast<Eigen::Index>(worst_frame)]},
                         {"rms_m", number(result.frames[worst_frame].marker_rms)}};
  return json;
}

Json id_summary(const MusculoskeletalModel& model, const TimeTable& forces) {
  Json residuals = Json::array();
  for (std::size_t c = 0; c < model.coordinates.size(); ++c) {
    const Coordinate& coordinate = model.coordinates[c];
    if (model.joints[static_cast<std::size_t>(coordinate.joint)].parent != 0) continue;
    const bool turns = coordinate.motion == Coordinate::Motion::kRotational;
    const int column = forces.find_column(coordinate.name + (turns ? "_moment" : "_force"));
    if (column < 0) continue;
    const auto values = forces.values.col(column);
    residuals.push_back(
        {{"column", forces.labels[static_cast<std::size_t>(column)]},
         {"unit", turns ? "N m" : "N"},
         {"rms", std::sqrt(values.squaredNorm() / static_cast<double>(values.size()))},
         {"max", values.cwiseAbs().maxCoeff()}});
  }
  Json json;
  json["frames"] = forces.time.size();
  json["root_residuals"] = residuals;
  return json;
}

Json input_summary(const InputFiles& files) {
  Json json;
  for (const auto& [role, path] : files) {
    if (path.empty()) continue;
    json[role] = {{"path", path.string()}, {"sha256", sha256_of_file(path)}};
  }
  return json;
}

Json warning_summary(const std::vector<Warning>& warnings) {
  Json json = Json::array();
  for (const Warning& warning : warnings) json.push_back(to_string(warning));
  return json;
}

}  // namespace sinew
