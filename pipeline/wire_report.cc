#include "pipeline/wire_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

namespace sinew {
namespace {

double natural_length(const TrackingProblem& tracking, std::size_t wire) {
  return tracking.problem.wires[wire].natural_length;
}

double strain(double length, double natural) {
  return natural > 0.0 ? std::max(0.0, length - natural) / natural : 0.0;
}

}  // namespace

std::string wires_csv(const MusculoskeletalModel& model, const TrackingProblem& tracking,
                      const TrackingResult& result) {
  std::string text = "time_s";
  auto out = std::back_inserter(text);
  for (const int link : tracking.virtual_links) {
    const std::string& name = model.bodies[static_cast<std::size_t>(link)].name;
    fmt::format_to(out, ",{0}.x,{0}.y,{0}.z", name);
  }
  for (const TrackedWire& wire : tracking.wires) {
    fmt::format_to(out, ",{0}.length,{0}.slack,{0}.strain", wire.name);
  }
  text += '\n';
  for (Eigen::Index frame = 0; frame < result.time.size(); ++frame) {
    fmt::format_to(out, "{}", result.time[frame]);
    for (const double p : result.furcations.row(frame)) fmt::format_to(out, ",{:.7f}", p);
    for (std::size_t i = 0; i < tracking.wires.size(); ++i) {
      const double length = result.wire_lengths(frame, static_cast<Eigen::Index>(i));
      const double natural = natural_length(tracking, i);
      fmt::format_to(out, ",{:.7f},{:.7f},{:.3g}", length, std::max(0.0, natural - length),
                     strain(length, natural));
    }
    text += '\n';
  }
  return text;
}

nlohmann::ordered_json wire_summary(const TrackingProblem& tracking, const TrackingResult& result) {
  // Below, lengths are equal to rounding.
  constexpr double kEqual = 1e-9;
  std::size_t ever_taut = 0, worst_wire = 0;
  double worst = 0.0, worst_time = kNaN;
  for (std::size_t i = 0; i < tracking.wires.size(); ++i) {
    double most = 0.0;
    for (Eigen::Index frame = 0; frame < result.time.size(); ++frame) {
      const double s = strain(result.wire_lengths(frame, static_cast<Eigen::Index>(i)),
                              natural_length(tracking, i));
      most = std::max(most, s);
      if (s > worst) {
        worst = s;
        worst_wire = i;
        worst_time = result.time[frame];
      }
    }
    if (most > kEqual) ++ever_taut;
  }
  nlohmann::ordered_json json;
  json["wires"] = tracking.wires.size();
  json["virtual_links"] = tracking.virtual_links.size();
  json["ever_taut"] = ever_taut;
  if (worst > 0.0) {
    json["most_strained"] = {
        {"wire", tracking.wires[worst_wire].name}, {"strain", worst}, {"time_s", worst_time}};
  }
  return json;
}

}  // namespace sinew
