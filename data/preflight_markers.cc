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

struct GapClass {
  double longest;
  Severity severity;
  double confidence;
  std::vector<std::string> flags;
  const char* what;
  const char* advice;
};

Finding describe_gaps(const MarkerTrajectories& markers, const std::vector<MarkerGap>& gaps,
                      const GapClass& of) {
  std::map<int, int> by_marker;
  for (const MarkerGap& gap : gaps) ++by_marker[gap.marker];
  std::vector<std::string> names;
  // Gaps come longest first, and so do the names.
  for (const MarkerGap& gap : gaps) {
    const std::string& name = name_of(markers, gap.marker);
    if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
  }
  const MarkerGap& longest = gaps.front();
  Finding finding;
  finding.severity = of.severity;
  finding.kind = "gap";
  finding.where = list_names(names);
  finding.confidence = of.confidence;
  set_frames(finding, markers, longest.first, longest.first + longest.count - 1);
  finding.text =
      fmt::format("{} gap{} {}; the longest, of {} frames ({} s), is in {}", gaps.size(),
                  gaps.size() == 1 ? "" : "s", of.what, longest.count,
                  time_text(longest.count / markers.rate), name_of(markers, longest.marker));
  finding.flags = of.flags;
  finding.advice = of.advice;
  return finding;
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

std::vector<Finding> find_timing_faults(const MarkerTrajectories& markers,
                                        const MarkerCheckOptions& options) {
  options.validate();
  std::vector<Finding> findings;
  const int frames = markers.frame_count();
  const auto add = [&](Severity severity, const char* kind, std::string text, double confidence) {
    Finding finding;
    finding.severity = severity;
    finding.kind = kind;
    finding.text = std::move(text);
    finding.confidence = confidence;
    findings.push_back(std::move(finding));
    return &findings.back();
  };
  if (frames == 0) return findings;
  if (const int first = markers.frame_numbers.front(); first != 1) {
    add(Severity::kNote, "first frame",
        fmt::format("the first frame has the number {}; its time is {} s", first,
                    time_text(markers.time[0])),
        1.0)
        ->advice = "--from and --to count seconds of these times";
  }
  if (markers.rate < options.least_rate) {
    add(Severity::kNote, "rate",
        fmt::format("{} frames per second leave heel strikes between two frames",
                    text::format_number(markers.rate)),
        0.9)
        ->advice = "record at 100 Hz or more";
  }
  if (frames < 3) return findings;
  const double mean = (markers.time[frames - 1] - markers.time[0]) / (frames - 1);
  int odd = 0, worst = 1;
  for (int f = 1; f < frames; ++f) {
    const auto off = [&](int g) { return std::abs(markers.time[g] - markers.time[g - 1] - mean); };
    if (off(f) > options.step_tolerance * mean) ++odd;
    if (off(f) > off(worst)) worst = f;
  }
  if (odd > 0) {
    Finding* finding =
        add(Severity::kWarning, "rate",
            fmt::format("{} of {} steps of time differ from the mean, {} s, by more than {:.0f} %; "
                        "one is {} s",
                        odd, frames - 1, time_text(mean), 100.0 * options.step_tolerance,
                        time_text(markers.time[worst] - markers.time[worst - 1])),
            0.95);
    set_frames(*finding, markers, worst - 1, worst);
    finding->flags = {"--rate", text::format_number(std::round(1.0 / mean))};
  }
  // Rates in headers are rounded to some digits, times to milliseconds.
  if (std::abs(markers.rate * mean - 1.0) > 0.02) {
    add(Severity::kWarning, "rate",
        fmt::format("the file's rate is {} Hz, its times step at {:.6g} Hz",
                    text::format_number(markers.rate), 1.0 / mean),
        0.95)
        ->flags = {"--rate", text::format_number(std::round(1.0 / mean))};
  }
  int missing = 0;
  for (std::size_t f = 1; f < markers.frame_numbers.size(); ++f) {
    missing += std::max(0, markers.frame_numbers[f] - markers.frame_numbers[f - 1] - 1);
  }
  if (missing > 0 && odd > 0) {
    add(Severity::kWarning, "rate", fmt::format("{} frame numbers are left out", missing), 0.95)
        ->flags = {"--rate", text::format_number(std::round(markers.rate))};
  }
  return findings;
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

std::vector<MarkerGap> find_inner_gaps(const MarkerTrajectories& markers) {
  std::vector<MarkerGap> gaps = find_gaps(markers);
  std::erase_if(gaps, [&](const MarkerGap& gap) {
    return gap.first == 0 || gap.first + gap.count == markers.frame_count();
  });
  std::stable_sort(gaps.begin(), gaps.end(),
                   [](const MarkerGap& a, const MarkerGap& b) { return a.count > b.count; });
  return gaps;
}

std::vector<Finding> find_gap_faults(const MarkerTrajectories& markers,
                                     const MarkerCheckOptions& options) {
  options.validate();
  // A thousandth of a step on top, so that lengths that are whole frames are within.
  const double step = 1.0 / markers.rate;
  const std::string by_spline = time_text(options.short_gap);
  const GapClass classes[] = {
      {std::numeric_limits<double>::infinity(),
       Severity::kWarning,
       0.9,
       {"--fill-rigid"},
       "longer than half a second",
       "fills it where three markers of the same segment are seen; else weigh the marker 0"},
      {options.long_gap, Severity::kNote, 0.9, {"--fill-rigid"}, "of medium length", ""},
      {options.short_gap,
       Severity::kNote,
       0.95,
       {"--max-gap", by_spline},
       "short enough for a spline",
       ""}};
  std::vector<Finding> findings;
  const std::vector<MarkerGap> gaps = find_inner_gaps(markers);
  for (std::size_t k = 0; k < std::size(classes); ++k) {
    const double shortest = k + 1 < std::size(classes) ? classes[k + 1].longest : 0.0;
    std::vector<MarkerGap> within;
    for (const MarkerGap& gap : gaps) {
      const double length = gap.count * step;
      if (length <= classes[k].longest + 1e-3 * step && length > shortest + 1e-3 * step) {
        within.push_back(gap);
      }
    }
    if (!within.empty()) findings.push_back(describe_gaps(markers, within, classes[k]));
  }
  return findings;
}

}  // namespace sinew
