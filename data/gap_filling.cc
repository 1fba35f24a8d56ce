#include "data/gap_filling.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>
#include <utility>

#include "data/csv_file.h"
#include "data/natural_spline.h"
#include "data/text.h"

namespace sinew {
namespace {

using Eigen::Vector3d;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
// Beyond ten frames a cubic spline forgets its data: each decays by 0.27.
constexpr int kSplineFrames = 10;
constexpr int kFewestNeighbours = 2;
// A fourth marker averages, an eighth adds nothing.
constexpr std::size_t kMostHelpers = 7;
// Skin moves markers of one segment by less than this, joints move others by more [m].
constexpr double kRigidDistance = 0.007;
constexpr int kFewestCommonFrames = 20;
// Markers within a centimetre of one line tell no turn about it [m].
constexpr double kLeastWidth = 0.01;

// The rotation and shift that carries one cloud onto another best.
struct Motion {
  Eigen::Matrix3d R;
  Vector3d t;
  double misfit = 0.0;  // RMS
};

std::optional<Motion> fit_motion(const std::vector<Vector3d>& from,
                                 const std::vector<Vector3d>& to) {
  const auto n = static_cast<double>(from.size());
  Vector3d a = Vector3d::Zero(), b = Vector3d::Zero();
  for (std::size_t i = 0; i < from.size(); ++i) {
    a += from[i] / n;
    b += to[i] / n;
  }
  Eigen::Matrix3d H = Eigen::Matrix3d::Zero(), spread = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i < from.size(); ++i) {
    H += (from[i] - a) * (to[i] - b).transpose();
    spread += (from[i] - a) * (from[i] - a).transpose();
  }
  const Eigen::Vector3d width = spread.jacobiSvd().singularValues();
  if (!(std::sqrt(width[1]) > kLeastWidth)) return std::nullopt;
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(H, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Matrix3d D = Eigen::Matrix3d::Identity();
  D(2, 2) = (svd.matrixV() * svd.matrixU().transpose()).determinant() < 0.0 ? -1.0 : 1.0;
  Motion motion;
  motion.R = svd.matrixV() * D * svd.matrixU().transpose();
  motion.t = b - motion.R * a;
  double sum = 0.0;
  for (std::size_t i = 0; i < from.size(); ++i) {
    sum += (motion.R * from[i] + motion.t - to[i]).squaredNorm();
  }
  motion.misfit = std::sqrt(sum / n);
  return motion;
}

class Filler {
 public:
  Filler(MarkerTrajectories& markers, const GapFillOptions& options)
      : markers_(markers), measured_(markers), options_(options) {}

  GapFillResult fill() {
    GapFillResult result;
    for (const MarkerGap& gap : find_gaps(measured_)) {
      std::optional<FilledGap> filled;
      if (options_.rigid) filled = fill_rigidly(gap);
      if (!filled) filled = fill_by_spline(gap);
      if (filled) {
        result.filled.push_back(*filled);
      } else {
        result.left.push_back(gap);
      }
    }
    return result;
  }

 private:
  bool is_measured(int frame, int marker) const {
    return frame >= 0 && frame < measured_.frame_count() &&
           !std::isnan(measured_.p_WM(frame, 3 * marker));
  }

  // ---- splines

  // Measured frames next to first … end − 1, up to kSplineFrames on each side.
  std::vector<int> neighbours(int marker, int first, int end) const {
    std::vector<int> frames;
    for (int f = first - 1; is_measured(f, marker) && first - f <= kSplineFrames; --f) {
      frames.push_back(f);
    }
    std::reverse(frames.begin(), frames.end());
    for (int f = end; is_measured(f, marker) && f - end < kSplineFrames; ++f) frames.push_back(f);
    return frames;
  }

  // Positions in first … first + count − 1; nothing where too few frames lie around them.
  std::optional<Eigen::MatrixX3d> interpolate(int marker, int first, int count) const {
    const std::vector<int> frames = neighbours(marker, first, first + count);
    const auto before =
        std::count_if(frames.begin(), frames.end(), [&](int f) { return f < first; });
    const auto behind = static_cast<std::ptrdiff_t>(frames.size()) - before;
    if (before < kFewestNeighbours || behind < kFewestNeighbours) return std::nullopt;
    Eigen::VectorXd x(static_cast<Eigen::Index>(frames.size()));
    Eigen::MatrixXd y(x.size(), 3);
    for (Eigen::Index i = 0; i < x.size(); ++i) {
      const int frame = frames[static_cast<std::size_t>(i)];
      x[i] = frame - first;
      y.row(i) = measured_.position(frame, marker).transpose();
    }
    const Eigen::MatrixXd c = natural_spline_coefficients(x, y, 2);
    const Eigen::Index interval = before - 1;
    Eigen::MatrixX3d p(count, 3);
    for (int i = 0; i < count; ++i) {
      const double dx = i - x[interval];
      p.row(i) = c.row(4 * interval) +
                 dx * (c.row(4 * interval + 1) +
                       dx * (c.row(4 * interval + 2) + dx * c.row(4 * interval + 3)));
    }
    return p;
  }

  // RMS error of interpolating as many measured frames, just before or behind the gap.
  double spline_error(const MarkerGap& gap) const {
    double sum = 0.0;
    int frames = 0;
    for (const int first :
         {gap.first - gap.count - kFewestNeighbours, gap.first + gap.count + kFewestNeighbours}) {
      bool whole = true;
      for (int i = 0; i < gap.count; ++i) whole = whole && is_measured(first + i, gap.marker);
      if (!whole) continue;
      const auto p = interpolate(gap.marker, first, gap.count);
      if (!p) continue;
      for (int i = 0; i < gap.count; ++i) {
        sum += (p->row(i).transpose() - measured_.position(first + i, gap.marker)).squaredNorm();
      }
      frames += gap.count;
    }
    return frames > 0 ? std::sqrt(sum / frames) : kNaN;
  }

  std::optional<FilledGap> fill_by_spline(const MarkerGap& gap) {
    // Rounding must not leave a gap of exactly the longest.
    if (gap.count > options_.max_gap * measured_.rate * (1.0 + 1e-9)) return std::nullopt;
    const auto p = interpolate(gap.marker, gap.first, gap.count);
    if (!p) return std::nullopt;
    markers_.p_WM.block(gap.first, 3 * gap.marker, gap.count, 3) = *p;
    return FilledGap{gap, FilledGap::Method::kSpline, spline_error(gap), {}};
  }

  // ---- rigid segments

  // The standard deviation of the distance between two markers; NaN where they are seldom together.
  double distance_deviation(int a, int b) const {
    double mean = 0.0, square = 0.0;
    int count = 0;
    for (int frame = 0; frame < measured_.frame_count(); ++frame) {
      if (!is_measured(frame, a) || !is_measured(frame, b)) continue;
      const double d = (measured_.position(frame, a) - measured_.position(frame, b)).norm();
      ++count;
      const double change = d - mean;
      mean += change / count;
      square += change * (d - mean);
    }
    return count < kFewestCommonFrames ? kNaN : std::sqrt(square / count);
  }

  // Other markers of the segment, best first.
  const std::vector<int>& helpers(int marker) {
    if (helpers_.empty()) helpers_.resize(measured_.names.size());
    auto& known = helpers_[static_cast<std::size_t>(marker)];
    if (known) return *known;
    std::vector<std::pair<double, int>> found;
    for (int other = 0; other < measured_.marker_count(); ++other) {
      if (other == marker || !same_segment(marker, other)) continue;
      const double deviation = distance_deviation(marker, other);
      const bool said = !options_.segments.empty();
      if (!said && !(deviation < kRigidDistance)) continue;
      found.emplace_back(std::isnan(deviation) ? 1.0 : deviation, other);
    }
    std::sort(found.begin(), found.end());
    if (found.size() > kMostHelpers) found.resize(kMostHelpers);
    known.emplace();
    for (const auto& [deviation, other] : found) known->push_back(other);
    return *known;
  }

  bool same_segment(int a, int b) const {
    if (options_.segments.empty()) return true;
    for (const std::vector<int>& segment : options_.segments) {
      const auto holds = [&](int m) {
        return std::find(segment.begin(), segment.end(), m) != segment.end();
      };
      if (holds(a) && holds(b)) return true;
    }
    return false;
  }

  // Where the marker is in `frame` if it moved with its segment since `reference`.
  std::optional<std::pair<Vector3d, double>> carry(const MarkerGap& gap, int reference, int frame,
                                                   std::vector<int>& used) {
    std::vector<Vector3d> from, to;
    std::vector<int> with;
    for (const int helper : helpers(gap.marker)) {
      if (!is_measured(reference, helper) || !is_measured(frame, helper)) continue;
      from.push_back(measured_.position(reference, helper));
      to.push_back(measured_.position(frame, helper));
      with.push_back(helper);
    }
    if (with.size() < 3) return std::nullopt;
    const std::optional<Motion> motion = fit_motion(from, to);
    if (!motion) return std::nullopt;
    for (const int helper : with) {
      if (std::find(used.begin(), used.end(), helper) == used.end()) used.push_back(helper);
    }
    return std::pair{Vector3d(motion->R * measured_.position(reference, gap.marker) + motion->t),
                     motion->misfit};
  }

  std::optional<FilledGap> fill_rigidly(const MarkerGap& gap) {
    const int before = gap.first - 1, behind = gap.first + gap.count;
    const bool has_before = is_measured(before, gap.marker);
    const bool has_behind = is_measured(behind, gap.marker);
    FilledGap filled{gap, FilledGap::Method::kRigid, 0.0, {}};
    std::vector<Vector3d> positions;
    for (int i = 0; i < gap.count; ++i) {
      std::optional<std::pair<Vector3d, double>> a, b;
      if (has_before) a = carry(gap, before, gap.first + i, filled.from);
      if (has_behind) b = carry(gap, behind, gap.first + i, filled.from);
      // One end alone would not join the other.
      if ((has_before && !a) || (has_behind && !b) || (!a && !b)) return std::nullopt;
      const double w = !a ? 1.0 : !b ? 0.0 : (i + 1.0) / (gap.count + 1.0);
      Vector3d p = Vector3d::Zero();
      double misfit = 0.0;
      if (a) {
        p += (1.0 - w) * a->first;
        misfit = a->second;
      }
      if (b) {
        p += w * b->first;
        misfit = std::max(misfit, b->second);
      }
      if (misfit > options_.max_misfit) return std::nullopt;
      filled.error += misfit * misfit / gap.count;
      positions.push_back(p);
    }
    filled.error = std::sqrt(filled.error);
    std::sort(filled.from.begin(), filled.from.end());
    for (int i = 0; i < gap.count; ++i) {
      markers_.p_WM.row(gap.first + i).segment<3>(3 * gap.marker) =
          positions[static_cast<std::size_t>(i)].transpose();
    }
    return filled;
  }

  MarkerTrajectories& markers_;
  const MarkerTrajectories measured_;
  const GapFillOptions& options_;
  std::vector<std::optional<std::vector<int>>> helpers_;
};

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
  return Filler(markers, options).fill();
}

std::string filled_gaps_csv(const MarkerTrajectories& markers, const GapFillResult& result) {
  const auto name = [&](int i) { return markers.names[static_cast<std::size_t>(i)]; };
  std::string out = "marker,first_frame,last_frame,from_s,to_s,frames,method,error_m,taken_from\n";
  for (const FilledGap& f : result.filled) {
    const int last = f.gap.first + f.gap.count - 1;
    std::vector<std::string> helpers;
    for (const int i : f.from) helpers.push_back(name(i));
    out += fmt::format("{},{},{},{},{},{},{},{},{}\n", csv_cell(name(f.gap.marker)),
                       markers.frame_numbers[static_cast<std::size_t>(f.gap.first)],
                       markers.frame_numbers[static_cast<std::size_t>(last)],
                       text::format_number(markers.time[f.gap.first]),
                       text::format_number(markers.time[last]), f.gap.count,
                       f.method == FilledGap::Method::kRigid ? "rigid" : "spline",
                       std::isnan(f.error) ? "" : fmt::format("{:.3g}", f.error),
                       csv_cell(fmt::format("{}", fmt::join(helpers, " "))));
  }
  return out;
}

}  // namespace sinew
