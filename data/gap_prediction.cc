#include "data/gap_prediction.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <utility>

#include "data/natural_spline.h"
#include "data/numbers.h"
#include "data/rigid_fit.h"

namespace sinew {
namespace {

using Eigen::Vector3d;

// Beyond ten frames a cubic spline forgets its data: each decays by 0.27.
constexpr int kSplineFrames = 10;
constexpr int kFewestNeighbours = 2;
// At an end: an acceleration is known from six frames, and carries on over two at 100 Hz [s].
constexpr int kParabolaFrames = 6;
constexpr double kLongestEnd = 0.02;
// A fourth marker averages, an eighth adds nothing.
constexpr std::size_t kMostHelpers = 7;
// Skin moves markers of one segment by less than this, joints move others by more [m].
constexpr double kRigidDistance = 0.007;
constexpr int kFewestCommonFrames = 20;
// Of fewer samples nobody can tell whether they are this marker at all.
constexpr int kFewestMeasured = 10;
// Markers within a centimetre of one line tell no turn about it [m].
constexpr double kLeastWidth = 0.01;
// Of gaps cut to learn from on each side: an RMS of eight is known to a quarter.
constexpr int kCutsASide = 4;
// A step takes a second: skin has moved all that it will [s].
constexpr double kLongestCut = 1.0;
// A foot is on the ground or off it for longer [s].
constexpr double kShortestCut = 0.25;
// Frames looked at in a rigid cut.
constexpr int kFramesACut = 10;

// Reference poses and the marker's places in them.
struct Carried {
  Vector3d p;
  double misfit;
};

std::optional<Carried> carry(const MarkerTrajectories& measured, int marker,
                             const std::vector<int>& helpers, int reference, int frame,
                             std::vector<int>& used) {
  const auto most = static_cast<Eigen::Index>(helpers.size());
  Eigen::Matrix3Xd from(3, most), to(3, most);
  std::vector<int> with;
  for (const int helper : helpers) {
    const Vector3d a = measured.position(reference, helper), b = measured.position(frame, helper);
    if (!a.allFinite() || !b.allFinite()) continue;
    const auto n = static_cast<Eigen::Index>(with.size());
    from.col(n) = a;
    to.col(n) = b;
    with.push_back(helper);
  }
  if (with.size() < 3) return std::nullopt;
  const auto n = static_cast<Eigen::Index>(with.size());
  const RigidFit fit = fit_rigidly(from.leftCols(n), to.leftCols(n), Eigen::VectorXd::Ones(n));
  if (!(fit.width > kLeastWidth)) return std::nullopt;
  for (const int helper : with) {
    if (std::find(used.begin(), used.end(), helper) == used.end()) used.push_back(helper);
  }
  return Carried{fit.R * measured.position(reference, marker) + fit.t, fit.misfit};
}

}  // namespace

GapPredictor::GapPredictor(const MarkerTrajectories& measured, const GapFillOptions& options)
    : measured_(measured), options_(options), helpers_(measured.names.size()) {}

bool GapPredictor::is_measured(int frame, int marker) const {
  return frame >= 0 && frame < measured_.frame_count() &&
         !std::isnan(measured_.p_WM(frame, 3 * marker));
}

// Measured frames next to the gap, on the sides that are asked for.
std::vector<int> GapPredictor::neighbours(const MarkerGap& gap, Sides sides) const {
  std::vector<int> frames;
  const int end = gap.first + gap.count,
            most = sides.before && sides.behind ? kSplineFrames : kParabolaFrames;
  for (int f = gap.first - 1; sides.before && is_measured(f, gap.marker) && gap.first - f <= most;
       --f) {
    frames.push_back(f);
  }
  std::reverse(frames.begin(), frames.end());
  for (int f = end; sides.behind && is_measured(f, gap.marker) && f - end < most; ++f) {
    frames.push_back(f);
  }
  return frames;
}

std::optional<GapPrediction> GapPredictor::by_spline(const MarkerGap& gap) const {
  return spline(gap, sides_of(gap));
}

std::optional<GapPrediction> GapPredictor::spline(const MarkerGap& gap, Sides sides) const {
  const std::vector<int> frames = neighbours(gap, sides);
  if (sides.before != sides.behind) return parabola(gap, frames);
  const auto before =
      std::count_if(frames.begin(), frames.end(), [&](int f) { return f < gap.first; });
  const auto behind = static_cast<std::ptrdiff_t>(frames.size()) - before;
  if (before < kFewestNeighbours || behind < kFewestNeighbours) return std::nullopt;
  Eigen::VectorXd x(static_cast<Eigen::Index>(frames.size()));
  Eigen::MatrixXd y(x.size(), 3);
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    const int frame = frames[static_cast<std::size_t>(i)];
    x[i] = frame - gap.first;
    y.row(i) = measured_.position(frame, gap.marker).transpose();
  }
  const Eigen::MatrixXd c = natural_spline_coefficients(x, y, 2);
  const Eigen::Index interval = before - 1;
  GapPrediction prediction;
  prediction.p_WM.resize(gap.count, 3);
  for (int i = 0; i < gap.count; ++i) {
    const double dx = i - x[interval];
    prediction.p_WM.row(i) =
        c.row(4 * interval) + dx * (c.row(4 * interval + 1) +
                                    dx * (c.row(4 * interval + 2) + dx * c.row(4 * interval + 3)));
  }
  return prediction;
}

std::optional<GapPrediction> GapPredictor::parabola(const MarkerGap& gap,
                                                    const std::vector<int>& frames) const {
  const bool is_short = gap.count <= std::max(1.0, kLongestEnd * measured_.rate * (1.0 + 1e-9));
  if (!is_short || static_cast<int>(frames.size()) < kParabolaFrames) return std::nullopt;
  const auto powers = [&](int frame) {
    const double x = frame - gap.first;
    return Eigen::RowVector3d(1.0, x, x * x);
  };
  Eigen::Matrix<double, kParabolaFrames, 3> A, y;
  for (int i = 0; i < kParabolaFrames; ++i) {
    const int frame = frames[static_cast<std::size_t>(i)];
    A.row(i) = powers(frame);
    y.row(i) = measured_.position(frame, gap.marker).transpose();
  }
  const Eigen::Matrix3d c = A.colPivHouseholderQr().solve(y);
  GapPrediction prediction;
  prediction.p_WM.resize(gap.count, 3);
  for (int i = 0; i < gap.count; ++i) prediction.p_WM.row(i) = powers(gap.first + i) * c;
  return prediction;
}

// The standard deviation of the distance between two markers; NaN where they are seldom together.
double GapPredictor::distance_deviation(int a, int b) const {
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

bool GapPredictor::same_segment(int a, int b) const {
  if (options_.segments.empty()) return true;
  for (const std::vector<int>& segment : options_.segments) {
    const auto holds = [&](int m) {
      return std::find(segment.begin(), segment.end(), m) != segment.end();
    };
    if (holds(a) && holds(b)) return true;
  }
  return false;
}

const std::vector<int>& GapPredictor::helpers(int marker) {
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

// Every `step`th frame of the gap from the first on, from the sides that are asked for; rows in
// between stay empty.
std::optional<GapPrediction> GapPredictor::carried(const MarkerGap& gap, Sides sides,
                                                   const std::vector<int>& helpers,
                                                   int step) const {
  const int before = gap.first - 1, behind = gap.first + gap.count;
  GapPrediction prediction;
  prediction.p_WM = Eigen::MatrixX3d::Constant(gap.count, 3, kNaN);
  double squares = 0.0;
  int frames = 0;
  for (int i = 0; i < gap.count; i += step, ++frames) {
    std::optional<Carried> a, b;
    const auto to = [&](int reference) {
      return carry(measured_, gap.marker, helpers, reference, gap.first + i, prediction.from);
    };
    if (sides.before) a = to(before);
    if (sides.behind) b = to(behind);
    // One end alone would not join the other.
    if ((sides.before && !a) || (sides.behind && !b) || (!a && !b)) return std::nullopt;
    const double w = !a ? 1.0 : !b ? 0.0 : (i + 1.0) / (gap.count + 1.0);
    Vector3d p = Vector3d::Zero();
    if (a) p += (1.0 - w) * a->p;
    if (b) p += w * b->p;
    const double misfit = std::max(a ? a->misfit : 0.0, b ? b->misfit : 0.0);
    if (misfit > options_.max_misfit) return std::nullopt;
    squares += misfit * misfit;
    prediction.p_WM.row(i) = p.transpose();
  }
  prediction.misfit = std::sqrt(squares / frames);
  std::sort(prediction.from.begin(), prediction.from.end());
  return prediction;
}

std::optional<GapPrediction> GapPredictor::rigidly(const MarkerGap& gap) {
  if (measured_count(gap.marker) < kFewestMeasured) return std::nullopt;
  return carried(gap, sides_of(gap), helpers(gap.marker));
}

int GapPredictor::measured_count(int marker) const {
  return static_cast<int>(measured_.p_WM.col(3 * marker).array().isFinite().count());
}

GapPredictor::Sides GapPredictor::sides_of(const MarkerGap& gap) const {
  return {is_measured(gap.first - 1, gap.marker), is_measured(gap.first + gap.count, gap.marker)};
}

// Stretches of `count` frames in which the marker was measured, and as far around them as around
// the gap, nearest first on each side.
std::vector<MarkerGap> GapPredictor::measured_alike(const MarkerGap& gap, int count) const {
  const Sides sides = sides_of(gap);
  const int margin = sides.before && sides.behind ? kFewestNeighbours : kParabolaFrames;
  const int margin_before = sides.before ? margin : 0, margin_behind = sides.behind ? margin : 0;
  const int whole = margin_before + count + margin_behind;
  std::vector<MarkerGap> cuts;
  // Cuts of single frames lie a few apart, or they would all meet the same noise.
  const int apart = std::max(count, 3);
  for (const int way : {-1, 1}) {
    int run = 0, found = 0, next = way < 0 ? gap.first - 1 : gap.first + gap.count;
    for (int f = next; f >= 0 && f < measured_.frame_count() && found < kCutsASide; f += way) {
      run = is_measured(f, gap.marker) ? run + 1 : 0;
      if (run < whole) continue;
      const int first = (way < 0 ? f : f - whole + 1) + margin_before;
      cuts.push_back({gap.marker, first, count});
      ++found;
      run = std::max(0, whole - apart);
    }
  }
  return cuts;
}

double GapPredictor::spline_error(const MarkerGap& gap) const {
  double squares = 0.0;
  int frames = 0;
  for (const MarkerGap& cut : measured_alike(gap, gap.count)) {
    const auto prediction = spline(cut, sides_of(gap));
    if (!prediction) continue;
    const auto truth = measured_.p_WM.block(cut.first, 3 * cut.marker, cut.count, 3);
    squares += (prediction->p_WM - truth).squaredNorm();
    frames += cut.count;
  }
  return frames > 0 ? std::sqrt(squares / frames) : kNaN;
}

double GapPredictor::rigid_error(const MarkerGap& gap, const std::vector<int>& helpers) const {
  const auto frames_in = [&](double seconds) {
    return std::max(1, static_cast<int>(std::lround(seconds * measured_.rate)));
  };
  const int most = std::min(gap.count, frames_in(kLongestCut));
  // Where the marker is nowhere measured for so long, shorter cuts say more than nothing.
  const int fewest = std::min(most, frames_in(kShortestCut));
  for (int count = most;; count = std::max(fewest, count / 2)) {
    const double error = rigid_error_of_cuts(gap, helpers, count);
    if (!std::isnan(error) || count == fewest) return error;
  }
}

double GapPredictor::rigid_error_of_cuts(const MarkerGap& gap, const std::vector<int>& helpers,
                                         int count) const {
  const int step = std::max(1, count / kFramesACut);
  double squares = 0.0;
  int frames = 0;
  for (const MarkerGap& cut : measured_alike(gap, count)) {
    const auto prediction = carried(cut, sides_of(gap), helpers, step);
    if (!prediction) continue;
    for (int i = 0; i < count; i += step, ++frames) {
      squares +=
          (prediction->p_WM.row(i).transpose() - measured_.position(cut.first + i, cut.marker))
              .squaredNorm();
    }
  }
  return frames > 0 ? std::sqrt(squares / frames) : kNaN;
}

}  // namespace sinew
