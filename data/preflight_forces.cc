#include "data/preflight_forces.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "data/c3d_frame_decoder.h"
#include "data/statistics.h"
#include "data/text.h"

namespace sinew {
namespace {

using Eigen::Index;
using Eigen::Vector3d;
using Severity = Finding::Severity;

// Of the range between a channel's ends: what stays this near to zero is at rest.
constexpr double kRest = 0.15;
// A value met in more than this part of all samples is how the channel rests.
constexpr double kRestShare = 0.5;

// The smallest distance of two values that differ: one unit of the converter, if it shows. Between
// neighbours in time it would be what a steep flank rises by in a sample.
double smallest_step(const Eigen::VectorXd& samples) {
  std::vector<double> sorted(samples.begin(), samples.end());
  std::sort(sorted.begin(), sorted.end());
  double step = std::numeric_limits<double>::infinity();
  for (std::size_t i = 1; i < sorted.size(); ++i) {
    if (sorted[i] > sorted[i - 1]) step = std::min(step, sorted[i] - sorted[i - 1]);
  }
  return std::isfinite(step) ? step : 0.0;
}

// How much less than `value` the channel is `away` samples beside a stretch; infinite at the ends
// of the record, where nothing contradicts.
double fall_at(const Eigen::VectorXd& samples, Index at, double value) {
  if (at < 0 || at >= samples.size()) return std::numeric_limits<double>::infinity();
  return std::abs(value - samples[at]);
}

std::optional<FlatTop> flat_top_at(const Eigen::VectorXd& samples, double value, double range,
                                   double step, bool at_limit, const ForceCheckOptions& options) {
  FlatTop top;
  top.value = value;
  Index equal = 0;
  // What 32 bits leave of a value.
  const double tolerance = 1e-7 * std::abs(value);
  for (Index i = 0; i < samples.size(); ++i) {
    if (std::abs(samples[i] - value) > tolerance) continue;
    Index last = i;
    while (last + 1 < samples.size() && std::abs(samples[last + 1] - value) <= tolerance) ++last;
    const Index count = last - i + 1;
    equal += count;
    const Index beside = std::clamp<Index>(count / 2, 2, 10);
    const double least = std::max(options.steps_beside * step, options.range_beside * range);
    const double fall =
        std::min(fall_at(samples, i - beside, value), fall_at(samples, last + beside, value));
    // A record that is flat from end to end has no flanks.
    if (count >= options.least_flat && fall >= least && count < samples.size()) {
      ++top.stretches;
      if (count > top.count) {
        top.first = i;
        top.count = count;
      }
    }
    i = last;
  }
  const bool rests = static_cast<double>(equal) > kRestShare * static_cast<double>(samples.size());
  if (top.stretches == 0 || (rests && !at_limit)) return std::nullopt;
  return top;
}

// Ends of the range of converters of 12 and 16 bits, in the channel's unit.
std::vector<double> limits_of(const c3d::ChannelScales& scales, std::size_t channel,
                              std::optional<double> bits) {
  std::vector<double> limits;
  const double offset = scales.offset[channel];
  for (const int width : {12, 16}) {
    if (bits && *bits != width) continue;
    const double half = std::pow(2.0, width - 1);
    for (const double count : {-half, half - 1.0}) limits.push_back(count);
    // Counted from 0, with an offset of half the range.
    if (std::abs(offset) < 0.25 * half) continue;
    for (const double count : {0.0, 2.0 * half - 1.0}) limits.push_back(count);
  }
  for (double& limit : limits) limit = (limit - offset) * scales.scale[channel];
  return limits;
}

bool is_limit(double value, const std::vector<double>& limits, double step) {
  return std::any_of(limits.begin(), limits.end(), [&](double limit) {
    return std::abs(value - limit) <= std::max(0.5 * step, 1e-6 * std::abs(limit));
  });
}

// The loaded time of a platform about a sample.
std::pair<double, double> contact_about(const ForcePlatformRecording& plate, Index sample) {
  const auto loaded = [&](Index i) { return !std::isnan(plate.center(i, 0)); };
  Index first = sample, last = sample;
  while (first > 0 && loaded(first - 1)) --first;
  while (last + 1 < plate.center.rows() && loaded(last + 1)) ++last;
  return {static_cast<double>(first) / plate.rate, static_cast<double>(last) / plate.rate};
}

// What is flat of one platform's channels.
struct SaturatedPlatform {
  std::vector<std::string> channels;
  FlatTop longest;
  std::size_t longest_channel = 0;
  bool at_limit = false;

  void add(const C3dFile& file, std::size_t channel, const FlatTop& top, bool limit) {
    const std::string& name = file.analog.labels[channel];
    if (channels.empty() || channels.back() != name) channels.push_back(name);
    at_limit = at_limit || limit;
    if (top.count <= longest.count) return;
    longest = top;
    longest_channel = channel;
  }

  Finding finding(const C3dFile& file, const ForcePlatformRecording& plate) const {
    Finding finding;
    finding.severity = at_limit ? Severity::kError : Severity::kWarning;
    finding.kind = "saturation";
    finding.where = fmt::format("platform {}, {}", plate.platform.number, list_names(channels, 8));
    finding.from = static_cast<double>(longest.first) / plate.rate;
    finding.to = static_cast<double>(longest.first + longest.count - 1) / plate.rate;
    finding.confidence = at_limit ? 0.98 : 0.8;
    finding.text = fmt::format("flat tops{}; the longest, of {} samples at {:.6g} {}, is in {}",
                               at_limit ? " at the end of the converter's range" : "",
                               longest.count, longest.value, file.analog.units[longest_channel],
                               file.analog.labels[longest_channel]);
    const auto [from, to] = contact_about(plate, longest.first + longest.count / 2);
    finding.flags = {
        "--assign",
        fmt::format("{}:none@{}-{}", plate.platform.number, time_text(from), time_text(to)),
        "--loads", "grf.xml"};
    finding.output = "grf.mot";
    finding.advice = "leaves this step's forces out; nothing brings them back";
    return finding;
  }
};

struct Block {
  Vector3d mean = Vector3d::Zero();
  double normal = 0.0, deviation = 0.0;  // of the force along the platform's normal
};

std::vector<Block> blocks_of(const ForcePlatformRecording& plate, Index length) {
  std::vector<Block> blocks;
  const Vector3d up = -plate.platform.R_WP.col(2);
  for (Index first = 0; first + length <= plate.force.rows(); first += length) {
    const auto rows = plate.force.middleRows(first, length);
    Block block;
    block.mean = rows.colwise().mean().transpose();
    const Eigen::VectorXd normal = rows * up;
    block.normal = normal.mean();
    block.deviation = std::sqrt((normal.array() - block.normal).square().mean());
    blocks.push_back(block);
  }
  return blocks;
}

}  // namespace

void ForceCheckOptions::validate() const {
  for (const auto& [name, value] :
       {std::pair{"least_flat", static_cast<double>(least_flat)},
        std::pair{"steps_beside", steps_beside}, std::pair{"range_beside", range_beside},
        std::pair{"offset", offset}, std::pair{"quiet_time", quiet_time}, std::pair{"quiet", quiet},
        std::pair{"least_rate", least_rate}}) {
    if (value > 0.0 && std::isfinite(value)) continue;
    throw std::invalid_argument(
        fmt::format("ForceCheckOptions::{} is {}; it must be above 0", name, value));
  }
}

std::vector<FlatTop> find_flat_tops(const Eigen::VectorXd& samples,
                                    const std::vector<double>& limits,
                                    const ForceCheckOptions& options) {
  options.validate();
  std::vector<FlatTop> tops;
  if (samples.size() < 2 * options.least_flat || !samples.allFinite()) return tops;
  const double highest = samples.maxCoeff(), lowest = samples.minCoeff(), range = highest - lowest;
  const double unit = smallest_step(samples);
  // What spans a few of the converter's units is at rest and no force that could be cut off.
  if (range < 32.0 * unit) return tops;
  // A loaded channel uses eight bits at the least; short records show but some of its values.
  const double step = std::min(unit, range / 256.0);
  for (const double value : {highest, lowest}) {
    if (std::abs(value) <= kRest * range) continue;
    const bool at_limit = is_limit(value, limits, step);
    if (auto top = flat_top_at(samples, value, range, step, at_limit, options)) {
      tops.push_back(*top);
    }
  }
  return tops;
}

std::vector<Finding> find_saturation(const C3dFile& file,
                                     const std::vector<ForcePlatformRecording>& plates,
                                     const ForceCheckOptions& options) {
  std::vector<Finding> findings;
  std::vector<Warning> ignored;
  const c3d::ChannelScales scales = c3d::find_scales(file.groups, file.layout, file.path, ignored);
  const std::optional<double> bits = find_number(file.groups, "ANALOG", "BITS");
  for (const ForcePlatformRecording& plate : plates) {
    if (!plate.platform.usable()) continue;
    SaturatedPlatform saturated;
    for (std::size_t i = 0; i < plate.platform.channels.size(); ++i) {
      // Type 1 stores places, which rest at the platform's edge or middle.
      if (plate.platform.type == 1 && (i == 3 || i == 4)) continue;
      const auto channel = static_cast<std::size_t>(plate.platform.channels[i]);
      if (channel >= scales.scale.size()) continue;
      const std::vector<double> limits = limits_of(scales, channel, bits);
      const Eigen::VectorXd samples = file.analog.values.col(plate.platform.channels[i]);
      for (const FlatTop& top : find_flat_tops(samples, limits, options)) {
        saturated.add(file, channel, top,
                      is_limit(top.value, limits, std::abs(scales.scale[channel])));
      }
    }
    if (saturated.longest.count > 0) findings.push_back(saturated.finding(file, plate));
  }
  return findings;
}

std::vector<UnloadedStretch> find_unloaded(const ForcePlatformRecording& plate,
                                           const ForceCheckOptions& options) {
  options.validate();
  std::vector<UnloadedStretch> stretches;
  // A fiftieth of a second: the mains' hum has one period in it, or more.
  const auto length = std::max<Index>(1, std::lround(0.02 * plate.rate));
  const std::vector<Block> blocks = blocks_of(plate, length);
  double peak = 0.0;
  for (const Block& block : blocks) peak = std::max(peak, std::abs(block.normal));
  // An eighth of the weight and of what a child weighs.
  const double least = std::max(0.125 * peak, 25.0);
  const auto rests = [&](const Block& b) {
    return std::abs(b.normal) <= least && b.deviation <= options.quiet;
  };
  const auto least_blocks =
      std::max<std::size_t>(2, static_cast<std::size_t>(std::ceil(options.quiet_time * plate.rate /
                                                                  static_cast<double>(length))));
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    if (!rests(blocks[i])) continue;
    std::size_t end = i;
    // While it steps from block to block by noise only.
    while (end < blocks.size() && rests(blocks[end]) &&
           (end == i || std::abs(blocks[end].normal - blocks[end - 1].normal) <= options.quiet)) {
      ++end;
    }
    // The first and last block may hold the beginning of a step.
    if (end - i >= least_blocks + 2) {
      UnloadedStretch stretch;
      stretch.first = static_cast<Index>(i + 1) * length;
      stretch.count = static_cast<Index>(end - i - 2) * length;
      stretch.force =
          plate.force.middleRows(stretch.first, stretch.count).colwise().mean().transpose();
      stretches.push_back(stretch);
    }
    i = std::max(i, end - 1);
  }
  return stretches;
}

std::vector<Finding> find_baseline_faults(const ForcePlatformRecording& plate, double threshold,
                                          const ForceCheckOptions& options) {
  std::vector<Finding> findings;
  if (!plate.platform.usable() || plate.sample_count() == 0) return findings;
  Finding finding;
  finding.kind = "baseline";
  finding.where = fmt::format("platform {}", plate.platform.number);
  const std::vector<UnloadedStretch> stretches = find_unloaded(plate, options);
  if (stretches.empty()) {
    finding.severity = Severity::kNote;
    finding.confidence = 0.8;
    finding.text = "it is never unloaded for long: an offset of its channels would not show";
    return {finding};
  }
  const auto times = [&](const UnloadedStretch& s) {
    return std::pair{static_cast<double>(s.first) / plate.rate,
                     static_cast<double>(s.first + s.count) / plate.rate};
  };
  const auto flag = [&](const UnloadedStretch& s) {
    const auto [from, to] = times(s);
    return fmt::format("{}@{}-{}", plate.platform.number, time_text(from), time_text(to));
  };
  const UnloadedStretch& longest =
      *std::max_element(stretches.begin(), stretches.end(),
                        [](const auto& a, const auto& b) { return a.count < b.count; });
  const Vector3d change = stretches.back().force - stretches.front().force;
  std::tie(finding.from, finding.to) = times(longest);
  finding.confidence = 0.9;
  if (change.norm() > options.offset) {
    finding.text = fmt::format("its baseline drifts by {:.1f} N from {} s to {} s", change.norm(),
                               time_text(times(stretches.front()).first),
                               time_text(times(stretches.back()).second));
    finding.flags = {"--zero-plates", flag(stretches.front()), "--zero-plates",
                     flag(stretches.back())};
    findings.push_back(finding);
  } else if (longest.force.norm() > options.offset) {
    const bool seems_loaded = std::abs(longest.force.dot(plate.platform.R_WP.col(2))) >= threshold;
    if (seems_loaded) finding.severity = Severity::kError;
    finding.text =
        fmt::format("unloaded it shows {:.1f}, {:.1f}, {:.1f} N{}", longest.force.x(),
                    longest.force.y(), longest.force.z(),
                    seems_loaded ? ", above the threshold: it seems loaded all the time" : "");
    finding.flags = {"--zero-plates", flag(longest)};
    findings.push_back(finding);
  }
  return findings;
}

std::vector<Finding> find_force_rate_faults(const C3dFile& file, const ForceCheckOptions& options) {
  options.validate();
  const double used = find_number(file.groups, "FORCE_PLATFORM", "USED").value_or(0.0);
  if (!(used > 0.0) || file.analog.channel_count() == 0) return {};
  if (file.analog.rate >= options.least_rate) return {};
  Finding finding;
  finding.severity = Severity::kNote;
  finding.kind = "rate";
  finding.confidence = 0.9;
  finding.text = fmt::format(
      "the force platforms' channels come at {} Hz, {} a frame: heel strikes lie between samples",
      text::format_number(file.analog.rate), file.analog.samples_per_frame);
  finding.advice = "record forces at 1000 Hz";
  return {finding};
}

}  // namespace sinew
