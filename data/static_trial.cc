#include "data/static_trial.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <string>

#include "data/numbers.h"
#include "data/rigid_fit.h"
#include "data/statistics.h"

namespace sinew {
namespace {

constexpr double kStandingSway = 0.03;     // [m]
constexpr double kMovingSway = 0.06;       // [m], above which nobody only stands
constexpr double kLeastStretch = 0.25;     // [s], over which noise averages out
constexpr int kLooks = 400;                // frames that movement is looked at in
constexpr int kFrames = 200;               // and distances
constexpr double kApart = 0.15;            // [m]
constexpr double kKept = 0.01;             // [m]
constexpr int kLeastPairs = 6;             // fewer agree or differ by chance
constexpr double kOneSubject = 0.01;       // [m]
constexpr double kSlides = 0.025;          // [m]
constexpr double kChanged = 0.03;          // [m] published pairs of trials: up to 25 mm, at wrists
constexpr std::size_t kEnough = 10;        // frames, to tell whether a distance is kept
constexpr std::size_t kFewestCarried = 4;  // markers of a segment: three tell where the fourth is

// RMS over the markers that are in both of how far they are from `middle`; NaN if none is.
double distance_from(const MarkerTrajectories& markers, int frame,
                     const Eigen::RowVectorXd& middle) {
  double sum = 0.0;
  int count = 0;
  for (int m = 0; m < markers.marker_count(); ++m) {
    const double d = (markers.p_WM.row(frame) - middle).segment<3>(3 * m).squaredNorm();
    if (!std::isfinite(d)) continue;
    sum += d;
    ++count;
  }
  return count == 0 ? std::nan("") : std::sqrt(sum / count);
}

// Middle positions over the frames.
Eigen::RowVectorXd middle_of(const MarkerTrajectories& markers, const std::vector<int>& frames) {
  Eigen::RowVectorXd middle(markers.p_WM.cols());
  for (Eigen::Index c = 0; c < middle.size(); ++c) {
    std::vector<double> values;
    for (const int f : frames) {
      if (std::isfinite(markers.p_WM(f, c))) values.push_back(markers.p_WM(f, c));
    }
    middle[c] = median(std::move(values));
  }
  return middle;
}

// The sway that 95 % of the frames stay below.
double sway_of(const MarkerTrajectories& markers, const std::vector<int>& frames) {
  const Eigen::RowVectorXd middle = middle_of(markers, frames);
  std::vector<double> sway;
  for (const int f : frames) {
    const double d = distance_from(markers, f, middle);
    if (std::isfinite(d)) sway.push_back(d);
  }
  if (sway.empty()) return std::nan("");
  std::sort(sway.begin(), sway.end());
  return sway[static_cast<std::size_t>(0.95 * static_cast<double>(sway.size() - 1))];
}

std::vector<int> every(int frames, int most) {
  std::vector<int> chosen;
  const int step = std::max(1, frames / most);
  for (int f = 0; f < frames; f += step) chosen.push_back(f);
  return chosen;
}

void find_stillest(const MarkerTrajectories& markers, const std::vector<int>& looks,
                   TrialMovement& movement) {
  const auto within = [&](std::size_t first, std::size_t end) {
    return std::vector<int>(looks.begin() + static_cast<std::ptrdiff_t>(first),
                            looks.begin() + static_cast<std::ptrdiff_t>(end));
  };
  const auto time = [&](std::size_t i) { return markers.time[looks[i]]; };
  double least = kStandingSway;
  std::size_t first = 0, end = 0;
  for (std::size_t i = 0, j = 0; i < looks.size(); ++i) {
    while (j < looks.size() && time(j) - time(i) < kLeastStretch) ++j;
    if (j == looks.size()) break;
    const double sway = sway_of(markers, within(i, j + 1));
    if (!(sway < least)) continue;
    least = sway;
    first = i;
    end = j + 1;
  }
  if (end == 0) return;
  while (end < looks.size() && sway_of(markers, within(first, end + 1)) < kStandingSway) ++end;
  while (first > 0 && sway_of(markers, within(first - 1, end)) < kStandingSway) --first;
  movement.still_from = time(first);
  movement.still_to = time(end - 1);
}

std::vector<double> distances(const MarkerTrajectories& markers, int a, int b) {
  std::vector<double> all;
  for (const int f : every(markers.frame_count(), kFrames)) {
    const double d = (markers.position(f, a) - markers.position(f, b)).norm();
    if (std::isfinite(d)) all.push_back(d);
  }
  return all;
}

double standard_deviation(const std::vector<double>& values) {
  double sum = 0.0, squares = 0.0;
  for (const double v : values) sum += v;
  const double mean = sum / static_cast<double>(values.size());
  for (const double v : values) squares += (v - mean) * (v - mean);
  return std::sqrt(squares / static_cast<double>(values.size()));
}

// A marker that both trials have.
struct Common {
  std::string name;
  int moving;             // its index there
  Eigen::Vector3d place;  // in the middle of the static trial
  double change;          // as StaticMarker's; 0 if unknown
};

// How far a marker of a segment sits from where the others carry its place to, and how well those
// fit, on average over the moving trial [m].
struct Carried {
  double change = kNaN;  // where they do not tell it
  double misfit = std::numeric_limits<double>::infinity();
};

Carried carried_place(const MarkerTrajectories& moving, const std::vector<Common>& markers,
                      std::size_t which) {
  constexpr double kLeastWidth = 0.03;  // [m] narrower ones turn with the skin
  const auto count_of = static_cast<Eigen::Index>(markers.size());
  Eigen::Matrix3Xd places(3, count_of), measured(3, count_of);
  for (Eigen::Index i = 0; i < count_of; ++i) {
    places.col(i) = markers[static_cast<std::size_t>(i)].place;
  }
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double misfit = 0.0;
  int count = 0;
  for (const int f : every(moving.frame_count(), kFrames)) {
    const Eigen::Vector3d p = moving.position(f, markers[which].moving);
    Eigen::VectorXd weights = Eigen::VectorXd::Zero(count_of);
    for (Eigen::Index i = 0; i < count_of; ++i) {
      measured.col(i) = moving.position(f, markers[static_cast<std::size_t>(i)].moving);
      if (measured.col(i).allFinite()) {
        weights[i] = i == static_cast<Eigen::Index>(which) ? 0.0 : 1.0;
      } else {
        measured.col(i).setZero();
      }
    }
    if (weights.sum() < 3.0 || !p.allFinite()) continue;
    const RigidFit fit = fit_rigidly(places, measured, weights);
    // Of others that were moved themselves nothing follows.
    if (fit.width < kLeastWidth || fit.misfit > kKept) continue;
    sum += fit.R.transpose() * (p - fit.t) - markers[which].place;
    misfit += fit.misfit;
    ++count;
  }
  if (count < static_cast<int>(kEnough)) return {};
  return {sum.norm() / count, misfit / count};
}

VerdictReason reason(const char* code, VerdictReason::Weight weight, double figure, double limit,
                     std::string text, std::string remedy) {
  VerdictReason made;
  made.code = code;
  made.weight = weight;
  made.figure = 1e3 * figure;
  made.limit = 1e3 * limit;
  made.unit = "mm";
  made.text = std::move(text);
  made.source = "Sinew";
  made.remedy = std::move(remedy);
  return made;
}

VerdictReason static_marker(double change, double limit, const std::string& text,
                            const std::string& drop) {
  return reason("static-marker", VerdictReason::Weight::kRemark, change, limit, text,
                "--drop " + drop + ", or --scale walk leaves the static trial out");
}

// Of a segment with enough markers: those that sit elsewhere among the others.
void find_moved(const MarkerTrajectories& moving, std::vector<Common> markers,
                std::vector<VerdictReason>& reasons) {
  while (markers.size() >= kFewestCarried) {
    // Where one was moved, its others still fit each other best.
    Carried best;
    std::size_t which = 0;
    for (std::size_t i = 0; i < markers.size(); ++i) {
      const Carried carried = carried_place(moving, markers, i);
      if (!(carried.change > kSlides) || !(carried.misfit < best.misfit)) continue;
      best = carried;
      which = i;
    }
    if (std::isnan(best.change)) return;
    const std::string& name = markers[which].name;
    reasons.push_back(static_marker(
        best.change, kSlides,
        name + " sat elsewhere among the markers of its segment in the static trial", name));
    markers.erase(markers.begin() + static_cast<std::ptrdiff_t>(which));
  }
}

// Of a segment with two or three, by a fit of both trials: joints take a part of what one does to
// the others, so that it changes most.
bool find_changed(const std::vector<Common>& markers, std::vector<VerdictReason>& reasons) {
  const auto less = [](const Common& a, const Common& b) { return a.change < b.change; };
  const auto most = std::max_element(markers.begin(), markers.end(), less);
  if (!(most->change > kChanged)) return false;
  reasons.push_back(static_marker(most->change, kChanged,
                                  most->name + " sat elsewhere on its segment in the static trial",
                                  most->name));
  return true;
}

// The same by distances: which of two that differ nothing tells.
void find_moved_pairs(const MarkerTrajectories& moving, const std::vector<Common>& markers,
                      std::vector<VerdictReason>& reasons) {
  for (std::size_t i = 0; i < markers.size(); ++i) {
    for (std::size_t j = i + 1; j < markers.size(); ++j) {
      const Common &a = markers[i], &b = markers[j];
      const std::vector<double> then = distances(moving, a.moving, b.moving);
      if (then.size() < kEnough || standard_deviation(then) > kKept) continue;
      const double change = std::abs((a.place - b.place).norm() - median(then));
      if (!(change > kSlides)) continue;
      reasons.push_back(static_marker(
          change, kSlides,
          fmt::format("{} or {} sat elsewhere in the static trial: their distance differs", a.name,
                      b.name),
          "the one that was put on anew"));
    }
  }
}

}  // namespace

TrialMovement trial_movement(const MarkerTrajectories& markers) {
  TrialMovement movement;
  const std::vector<int> looks = every(markers.frame_count(), kLooks);
  movement.sway = sway_of(markers, looks);
  find_stillest(markers, looks, movement);
  return movement;
}

bool stands_still(const TrialMovement& movement) { return movement.sway <= kStandingSway; }

SegmentAgreement compare_segments(const MarkerTrajectories& standing,
                                  const MarkerTrajectories& moving) {
  std::vector<double> differences;
  for (int i = 0; i < standing.marker_count(); ++i) {
    const int a = moving.find_marker(standing.names[static_cast<std::size_t>(i)]);
    for (int j = i + 1; a >= 0 && j < standing.marker_count(); ++j) {
      const int b = moving.find_marker(standing.names[static_cast<std::size_t>(j)]);
      if (b < 0) continue;
      const std::vector<double> then = distances(moving, a, b), now = distances(standing, i, j);
      if (then.size() < kEnough || now.empty() || standard_deviation(then) > kKept) continue;
      const double middle = median(then);
      if (middle >= kApart) differences.push_back(std::abs(median(now) - middle));
    }
  }
  SegmentAgreement agreement;
  agreement.pairs = static_cast<int>(differences.size());
  if (differences.empty()) return agreement;
  std::sort(differences.begin(), differences.end());
  agreement.difference = differences[differences.size() / 4];
  return agreement;
}

std::vector<VerdictReason> static_trial_reasons(const MarkerTrajectories& standing,
                                                const MarkerTrajectories& moving) {
  using Weight = VerdictReason::Weight;
  std::vector<VerdictReason> reasons;
  const TrialMovement first = trial_movement(standing), second = trial_movement(moving);
  const bool stands = stands_still(second);
  if (first.sway > kMovingSway && stands) {
    reasons.push_back(reason(
        "trials-exchanged", Weight::kUnusable, first.sway, kStandingSway,
        fmt::format("the two trials seem exchanged: the subject moves by {:.0f} mm in the static "
                    "trial and by {:.0f} mm in the other",
                    1e3 * first.sway, 1e3 * second.sway),
        "give the trial that moves as --c3d and the one that stands as --static"));
  } else if (first.sway > kStandingSway) {
    const bool still = std::isfinite(first.still_from);
    reasons.push_back(reason(
        "static-moves", Weight::kRemark, first.sway, kStandingSway,
        fmt::format("the subject moves by {:.0f} mm in the static trial", 1e3 * first.sway),
        still ? fmt::format("--scale walk leaves it out; it is still from {} s to {} s, which "
                            "`sinew convert --from {} --to {}` cuts out",
                            time_text(first.still_from), time_text(first.still_to),
                            time_text(first.still_from), time_text(first.still_to))
              : "--scale walk leaves it out"));
  }
  // Nothing tells which distances are a segment's where nothing moves.
  if (stands) return reasons;
  const SegmentAgreement agreement = compare_segments(standing, moving);
  if (agreement.pairs >= kLeastPairs && agreement.difference > kOneSubject) {
    reasons.push_back(
        reason("other-person", Weight::kUnusable, agreement.difference, kOneSubject,
               fmt::format("the static trial seems to be of another person, or its markers sat "
                           "elsewhere: three quarters of {} distances within segments differ by "
                           "{:.0f} mm or more",
                           agreement.pairs, 1e3 * agreement.difference),
               "give the subject's own static trial, or --scale walk to leave it out"));
  }
  return reasons;
}

std::vector<VerdictReason> static_marker_reasons(const MarkerTrajectories& standing,
                                                 const MarkerTrajectories& moving,
                                                 const std::vector<StaticMarker>& known) {
  const Eigen::RowVectorXd places = middle_of(standing, every(standing.frame_count(), kFrames));
  std::map<int, std::vector<Common>> common;  // of each segment
  for (std::size_t i = 0; i < known.size(); ++i) {
    const int m = moving.find_marker(standing.names[i]);
    const Eigen::Vector3d p = places.segment<3>(3 * static_cast<Eigen::Index>(i)).transpose();
    if (known[i].segment >= 0 && m >= 0 && p.allFinite()) {
      const double change = std::isnan(known[i].change) ? 0.0 : known[i].change;
      common[known[i].segment].push_back({standing.names[i], m, p, change});
    }
  }
  std::vector<VerdictReason> reasons;
  for (const auto& [segment, markers] : common) {
    if (markers.size() >= kFewestCarried) {
      find_moved(moving, markers, reasons);
    } else if (!find_changed(markers, reasons)) {
      find_moved_pairs(moving, markers, reasons);
    }
  }
  return reasons;
}

std::vector<VerdictReason> static_against_walk_reasons(double static_rms, double walk_rms) {
  constexpr double kSoftTissue = 0.01;  // [m]
  if (!(walk_rms - static_rms > kSoftTissue)) return {};
  return {
      reason("static-rms", VerdictReason::Weight::kRemark, walk_rms - static_rms, kSoftTissue,
             fmt::format("markers are met to {:.1f} mm RMS in the static trial but to {:.1f} mm "
                         "in the walk",
                         1e3 * static_rms, 1e3 * walk_rms),
             "--scale both fits sizes and markers to both trials")};
}

std::vector<VerdictReason> static_pose_reasons(double static_rms) {
  constexpr double kMost = 0.02;  // [m]
  if (!(static_rms > kMost)) return {};
  const auto weight =
      static_rms > 2.0 * kMost ? VerdictReason::Weight::kUnusable : VerdictReason::Weight::kRemark;
  VerdictReason made = reason(
      "static-pose", weight, static_rms, kMost,
      fmt::format(
          "the model cannot take the pose of the static trial: markers are met to {:.0f} mm "
          "RMS only, and sizes fitted to it are not the subject's",
          1e3 * static_rms),
      "--scale walk leaves the static trial out; or look at its markers (--map) and joint ranges");
  made.source = "Hicks et al. 2015";
  return {made};
}

Finding finding_of(const VerdictReason& reason) {
  Finding finding;
  finding.severity = reason.weight == VerdictReason::Weight::kUnusable
                         ? Finding::Severity::kError
                         : Finding::Severity::kWarning;
  finding.kind = reason.code;
  std::replace(finding.kind.begin(), finding.kind.end(), '-', ' ');
  finding.text = reason.text;
  finding.confidence = 0.9;
  finding.advice = reason.remedy;
  return finding;
}

}  // namespace sinew
