#include "data/sample_spikes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <stdexcept>
#include <utility>

namespace sinew {
namespace {

using Eigen::Index;

// Beside a spike the channel is looked at over this many samples: ten milliseconds at 1000 Hz.
constexpr Index kAround = 10;
// What is left of a spike's step from the sample before it to the one behind it.
constexpr double kClosing = 0.25;
// A channel that says nothing for this part of its samples is broken: nothing mends it.
constexpr double kMostWild = 0.1;

// What spans fewer of the converter's steps is at rest, and steps by noise.
constexpr double kFewestSteps = 32.0;

// The smallest distance of two values that differ; infinite if none do.
double smallest_step(const Eigen::VectorXd& samples) {
  std::vector<double> sorted;
  std::copy_if(samples.begin(), samples.end(), std::back_inserter(sorted),
               [](double x) { return std::isfinite(x); });
  std::sort(sorted.begin(), sorted.end());
  double step = std::numeric_limits<double>::infinity();
  for (std::size_t i = 1; i < sorted.size(); ++i) {
    if (sorted[i] > sorted[i - 1]) step = std::min(step, sorted[i] - sorted[i - 1]);
  }
  return step;
}

// Its usual range: the hundredth and the ninety-ninth of a hundred finite values.
struct Range {
  double low = 0.0, high = 0.0;
  double size() const { return high - low; }
};

Range usual_range(const Eigen::VectorXd& samples) {
  std::vector<double> sorted;
  for (const double x : samples) {
    if (std::isfinite(x)) sorted.push_back(x);
  }
  if (sorted.empty()) return {};
  std::sort(sorted.begin(), sorted.end());
  const auto skip = sorted.size() / 100;
  return {sorted[skip], sorted[sorted.size() - 1 - skip]};
}

class SampleScan {
 public:
  SampleScan(const Eigen::VectorXd& samples, double rate, const SampleSpikeOptions& options)
      : samples_(samples), rate_(rate), options_(options), range_(usual_range(samples)) {
    out_.assign(static_cast<std::size_t>(samples.size()), false);
  }

  std::vector<SampleSpike> scan(bool wild_only) {
    find_wild();
    const bool rests = !(range_.size() >= kFewestSteps * smallest_step(samples_));
    for (Index i = 1; !wild_only && !rests && i + 1 < samples_.size(); ++i) {
      for (Index n = 1; n <= options_.longest && i + n < samples_.size(); ++n) {
        if (!is_spike(i, i + n - 1)) continue;
        std::fill_n(out_.begin() + i, n, true);
        i += n - 1;
        break;
      }
    }
    return collect();
  }

 private:
  bool out(Index i) const { return out_[static_cast<std::size_t>(i)]; }

  void find_wild() {
    // A channel that is at rest has no range; its values are then what tells.
    const double size = std::max({range_.size(), std::abs(range_.low), std::abs(range_.high)});
    Index wild = 0;
    for (Index i = 0; i < samples_.size(); ++i) {
      const double x = samples_[i];
      const double beyond = std::max(range_.low - x, x - range_.high);
      const bool is =
          !std::isfinite(x) || (beyond > options_.wild * size && beyond > options_.wild);
      out_[static_cast<std::size_t>(i)] = is;
      wild += is;
    }
    if (static_cast<double>(wild) > kMostWild * static_cast<double>(samples_.size())) {
      std::fill(out_.begin(), out_.end(), false);
    }
  }

  // The largest change of slope beside first … last.
  double usual(Index first, Index last) const {
    double most = 0.0;
    const auto look = [&](Index i) {
      if (i < 1 || i + 1 >= samples_.size() || out(i - 1) || out(i) || out(i + 1)) return;
      most = std::max(most, std::abs(samples_[i + 1] - 2.0 * samples_[i] + samples_[i - 1]));
    };
    for (Index i = first - kAround; i + 1 < first; ++i) look(i);
    for (Index i = last + 2; i <= last + kAround; ++i) look(i);
    return most;
  }

  bool is_spike(Index first, Index last) const {
    const double a = samples_[first - 1], b = samples_[last + 1];
    for (Index i = first - 1; i <= last + 1; ++i) {
      if (out(i)) return false;
    }
    double nearest = std::numeric_limits<double>::infinity(), beyond = nearest;
    for (Index i = first; i <= last; ++i) {
      const double s = static_cast<double>(i - first + 1) / static_cast<double>(last - first + 2);
      nearest = std::min(nearest, std::abs(samples_[i] - (1.0 - s) * a - s * b));
      beyond = std::min(beyond, std::max(range_.low - samples_[i], samples_[i] - range_.high));
    }
    if (nearest < options_.part_of_range * range_.size()) return false;
    if (rate_ < options_.least_rate && beyond < options_.times_range * range_.size()) return false;
    return std::abs(b - a) <= kClosing * nearest &&
           nearest >= options_.times_usual * usual(first, last);
  }

  std::vector<SampleSpike> collect() const {
    std::vector<SampleSpike> spikes;
    const double middle = 0.5 * (range_.low + range_.high);
    for (Index i = 0; i < samples_.size(); ++i) {
      if (!out(i)) continue;
      SampleSpike spike{i, i, samples_[i]};
      while (spike.last + 1 < samples_.size() && out(spike.last + 1)) {
        ++spike.last;
        const double x = samples_[spike.last];
        if (!(std::abs(x - middle) <= std::abs(spike.value - middle))) spike.value = x;
      }
      spikes.push_back(spike);
      i = spike.last;
    }
    return spikes;
  }

  const Eigen::VectorXd& samples_;
  const double rate_;
  const SampleSpikeOptions& options_;
  const Range range_;
  std::vector<bool> out_;
};

}  // namespace

void SampleSpikeOptions::validate() const {
  for (const auto& [name, value] :
       {std::pair{"longest", static_cast<double>(longest)},
        std::pair{"part_of_range", part_of_range}, std::pair{"times_usual", times_usual},
        std::pair{"least_rate", least_rate}, std::pair{"times_range", times_range},
        std::pair{"wild", wild}}) {
    if (value > 0.0 && std::isfinite(value)) continue;
    throw std::invalid_argument(
        fmt::format("SampleSpikeOptions::{} is {}; it must be above 0", name, value));
  }
}

std::vector<SampleSpike> find_sample_spikes(const Eigen::VectorXd& samples, double rate,
                                            bool wild_only, const SampleSpikeOptions& options) {
  options.validate();
  return SampleScan(samples, rate, options).scan(wild_only);
}

void bridge_samples(Eigen::Ref<Eigen::VectorXd, 0, Eigen::InnerStride<>> samples, Index first,
                    Index last) {
  Index a = first - 1, b = last + 1;
  while (a >= 0 && !std::isfinite(samples[a])) --a;
  while (b < samples.size() && !std::isfinite(samples[b])) ++b;
  const bool has_a = a >= 0, has_b = b < samples.size();
  if (!has_a && !has_b) return;
  const double from = samples[has_a ? a : b], to = samples[has_b ? b : a];
  for (Index i = first; i <= last; ++i) {
    const double s = has_a && has_b ? static_cast<double>(i - a) / static_cast<double>(b - a) : 0.0;
    samples[i] = (1.0 - s) * from + s * to;
  }
}

}  // namespace sinew
