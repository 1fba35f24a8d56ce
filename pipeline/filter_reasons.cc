#include "pipeline/filter_reasons.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "data/conditioning.h"
#include "pipeline/verdict_limits.h"
#include "pipeline/verdict_reasons.h"

namespace sinew {
namespace {

// What of people's movements lies above is mostly noise, which filters are for: walking has 99.7 %
// of its power below (Winter 2009, sec. 3.4.4) [Hz].
constexpr double kMovement = 6.0;

CoordinateSpline movement_of(const MusculoskeletalModel& model, const CoordinateTable& motion) {
  const auto steps = static_cast<double>(motion.time.size() - 1);
  const double rate = steps / (motion.time[motion.time.size() - 1] - motion.time[0]);
  return motion_spline(model, motion, kMovement < 0.5 * rate ? kMovement : -1.0);
}

}  // namespace

std::vector<VerdictReason> angle_filter_reasons(const MusculoskeletalModel& model,
                                                const CoordinateTable& motion, double cutoff) {
  if (cutoff < 0.0 || cutoff >= kMovement) return {};
  const CoordinateSpline spline = motion_spline(model, motion, cutoff),
                         whole = movement_of(model, motion);
  Eigen::RowVectorXd q(spline.size()), q_whole(spline.size());
  Eigen::VectorXd squares = Eigen::VectorXd::Zero(spline.size());
  for (Eigen::Index f = 0; f < motion.time.size(); ++f) {
    spline.evaluate(motion.time[f], {q.data(), static_cast<std::size_t>(q.size())}, {}, {});
    whole.evaluate(motion.time[f], {q_whole.data(), static_cast<std::size_t>(q.size())}, {}, {});
    squares += (q - q_whole).cwiseAbs2().transpose();
  }
  int most = -1;
  std::vector<std::string> torques;
  for (std::size_t c = 0; c < model.coordinates.size(); ++c) {
    torques.push_back(model.coordinates[c].name);
    if (model.coordinates[c].motion != Coordinate::Motion::kRotational) continue;
    const auto i = static_cast<Eigen::Index>(c);
    if (most < 0 || squares[i] > squares[most]) most = static_cast<int>(c);
  }
  if (most < 0) return {};
  const double rms = std::sqrt(squares[most] / static_cast<double>(motion.time.size()));
  std::vector<VerdictReason> reasons;
  if (auto* r =
          judge_figure(reasons, {rms, limits::kFiltered, limits::kWorstFiltered},
                       180.0 / std::numbers::pi, "degrees", "angle-filter", limits::kMcGinley)) {
    r->text = fmt::format("the filter of {} Hz takes part of the movement away, most of {} (RMS)",
                          cutoff, torques[static_cast<std::size_t>(most)]);
    r->remedy = "--cutoff: 6 Hz keeps a walk, 15 Hz a run, -1 does not filter";
    if (r->weight == VerdictReason::Weight::kUnusable) r->torques = torques;
  }
  return reasons;
}

std::vector<VerdictReason> marker_filter_reasons(const MarkerTrajectories& markers,
                                                 const MarkerTrajectories& filtered,
                                                 double cutoff) {
  if (cutoff < 0.0 || cutoff >= kMovement) return {};
  MarkerTrajectories whole = markers;
  if (kMovement < 0.5 * markers.rate) lowpass(whole, kMovement);
  double rms = 0.0;
  int most = -1;
  for (int m = 0; m < markers.marker_count(); ++m) {
    double sum = 0.0;
    int count = 0;
    for (int f = 0; f < markers.frame_count(); ++f) {
      const double d = (filtered.position(f, m) - whole.position(f, m)).squaredNorm();
      if (std::isnan(d)) continue;
      sum += d;
      ++count;
    }
    if (count == 0 || !(std::sqrt(sum / count) > rms)) continue;
    rms = std::sqrt(sum / count);
    most = m;
  }
  std::vector<VerdictReason> reasons;
  if (auto* r = judge_figure(reasons, {rms, limits::kFilteredMarker, limits::kWorstFilteredMarker},
                             1e3, "mm", "marker-filter", limits::kOwn)) {
    r->text = fmt::format("the filter of {} Hz takes part of the movement away, most of {} (RMS)",
                          cutoff, markers.names[static_cast<std::size_t>(most)]);
    r->remedy = "--marker-cutoff: 6 Hz keeps a walk, 15 Hz a run, -1 does not filter";
  }
  return reasons;
}

}  // namespace sinew
