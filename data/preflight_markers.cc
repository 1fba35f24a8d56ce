#include "data/preflight_markers.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>

#include "data/statistics.h"
#include "data/text.h"

namespace sinew {
namespace {

using Eigen::Vector3d;
using Severity = Finding::Severity;

const std::string& name_of(const MarkerTrajectories& markers, int marker) {
  return markers.names[static_cast<std::size_t>(marker)];
}

bool measured(const MarkerTrajectories& markers, int frame, int marker) {
  return !std::isnan(markers.p_WM(frame, 3 * marker));
}

std::vector<int> measured_frames(const MarkerTrajectories& markers, int marker) {
  std::vector<int> frames;
  for (int f = 0; f < markers.frame_count(); ++f) {
    if (measured(markers, f, marker)) frames.push_back(f);
  }
  return frames;
}

// How far a marker gets about in these frames, and in how many of them it was measured.
struct Reach {
  double size = 0.0;
  int frames = 0;
};
Reach reach(const MarkerTrajectories& markers, int marker, const std::vector<int>& frames) {
  Eigen::AlignedBox3d box;
  Reach result;
  for (const int f : frames) {
    const Vector3d p = markers.position(f, marker);
    if (!p.allFinite()) continue;
    box.extend(p);
    ++result.frames;
  }
  if (!box.isEmpty()) result.size = box.sizes().norm();
  return result;
}

// What the middle one of the other markers covers in these frames; 0 if too few tell.
double others_reach(const MarkerTrajectories& markers, int marker, const std::vector<int>& frames) {
  std::vector<double> sizes;
  for (int i = 0; i < markers.marker_count(); ++i) {
    if (i == marker) continue;
    const Reach r = reach(markers, i, frames);
    if (2 * r.frames >= static_cast<int>(frames.size())) sizes.push_back(r.size);
  }
  return sizes.size() < 3 ? 0.0 : median(std::move(sizes));
}

Finding of_marker(const MarkerTrajectories& markers, int marker, const char* kind) {
  Finding finding;
  finding.kind = kind;
  finding.where = name_of(markers, marker);
  finding.flags = {"--drop", finding.where};
  return finding;
}

// Enough frames for a marker that stays where it is, so that cost stays linear in markers.
std::vector<int> thinned(const std::vector<int>& frames, std::size_t most) {
  const std::size_t step = std::max<std::size_t>(1, frames.size() / most);
  std::vector<int> result;
  for (std::size_t i = 0; i < frames.size(); i += step) result.push_back(frames[i]);
  return result;
}

// Frames after `first` in which a marker keeps exactly its place.
int held_until(const MarkerTrajectories& markers, int marker, int first) {
  int last = first;
  while (last + 1 < markers.frame_count() &&
         markers.position(last + 1, marker) == markers.position(first, marker)) {
    ++last;
  }
  return last;
}

void find_held(const MarkerTrajectories& markers, int marker, const MarkerCheckOptions& options,
               std::vector<Finding>& findings) {
  const int least = std::max(5, static_cast<int>(std::lround(options.held * markers.rate)));
  Finding all = of_marker(markers, marker, "static");
  all.flags.clear();
  int stretches = 0, longest = 0;
  for (int f = 0; f < markers.frame_count(); ++f) {
    if (!measured(markers, f, marker)) continue;
    const int last = held_until(markers, marker, f), first = f;
    f = last;
    if (last - first + 1 < least) continue;
    std::vector<int> frames;
    for (int k = first; k <= last; ++k) frames.push_back(k);
    // The rest of the body sways by centimetres at the least while a foot stands.
    if (others_reach(markers, marker, thinned(frames, 50)) <= 2.0 * options.still) continue;
    ++stretches;
    all.flags.insert(all.flags.end(),
                     {"--drop", fmt::format("{}@{}-{}", all.where, time_text(markers.time[first]),
                                            time_text(markers.time[last]))});
    if (last - first < longest) continue;
    longest = last - first;
    set_frames(all, markers, first, last);
  }
  if (stretches == 0) return;
  all.confidence = 0.8;
  all.text =
      fmt::format("keeps exactly one place while others move, {} time{}: samples that were held",
                  stretches, stretches == 1 ? "" : "s");
  findings.push_back(std::move(all));
}

struct Coincidence {
  int together = 0, apart = 0;  // frames with both measured
};
Coincidence coincidence(const MarkerTrajectories& markers, int a, int b, double distance) {
  Coincidence result;
  for (int f = 0; f < markers.frame_count(); ++f) {
    const double d = (markers.position(f, a) - markers.position(f, b)).norm();
    if (std::isnan(d)) continue;
    d <= distance ? ++result.together : ++result.apart;
    // Nothing that is seldom together is one marker.
    if (result.apart > 5 && 20 * result.apart > result.together) break;
  }
  return result;
}

void find_same_labels(const MarkerTrajectories& markers, const std::vector<std::string>& labels,
                      std::vector<Finding>& findings) {
  std::map<std::string, std::vector<int>> by_label;
  const std::size_t count = std::min(labels.size(), markers.names.size());
  for (std::size_t i = 0; i < count; ++i) {
    if (!labels[i].empty()) by_label[labels[i]].push_back(static_cast<int>(i));
  }
  for (const auto& [label, which] : by_label) {
    if (which.size() < 2) continue;
    Finding finding;
    finding.kind = "duplicate";
    finding.where = label;
    finding.confidence = 1.0;
    std::vector<std::string> called;
    int best = which.front();
    std::size_t most = 0;
    for (const int i : which) {
      called.push_back(name_of(markers, i));
      const std::size_t frames = measured_frames(markers, i).size();
      if (frames > most) best = i;
      most = std::max(most, frames);
    }
    finding.severity = most > 0 ? Severity::kWarning : Severity::kNote;
    finding.text = fmt::format("{} trajectories have this label; they are called {}", which.size(),
                               list_names(called));
    for (const int i : which) {
      if (i == best) continue;
      finding.flags.insert(finding.flags.end(), {"--drop", name_of(markers, i)});
    }
    // The one that is left has the label's own name again.
    if (name_of(markers, best) != label) {
      finding.flags.insert(finding.flags.end(), {"--rename", name_of(markers, best) + "=" + label});
    }
    findings.push_back(std::move(finding));
  }
}

// Middle places of markers, to compare only those that may coincide.
std::vector<Vector3d> places(const MarkerTrajectories& markers) {
  std::vector<Vector3d> result;
  for (int i = 0; i < markers.marker_count(); ++i) {
    Vector3d sum = Vector3d::Zero();
    int count = 0;
    for (int f = 0; f < markers.frame_count(); ++f) {
      if (!measured(markers, f, i)) continue;
      sum += markers.position(f, i);
      ++count;
    }
    result.push_back(sum / (count > 0 ? count : std::nan("")));
  }
  return result;
}

// Pairs that are never apart, in one finding: programs make them by the dozen.
void find_same_places(const MarkerTrajectories& markers, double distance,
                      std::vector<Finding>& findings) {
  const std::vector<Vector3d> middle_places = places(markers);
  std::vector<std::string> pairs;
  std::vector<bool> dropped(markers.names.size(), false);
  Finding finding;
  for (std::size_t a = 0; a < markers.names.size(); ++a) {
    for (std::size_t b = a + 1; b < markers.names.size(); ++b) {
      // Means over different frames may lie apart by what a person walks.
      if (!((middle_places[a] - middle_places[b]).norm() < 0.5)) continue;
      const int ia = static_cast<int>(a), ib = static_cast<int>(b);
      const Coincidence c = coincidence(markers, ia, ib, distance);
      if (c.together < 10 || 20 * c.apart > c.together) continue;
      pairs.push_back(markers.names[a] + " = " + markers.names[b]);
      const bool b_less =
          measured_frames(markers, ib).size() <= measured_frames(markers, ia).size();
      const std::size_t drop = b_less ? b : a;
      if (dropped[a] || dropped[b]) continue;
      dropped[drop] = true;
      finding.flags.insert(finding.flags.end(), {"--drop", markers.names[drop]});
    }
  }
  if (pairs.empty()) return;
  finding.severity = Severity::kNote;
  finding.kind = "duplicate";
  finding.where = list_names(pairs);
  finding.confidence = 0.9;
  finding.text =
      fmt::format("{} pair{} of markers {} in one place, to {} mm", pairs.size(),
                  pairs.size() == 1 ? "" : "s", pairs.size() == 1 ? "is" : "are", 1e3 * distance);
  findings.push_back(std::move(finding));
}

}  // namespace

void MarkerCheckOptions::validate() const {
  for (const auto& [name, value] :
       {std::pair{"still", still}, std::pair{"moving", moving}, std::pair{"held", held},
        std::pair{"short_gap", short_gap}, std::pair{"long_gap", long_gap},
        std::pair{"coincident", coincident}, std::pair{"stray", stray},
        std::pair{"step_tolerance", step_tolerance}, std::pair{"least_rate", least_rate}}) {
    if (value > 0.0 && std::isfinite(value)) continue;
    throw std::invalid_argument(
        fmt::format("MarkerCheckOptions::{} is {}; it must be above 0", name, value));
  }
  if (short_gap < long_gap) return;
  throw std::invalid_argument(fmt::format(
      "MarkerCheckOptions::short_gap is {}; it must be below long_gap, {}", short_gap, long_gap));
}

std::vector<Finding> find_static_markers(const MarkerTrajectories& markers,
                                         const MarkerCheckOptions& options) {
  options.validate();
  std::vector<Finding> findings;
  for (int i = 0; i < markers.marker_count(); ++i) {
    const std::vector<int> frames = measured_frames(markers, i);
    // A foot that is seen only while it stands moves as little.
    const bool tells = 10 * frames.size() >= 8 * static_cast<std::size_t>(markers.frame_count());
    if (tells && frames.size() >= 10) {
      const Reach own = reach(markers, i, frames);
      const double others =
          own.size <= options.still ? others_reach(markers, i, thinned(frames, 200)) : 0.0;
      if (others >= options.moving) {
        Finding finding = of_marker(markers, i, "static");
        finding.confidence = 0.95;
        finding.text = fmt::format("stays within {:.1f} mm while the others move by {:.2f} m",
                                   1e3 * own.size, others);
        findings.push_back(std::move(finding));
        continue;
      }
    }
    find_held(markers, i, options, findings);
  }
  return findings;
}

std::vector<Finding> find_missing_markers(const MarkerTrajectories& markers) {
  std::vector<std::string> names;
  Finding finding;
  for (int i = 0; i < markers.marker_count(); ++i) {
    bool any = false;
    for (int f = 0; f < markers.frame_count() && !any; ++f) any = measured(markers, f, i);
    if (any) continue;
    names.push_back(name_of(markers, i));
    finding.flags.insert(finding.flags.end(), {"--drop", names.back()});
  }
  if (names.empty()) return {};
  finding.kind = "missing";
  finding.where = list_names(names);
  finding.confidence = 1.0;
  finding.text = fmt::format("{} of {} markers {} never measured", names.size(),
                             markers.marker_count(), names.size() == 1 ? "is" : "are");
  finding.severity = Severity::kNote;
  if (static_cast<int>(names.size()) == markers.marker_count()) {
    finding.severity = Severity::kError;
    finding.flags.clear();
    finding.advice = "export the trial again, with its trajectories";
  }
  return {finding};
}

std::vector<Finding> find_duplicate_markers(const MarkerTrajectories& markers,
                                            const std::vector<std::string>& labels,
                                            const MarkerCheckOptions& options) {
  options.validate();
  std::vector<Finding> findings;
  find_same_labels(markers, labels, findings);
  find_same_places(markers, options.coincident, findings);
  return findings;
}

std::vector<Finding> find_stray_markers(const MarkerTrajectories& markers,
                                        const MarkerCheckOptions& options) {
  options.validate();
  const auto count = static_cast<std::size_t>(markers.marker_count());
  std::vector<int> seen(count, 0), far(count, 0);
  std::vector<double> distance(count, 0.0);
  const int step = std::max(1, markers.frame_count() / 200);
  for (int f = 0; f < markers.frame_count(); f += step) {
    Vector3d center;
    bool known = true;
    for (int k = 0; k < 3; ++k) {
      std::vector<double> values;
      for (int i = 0; i < markers.marker_count(); ++i) {
        if (measured(markers, f, i)) values.push_back(markers.p_WM(f, 3 * i + k));
      }
      known = known && values.size() >= 4;
      center[k] = median(std::move(values));
    }
    if (!known) continue;
    for (std::size_t i = 0; i < count; ++i) {
      const double d = (markers.position(f, static_cast<int>(i)) - center).norm();
      if (std::isnan(d)) continue;
      ++seen[i];
      if (d > options.stray) ++far[i];
      distance[i] += d;
    }
  }
  std::vector<Finding> findings;
  for (std::size_t i = 0; i < count; ++i) {
    if (seen[i] == 0 || 2 * far[i] < seen[i]) continue;
    Finding finding = of_marker(markers, static_cast<int>(i), "stray");
    finding.confidence = 0.85;
    finding.text = fmt::format("is {:.3g} m from the middle of the others", distance[i] / seen[i]);
    findings.push_back(std::move(finding));
  }
  return findings;
}

}  // namespace sinew
