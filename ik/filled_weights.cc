#include "ik/filled_weights.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace sinew {
namespace {

void require_frames(const MarkerTrajectories& markers, const FilledStretch& stretch) {
  if (stretch.first >= 0 && stretch.count >= 0 &&
      stretch.first + stretch.count <= markers.frame_count()) {
    return;
  }
  throw std::invalid_argument(fmt::format(
      "filled samples {} to {} of {} are not in a recording of {} frames", stretch.first,
      stretch.first + stretch.count - 1, stretch.marker, markers.frame_count()));
}

// b of the header.
double bump(double x) { return x >= 1.0 ? 0.0 : 1.0 - x * x * x * (10.0 + x * (-15.0 + 6.0 * x)); }

void weigh(const MarkerTrajectories& markers, const FilledStretch& stretch, double level,
           Eigen::Ref<Eigen::VectorXd, 0, Eigen::InnerStride<>> scales) {
  const int last = stretch.first + stretch.count - 1;
  const auto lower = [&](int f) {
    const double away = std::max(
        {markers.time[stretch.first] - markers.time[f], markers.time[f] - markers.time[last], 0.0});
    const double part = bump(away / kWeightTaper);
    scales[f] *= 1.0 - (1.0 - level) * part;
    return part > 0.0;
  };
  for (int f = stretch.first; f <= last; ++f) lower(f);
  for (int f = stretch.first - 1; f >= 0 && lower(f);) --f;
  for (int f = last + 1; f < markers.frame_count() && lower(f);) ++f;
}

// Of the markers that are there, the one that weighs most keeps its weight.
void scale_back(const TrackingProblem& tracking, const MarkerTrajectories& markers, int frame,
                Eigen::Ref<Eigen::RowVectorXd, 0, Eigen::InnerStride<>> scales) {
  double most = 0.0;
  for (std::size_t i = 0; i < tracking.markers.size(); ++i) {
    if (std::isnan(markers.p_WM(frame, 3 * tracking.markers[i].recorded))) continue;
    most = std::max(most, scales[static_cast<Eigen::Index>(i)]);
  }
  if (most > 0.0 && most < 1.0) scales /= most;
  scales = scales.cwiseMin(1.0);
}

}  // namespace

double filled_weight(double error, double unknown_weight) {
  if (!(unknown_weight >= 0.0 && unknown_weight <= 1.0)) {
    throw std::invalid_argument(
        fmt::format("a filled sample's weight is {}; expected 0 to 1", unknown_weight));
  }
  if (std::isnan(error)) return unknown_weight;
  if (std::isinf(error) || unknown_weight == 0.0) return 0.0;
  const double ratio = error / kFilledError;
  return 1.0 / (1.0 + (1.0 / unknown_weight - 1.0) * ratio * ratio);
}

void weigh_filled_samples(TrackingProblem& tracking, const MarkerTrajectories& markers,
                          const std::vector<FilledStretch>& stretches, double unknown_weight) {
  filled_weight(0.0, unknown_weight);  // throws for what is no weight
  const auto columns = static_cast<Eigen::Index>(tracking.markers.size());
  tracking.marker_scales = RowMatrix::Ones(markers.frame_count(), columns);
  tracking.filled.setConstant(markers.frame_count(), columns, false);
  for (const FilledStretch& stretch : stretches) {
    require_frames(markers, stretch);
    if (stretch.count == 0) continue;
    const double level = filled_weight(stretch.error, unknown_weight);
    for (Eigen::Index i = 0; i < columns; ++i) {
      if (tracking.markers[static_cast<std::size_t>(i)].name != stretch.marker) continue;
      weigh(markers, stretch, level, tracking.marker_scales.col(i));
      tracking.filled.col(i).segment(stretch.first, stretch.count).setConstant(true);
    }
  }
  for (int f = 0; f < markers.frame_count(); ++f) {
    scale_back(tracking, markers, f, tracking.marker_scales.row(f));
  }
}

}  // namespace sinew
