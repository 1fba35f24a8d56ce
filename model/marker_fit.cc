#include "model/marker_fit.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <map>
#include <set>
#include <stdexcept>

#include "data/statistics.h"

namespace sinew {
namespace {

using Severity = Finding::Severity;

// Lower case, without separators and without a subject's name before a colon.
std::string plain(const std::string& name) {
  const std::size_t colon = name.rfind(':');
  std::string result;
  for (const char c : colon == name.npos ? name : name.substr(colon + 1)) {
    if (std::isalnum(static_cast<unsigned char>(c))) {
      result += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    }
  }
  return result;
}

double middle_distance(const MarkerTrajectories& markers, int a, int b) {
  std::vector<double> distances;
  const int step = std::max(1, markers.frame_count() / 200);
  for (int f = 0; f < markers.frame_count(); f += step) {
    const double d = (markers.position(f, a) - markers.position(f, b)).norm();
    if (std::isfinite(d)) distances.push_back(d);
  }
  return median(std::move(distances));
}

std::vector<double> ratios(const std::vector<MarkerDistance>& distances, int body) {
  std::vector<double> result;
  for (const MarkerDistance& d : distances) {
    if (body < 0 || d.body == body) result.push_back(d.recorded / d.model);
  }
  return result;
}

// The square sum by which distances are off after a body's own scale.
struct BodyMarkers {
  std::vector<int> recorded;          // indices into the recording
  std::vector<Eigen::Vector3d> p_BM;  // in the model
  Eigen::MatrixXd distance;           // recorded, between all; NaN where never together
};

double misfit(const BodyMarkers& body, const std::vector<std::size_t>& order, double scale) {
  double sum = 0.0;
  for (std::size_t i = 0; i < order.size(); ++i) {
    for (std::size_t k = i + 1; k < order.size(); ++k) {
      const double recorded =
          body.distance(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k));
      const double model = scale * (body.p_BM[order[i]] - body.p_BM[order[k]]).norm();
      if (std::isfinite(recorded)) sum += (recorded - model) * (recorded - model);
    }
  }
  return sum;
}

double best_scale(const BodyMarkers& body) {
  double xy = 0.0, xx = 0.0;
  for (std::size_t i = 0; i < body.recorded.size(); ++i) {
    for (std::size_t k = i + 1; k < body.recorded.size(); ++k) {
      const double y = body.distance(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k));
      const double x = (body.p_BM[i] - body.p_BM[k]).norm();
      if (!std::isfinite(y)) continue;
      xy += x * y;
      xx += x * x;
    }
  }
  return xx > 0.0 ? xy / xx : 1.0;
}

std::map<int, BodyMarkers> markers_by_body(const MarkerTrajectories& markers,
                                           const MusculoskeletalModel& model) {
  std::map<int, BodyMarkers> bodies;
  for (const Marker& marker : model.markers) {
    const int index = markers.find_marker(marker.name);
    if (index < 0) continue;
    BodyMarkers& body = bodies[marker.body];
    body.recorded.push_back(index);
    body.p_BM.push_back(marker.p_BM);
  }
  for (auto& [index, body] : bodies) {
    const auto n = static_cast<Eigen::Index>(body.recorded.size());
    body.distance.setZero(n, n);
    for (Eigen::Index i = 0; i < n; ++i) {
      for (Eigen::Index k = i + 1; k < n; ++k) {
        body.distance(i, k) = body.distance(k, i) =
            middle_distance(markers, body.recorded[static_cast<std::size_t>(i)],
                            body.recorded[static_cast<std::size_t>(k)]);
      }
    }
  }
  return bodies;
}

// Two markers that fit far better under each other's names.
void find_exchanged(const BodyMarkers& body, const MarkerTrajectories& markers,
                    const std::string& body_name, const MarkerFitOptions& options,
                    std::vector<Finding>& findings) {
  const std::size_t n = body.recorded.size();
  if (n < 4) return;
  std::vector<std::size_t> order(n);
  for (std::size_t i = 0; i < n; ++i) order[i] = i;
  const double scale = best_scale(body), before = misfit(body, order, scale);
  const double pairs = 0.5 * static_cast<double>(n * (n - 1));
  if (std::sqrt(before / pairs) < options.misplaced) return;
  double best = before;
  std::size_t x = 0, y = 0;
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t k = i + 1; k < n; ++k) {
      std::swap(order[i], order[k]);
      const double now = misfit(body, order, scale);
      std::swap(order[i], order[k]);
      if (now >= best) continue;
      best = now;
      x = i;
      y = k;
    }
  }
  // A quarter of the squares is half of the distances.
  if (x == y || best > 0.25 * before) return;
  const std::string& a = markers.names[static_cast<std::size_t>(body.recorded[x])];
  const std::string& b = markers.names[static_cast<std::size_t>(body.recorded[y])];
  Finding finding;
  finding.kind = "place";
  finding.where = a + ", " + b;
  finding.confidence = std::clamp(1.0 - std::sqrt(best / before), 0.5, 0.95);
  finding.text = fmt::format(
      "on {} of the model they fit to {:.0f} mm under each other's names, to {:.0f} mm under their "
      "own",
      body_name, 1e3 * std::sqrt(best / pairs), 1e3 * std::sqrt(before / pairs));
  finding.flags = {"--swap", a + "," + b};
  findings.push_back(std::move(finding));
}

Finding size_finding(double ratio, std::size_t count) {
  Finding finding;
  finding.kind = "size";
  finding.text = fmt::format(
      "the model is too {}: distances of markers on one body are {:.3f} times the model's, by {} "
      "pairs",
      ratio > 1.0 ? "small" : "big", ratio, count);
  finding.advice = "scale the model to the subject";
  return finding;
}

}  // namespace

void MarkerFitOptions::validate() const {
  for (const auto& [name, value] :
       {std::pair{"size_tolerance", size_tolerance}, std::pair{"least_distance", least_distance},
        std::pair{"misplaced", misplaced}}) {
    if (value > 0.0 && std::isfinite(value)) continue;
    throw std::invalid_argument(
        fmt::format("MarkerFitOptions::{} is {}; it must be above 0", name, value));
  }
}

std::vector<MarkerDistance> marker_distances(const MarkerTrajectories& markers,
                                             const MusculoskeletalModel& model,
                                             const MarkerFitOptions& options) {
  options.validate();
  std::vector<MarkerDistance> distances;
  for (std::size_t i = 0; i < model.markers.size(); ++i) {
    const int a = markers.find_marker(model.markers[i].name);
    for (std::size_t k = i + 1; a >= 0 && k < model.markers.size(); ++k) {
      if (model.markers[k].body != model.markers[i].body) continue;
      const int b = markers.find_marker(model.markers[k].name);
      const double d = (model.markers[i].p_BM - model.markers[k].p_BM).norm();
      if (b < 0 || d < options.least_distance) continue;
      const double recorded = middle_distance(markers, a, b);
      if (std::isfinite(recorded)) {
        distances.push_back({model.markers[i].body, a, b, d, recorded});
      }
    }
  }
  return distances;
}

std::vector<Finding> find_unmatched_markers(const MarkerTrajectories& markers,
                                            const MusculoskeletalModel& model) {
  std::vector<Finding> findings;
  if (model.markers.empty()) return findings;
  std::map<std::string, std::string> by_plain;
  std::set<std::string> absent;
  int common = 0;
  for (const Marker& marker : model.markers) {
    if (markers.find_marker(marker.name) >= 0) {
      ++common;
    } else {
      absent.insert(marker.name);
      by_plain.emplace(plain(marker.name), marker.name);
    }
  }
  Finding extra;
  extra.kind = "match";
  extra.confidence = 1.0;
  std::vector<std::string> unknown;
  for (const std::string& name : markers.names) {
    if (model.find_marker(name) >= 0) continue;
    unknown.push_back(name);
    const auto found = by_plain.find(plain(name));
    if (found == by_plain.end() || absent.erase(found->second) == 0) continue;
    extra.flags.insert(extra.flags.end(), {"--rename", name + "=" + found->second});
  }
  if (!unknown.empty()) {
    extra.where = list_names(unknown);
    extra.text = fmt::format("{} of {} recorded markers are not in the model", unknown.size(),
                             markers.names.size());
    const auto renamed = extra.flags.size() / 2;
    if (renamed > 0) extra.text += fmt::format("; {} have other names there", renamed);
    extra.severity = renamed > 0 ? Severity::kWarning : Severity::kNote;
    if (common < 3) extra.severity = Severity::kError;
    findings.push_back(std::move(extra));
  }
  if (!absent.empty()) {
    Finding missing;
    missing.severity = common < 3 ? Severity::kError : Severity::kNote;
    missing.kind = "match";
    missing.where = list_names({absent.begin(), absent.end()});
    missing.confidence = 1.0;
    missing.text = fmt::format("{} of {} markers of the model were not recorded", absent.size(),
                               model.markers.size());
    findings.push_back(std::move(missing));
  }
  return findings;
}

std::vector<Finding> find_size_faults(const MarkerTrajectories& markers,
                                      const MusculoskeletalModel& model,
                                      const MarkerFitOptions& options) {
  std::vector<Finding> findings;
  const std::vector<MarkerDistance> distances = marker_distances(markers, model, options);
  for (const auto& [index, body] : markers_by_body(markers, model)) {
    find_exchanged(body, markers, model.bodies[static_cast<std::size_t>(index)].name, options,
                   findings);
  }
  const double all = median(ratios(distances, -1));
  // Three pairs make a triangle; fewer are one misplaced marker's.
  if (distances.size() >= 3 && std::abs(all - 1.0) > options.size_tolerance) {
    Finding finding = size_finding(all, distances.size());
    std::vector<double> off;
    for (const double ratio : ratios(distances, -1)) off.push_back(std::abs(ratio / all - 1.0));
    finding.confidence = std::clamp(1.0 - median(off) / std::abs(all - 1.0), 0.5, 0.95);
    findings.push_back(std::move(finding));
  }
  std::set<int> bodies;
  for (const MarkerDistance& d : distances) bodies.insert(d.body);
  for (const int body : bodies) {
    const std::vector<double> own = ratios(distances, body);
    const double ratio = median(own);
    // Twice the tolerance: a single body has few markers.
    if (own.size() < 3 || std::abs(ratio / all - 1.0) <= 2.0 * options.size_tolerance) continue;
    Finding finding = size_finding(ratio, own.size());
    finding.severity = Severity::kNote;
    finding.where = model.bodies[static_cast<std::size_t>(body)].name;
    finding.confidence = 0.6;
    findings.push_back(std::move(finding));
  }
  return findings;
}

}  // namespace sinew
