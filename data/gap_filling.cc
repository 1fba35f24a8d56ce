#include "data/gap_filling.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "data/csv_file.h"
#include "data/gap_prediction.h"
#include "data/numbers.h"
#include "data/text.h"

namespace sinew {
namespace {

// A prediction with its method and how far such predictions are off; NaN where nothing tells.
struct Choice {
  FilledGap filled;
  Eigen::MatrixX3d p_WM;
};

std::optional<Choice> spline_choice(const GapPredictor& predictor, const MarkerGap& gap,
                                    double longest) {
  // Rounding must not leave a gap of exactly the longest.
  if (gap.count > longest * (1.0 + 1e-9)) return std::nullopt;
  auto prediction = predictor.by_spline(gap);
  if (!prediction) return std::nullopt;
  return Choice{{gap, FilledGap::Method::kSpline, predictor.spline_error(gap), {}},
                std::move(prediction->p_WM)};
}

std::optional<Choice> rigid_choice(GapPredictor& predictor, const MarkerGap& gap) {
  auto prediction = predictor.rigidly(gap);
  if (!prediction) return std::nullopt;
  double error = predictor.rigid_error(gap, prediction->from);
  // Helpers that misfit in the gap itself tell of more than others did elsewhere.
  if (!std::isnan(error)) error = std::max(error, prediction->misfit);
  return Choice{{gap, FilledGap::Method::kRigid, error, prediction->from},
                std::move(prediction->p_WM)};
}

bool is_better(const Choice& a, const Choice& b) {
  if (std::isnan(a.filled.error)) return false;
  return std::isnan(b.filled.error) || a.filled.error < b.filled.error;
}

const char* name_of(FilledGap::Method method) {
  switch (method) {
    case FilledGap::Method::kSpline:
      return "spline";
    case FilledGap::Method::kRigid:
      return "rigid";
    case FilledGap::Method::kNone:
      break;
  }
  return "none";
}

}  // namespace

void GapFillOptions::validate() const {
  const auto check = [](const char* field, double value) {
    if (value >= 0.0 && std::isfinite(value)) return;
    throw std::invalid_argument(
        fmt::format("GapFillOptions::{} is {}; it must be at least 0", field, value));
  };
  check("max_gap", max_gap);
  check("max_misfit", max_misfit);
}

std::vector<MarkerGap> find_gaps(const MarkerTrajectories& markers) {
  std::vector<MarkerGap> gaps;
  for (int marker = 0; marker < markers.marker_count(); ++marker) {
    bool inside = false;
    for (int frame = 0; frame < markers.frame_count(); ++frame) {
      const bool missing = std::isnan(markers.p_WM(frame, 3 * marker));
      if (missing && !inside) gaps.push_back({marker, frame, 0});
      if (missing) ++gaps.back().count;
      inside = missing;
    }
  }
  return gaps;
}

GapFillResult fill_gaps(MarkerTrajectories& markers, const GapFillOptions& options) {
  options.validate();
  const MarkerTrajectories measured = markers;
  GapPredictor predictor(measured, options);
  GapFillResult result;
  for (const MarkerGap& gap : find_gaps(measured)) {
    std::optional<Choice> best;
    if (options.rigid) best = rigid_choice(predictor, gap);
    std::optional<Choice> spline = spline_choice(predictor, gap, options.max_gap * markers.rate);
    if (spline && (!best || is_better(*spline, *best))) best = std::move(spline);
    if (!best) {
      result.left.push_back(gap);
      continue;
    }
    markers.p_WM.block(gap.first, 3 * gap.marker, gap.count, 3) = best->p_WM;
    result.filled.push_back(std::move(best->filled));
  }
  return result;
}

std::string filled_gaps_csv(const MarkerTrajectories& markers, const GapFillResult& result) {
  const auto name = [&](int i) { return markers.names[static_cast<std::size_t>(i)]; };
  std::string out = "marker,first_frame,last_frame,from_s,to_s,frames,method,error_m,taken_from\n";
  std::vector<FilledGap> all = result.filled;
  for (const MarkerGap& gap : result.left) all.push_back({gap, FilledGap::Method::kNone, kNaN, {}});
  for (const FilledGap& f : all) {
    const int last = f.gap.first + f.gap.count - 1;
    std::vector<std::string> helpers;
    for (const int i : f.from) helpers.push_back(name(i));
    out += fmt::format("{},{},{},{},{},{},{},{},{}\n", csv_cell(name(f.gap.marker)),
                       markers.frame_numbers[static_cast<std::size_t>(f.gap.first)],
                       markers.frame_numbers[static_cast<std::size_t>(last)],
                       text::format_number(markers.time[f.gap.first]),
                       text::format_number(markers.time[last]), f.gap.count, name_of(f.method),
                       std::isnan(f.error) ? "" : fmt::format("{:.3g}", f.error),
                       csv_cell(fmt::format("{}", fmt::join(helpers, " "))));
  }
  return out;
}

}  // namespace sinew
