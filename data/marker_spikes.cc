#include "data/marker_spikes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>
#include <utility>

#include "data/numbers.h"
#include "data/statistics.h"

namespace sinew {
namespace {

using Eigen::Vector3d;

// The bridge over a spike must close to this part of the spike's size.
constexpr double kClosing = 0.25;
// Samples at an end of what is measured that may be a spike, and how much farther off they are:
// only one side contradicts them.
constexpr int kLongestEnd = 3;
constexpr double kEndTimes = 4.0;

// Markers of a person are nearer to their middle than this, by far [m].
constexpr double kGiant = 5.0;

// The middle of all markers of each frame, coordinate by coordinate; NaN where fewer than four
// tell.
Eigen::MatrixX3d middles(const MarkerTrajectories& markers) {
  Eigen::MatrixX3d result(markers.frame_count(), 3);
  std::vector<double> values;
  for (int f = 0; f < markers.frame_count(); ++f) {
    for (int k = 0; k < 3; ++k) {
      values.clear();
      for (int i = 0; i < markers.marker_count(); ++i) {
        const double value = markers.p_WM(f, 3 * i + k);
        if (!std::isnan(value)) values.push_back(value);
      }
      result(f, k) = values.size() < 4 ? kNaN : median(values);
    }
  }
  return result;
}

// The middle of all distances from the middle.
double spread(const MarkerTrajectories& markers, const Eigen::MatrixX3d& middle) {
  std::vector<double> distances;
  const int step = std::max(1, markers.frame_count() / 200);
  for (int f = 0; f < markers.frame_count(); f += step) {
    for (int i = 0; i < markers.marker_count(); ++i) {
      const double d = (markers.position(f, i) - middle.row(f).transpose()).norm();
      if (!std::isnan(d)) distances.push_back(d);
    }
  }
  return median(std::move(distances));
}

// Looks at one marker. Samples are counted in the order in which they are measured.
class MarkerScan {
 public:
  MarkerScan(const MarkerTrajectories& markers, const Eigen::MatrixX3d& middle, int marker,
             const MarkerSpikeOptions& options)
      : markers_(markers), middle_(middle), marker_(marker), options_(options) {
    for (int f = 0; f < markers.frame_count(); ++f) {
      if (!std::isnan(markers.p_WM(f, 3 * marker))) frames_.push_back(f);
    }
    out_.assign(frames_.size(), false);
  }

  std::vector<MarkerSpike> scan() {
    if (frames_.size() < 4) return {};
    find_far_stretches();
    for (int i = 0; i < count(); ++i) {
      if (out_[at(i)]) continue;
      if (const int n = spike_at(i); n > 0) mark(i, n);
    }
    find_fast();
    return collect();
  }

 private:
  static std::size_t at(int i) { return static_cast<std::size_t>(i); }
  int count() const { return static_cast<int>(frames_.size()); }
  int frame(int i) const { return frames_[at(i)]; }
  Vector3d p(int i) const { return markers_.position(frame(i), marker_); }
  // Whether samples i … k lie in frames without a gap, and none of them is out.
  bool whole(int i, int k) const {
    if (i < 0 || k >= count() || frame(k) - frame(i) != k - i) return false;
    return std::none_of(out_.begin() + i, out_.begin() + k + 1, [](bool out) { return out; });
  }
  bool gap_before(int i) const { return i == 0 || frame(i) - frame(i - 1) > 1 || out_[at(i - 1)]; }

  void mark(int first, int n) {
    for (int i = first; i < first + n; ++i) out_[at(i)] = true;
  }

  // How far a sample is from the straight line through the two before it.
  double turn(int i) const { return (p(i) - 2.0 * p(i - 1) + p(i - 2)).norm(); }

  // The largest turn beside samples first … last, none of which it sees.
  double usual(int first, int last) const {
    const int reach = std::max(4, static_cast<int>(std::lround(options_.around * markers_.rate)));
    double most = 0.0;
    for (int i = std::max(2, first - reach); i < first; ++i) {
      if (whole(i - 2, i)) most = std::max(most, turn(i));
    }
    for (int i = last + 3; i <= std::min(count() - 1, last + reach); ++i) {
      if (whole(i - 2, i)) most = std::max(most, turn(i));
    }
    return most;
  }

  double least(int first, int last) const {
    return std::max(options_.least, options_.times_usual * usual(first, last));
  }

  // Samples from i on that are a spike; 0 if none are.
  int spike_at(int i) const {
    if (gap_before(i)) return spike_at_beginning(i);
    const bool two_before = whole(i - 2, i);
    const Vector3d v = two_before ? Vector3d(p(i - 1) - p(i - 2)) : Vector3d::Zero();
    if ((p(i) - p(i - 1) - v).norm() < options_.least) return 0;
    const int most = std::max(1, static_cast<int>(std::lround(options_.longest * markers_.rate)));
    for (int n = 1; n <= most && whole(i - 1, i + n - 1); ++n) {
      const bool ends = i + n >= count() || !whole(i, i + n);
      if (ends) return two_before && n <= kLongestEnd && leaves_for_good(i, n) ? n : 0;
      if (comes_back(i, n)) return n;
    }
    return 0;
  }

  // Whether samples i … i + n − 1 are off the bridge (cubic, of Hermite) from i − 1 to i + n, and
  // the bridge closes. Where one end has a single sample, it goes as fast as the other.
  bool comes_back(int i, int n) const {
    const bool two_before = whole(i - 2, i - 1), two_behind = whole(i + n, i + n + 1);
    if (!two_before && !two_behind) return false;
    const Vector3d a = p(i - 1), b = p(i + n);
    const Vector3d va = two_before ? Vector3d(a - p(i - 2)) : Vector3d(p(i + n + 1) - b);
    const Vector3d vb = two_behind ? Vector3d(p(i + n + 1) - b) : va;
    const double h = n + 1.0;
    double nearest = std::numeric_limits<double>::infinity();
    for (int k = 0; k < n; ++k) {
      const double s = (k + 1.0) / h, r = 1.0 - s;
      const Vector3d bridge =
          r * r * (1.0 + 2.0 * s) * a + s * s * (1.0 + 2.0 * r) * b + h * s * r * (r * va - s * vb);
      nearest = std::min(nearest, (p(i + k) - bridge).norm());
    }
    const double times = two_before && two_behind ? 1.0 : kEndTimes;
    if (nearest < times * options_.least) return false;
    const double closing = (b - a - 0.5 * h * (va + vb)).norm();
    return closing <= kClosing * nearest && nearest >= times * least(i, i + n - 1);
  }

  bool leaves_for_good(int i, int n) const {
    const Vector3d v = p(i - 1) - p(i - 2);
    for (int k = 0; k < n; ++k) {
      if ((p(i + k) - p(i - 1) - (k + 1.0) * v).norm() < kEndTimes * least(i, i + n - 1)) {
        return false;
      }
    }
    return true;
  }

  // The first samples behind a gap, seen backwards.
  int spike_at_beginning(int i) const {
    for (int n = 1; n <= kLongestEnd; ++n) {
      if (!whole(i, i + n + 1)) return 0;
      const Vector3d b = p(i + n), v = p(i + n + 1) - b;
      bool off = true;
      for (int k = 0; k < n; ++k) {
        off = off && (p(i + k) - b + (n - k) * v).norm() >= kEndTimes * least(i, i + n - 1);
      }
      if (off) return n;
    }
    return 0;
  }

  // Stretches away from everybody that begin and end with a jump, a gap or the record.
  void find_far_stretches() {
    const auto far = [&](int i) {
      return (p(i) - middle_.row(frame(i)).transpose()).norm() > options_.away;
    };
    int all = 0;
    for (int i = 0; i < count(); ++i) all += far(i);
    if (all == 0) return;
    if (2 * all > count()) return find_absurd();
    for (int i = 0; i < count(); ++i) {
      if (!far(i)) continue;
      int last = i;
      while (last + 1 < count() && far(last + 1)) ++last;
      if (jumps(i - 1, i) && jumps(last, last + 1)) mark(i, last - i + 1);
      i = last;
    }
  }

  void find_absurd() {
    for (int i = 0; i < count(); ++i) {
      if ((p(i) - middle_.row(frame(i)).transpose()).norm() > options_.absurd) mark(i, 1);
    }
  }

  // Whether the marker cannot have gone from one sample to the next.
  bool jumps(int i, int k) const {
    if (i < 0 || k >= count()) return true;
    const double steps = frame(k) - frame(i);
    return (p(k) - p(i)).norm() > std::max(1.0, options_.fastest * steps / markers_.rate);
  }

  // Single samples that are too fast to come to and to leave.
  void find_fast() {
    const auto speed = [&](int i, int k) {
      return (p(k) - p(i)).norm() * markers_.rate / (frame(k) - frame(i));
    };
    int before = -1;
    for (int i = 0; i < count(); ++i) {
      if (out_[at(i)]) continue;
      int behind = i + 1;
      while (behind < count() && out_[at(behind)]) ++behind;
      const bool fast = before >= 0 && behind < count() && speed(before, i) > options_.fastest &&
                        speed(i, behind) > options_.fastest &&
                        speed(before, behind) < options_.fastest;
      if (fast) {
        mark(i, 1);
      } else {
        before = i;
      }
    }
  }

  // Runs of samples that are out, with their distance from the straight line over them.
  std::vector<MarkerSpike> collect() const {
    std::vector<MarkerSpike> spikes;
    for (int i = 0; i < count(); ++i) {
      if (!out_[at(i)]) continue;
      int last = i;
      while (last + 1 < count() && out_[at(last + 1)] && frame(last + 1) == frame(last) + 1) ++last;
      MarkerSpike spike{marker_, frame(i), frame(last), 0.0};
      for (int k = i; k <= last; ++k) {
        spike.distance = std::max(spike.distance, distance(i, last, k));
      }
      spikes.push_back(spike);
      i = last;
    }
    return spikes;
  }

  double distance(int first, int last, int k) const {
    const int a = first - 1, b = last + 1;
    const bool has_a = a >= 0 && !out_[at(a)], has_b = b < count() && !out_[at(b)];
    if (!has_a && !has_b) return (p(k) - middle_.row(frame(k)).transpose()).norm();
    if (!has_a) return (p(k) - p(b)).norm();
    if (!has_b) return (p(k) - p(a)).norm();
    const double s = double(frame(k) - frame(a)) / (frame(b) - frame(a));
    return (p(k) - (1.0 - s) * p(a) - s * p(b)).norm();
  }

  const MarkerTrajectories& markers_;
  const Eigen::MatrixX3d& middle_;
  const int marker_;
  const MarkerSpikeOptions& options_;
  std::vector<int> frames_;
  std::vector<bool> out_;
};

}  // namespace

void MarkerSpikeOptions::validate() const {
  for (const auto& [name, value] :
       {std::pair{"least", least}, std::pair{"times_usual", times_usual},
        std::pair{"around", around}, std::pair{"longest", longest}, std::pair{"away", away},
        std::pair{"absurd", absurd}, std::pair{"fastest", fastest}}) {
    if (value > 0.0 && std::isfinite(value)) continue;
    throw std::invalid_argument(
        fmt::format("MarkerSpikeOptions::{} is {}; it must be above 0", name, value));
  }
}

std::vector<MarkerSpike> find_marker_spikes(const MarkerTrajectories& markers,
                                            const MarkerSpikeOptions& options) {
  options.validate();
  const Eigen::MatrixX3d middle = middles(markers);
  std::vector<MarkerSpike> spikes;
  if (spread(markers, middle) > kGiant) return spikes;
  for (int i = 0; i < markers.marker_count(); ++i) {
    const std::vector<MarkerSpike> found = MarkerScan(markers, middle, i, options).scan();
    spikes.insert(spikes.end(), found.begin(), found.end());
  }
  return spikes;
}

void leave_out(MarkerTrajectories& markers, const std::vector<MarkerSpike>& spikes) {
  for (const MarkerSpike& spike : spikes) {
    markers.p_WM.block(spike.first, 3 * spike.marker, spike.last - spike.first + 1, 3)
        .setConstant(kNaN);
  }
}

}  // namespace sinew
