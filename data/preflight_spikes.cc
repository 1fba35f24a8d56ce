#include "data/preflight_spikes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "data/text.h"

namespace sinew {
namespace {

// Found by their own rules; what they find in published recordings is counted by a test.
constexpr double kSure = 0.9;

// Whether a marker bears another's name somewhere in the spike.
bool is_swap(const MarkerSpike& spike, const std::vector<MarkerSwap>& swaps) {
  return std::any_of(swaps.begin(), swaps.end(), [&](const MarkerSwap& swap) {
    return (swap.a == spike.marker || swap.b == spike.marker) && swap.first <= spike.last &&
           spike.first <= swap.last;
  });
}

// Channels by the platform that they belong to, and whether they hold places, which jump.
struct ForceChannel {
  int column, platform;
  bool place;
};

std::vector<ForceChannel> channels_of(const std::vector<ForcePlatform>& platforms) {
  std::vector<ForceChannel> channels;
  for (const ForcePlatform& platform : platforms) {
    if (!platform.usable()) continue;
    for (std::size_t i = 0; i < platform.channels.size(); ++i) {
      // Type 1 stores centres of pressure.
      const bool place = platform.type == 1 && (i == 3 || i == 4);
      channels.push_back({platform.channels[i], platform.number, place});
    }
  }
  return channels;
}

struct FoundSamples {
  int platform;
  SampleDrop drop;
  double value;
};

std::vector<FoundSamples> found_in(const C3dFile& file,
                                   const std::vector<ForcePlatform>& platforms) {
  std::vector<FoundSamples> found;
  for (const ForceChannel& channel : channels_of(platforms)) {
    if (channel.column < 0 || channel.column >= file.analog.channel_count()) continue;
    const Eigen::VectorXd samples = file.analog.values.col(channel.column);
    for (const SampleSpike& spike : find_sample_spikes(samples, file.analog.rate, channel.place)) {
      found.push_back({channel.platform,
                       {file.analog.labels[static_cast<std::size_t>(channel.column)],
                        static_cast<double>(spike.first) / file.analog.rate,
                        static_cast<double>(spike.last) / file.analog.rate},
                       spike.value});
    }
  }
  return found;
}

std::vector<FoundSamples> found_in(const TimeTable& table) {
  std::vector<FoundSamples> found;
  const Eigen::Index rows = table.time.size();
  if (rows < 4) return found;
  const double rate = static_cast<double>(rows - 1) / (table.time[rows - 1] - table.time[0]);
  for (std::size_t c = 0; c < table.labels.size(); ++c) {
    // Columns of forces are named as OpenSim does; points and torques about them jump where the
    // foot leaves the ground.
    const std::string name = text::lower(table.labels[c]);
    const bool force = name.ends_with("vx") || name.ends_with("vy") || name.ends_with("vz");
    const Eigen::VectorXd samples = table.values.col(static_cast<Eigen::Index>(c));
    // A point without a force may be missing.
    if (!force && samples.hasNaN()) continue;
    for (const SampleSpike& spike : find_sample_spikes(samples, rate, !force)) {
      found.push_back(
          {0, {table.labels[c], table.time[spike.first], table.time[spike.last]}, spike.value});
    }
  }
  return found;
}

std::vector<Finding> findings_of(const std::vector<FoundSamples>& found) {
  std::vector<Finding> findings;
  for (std::size_t i = 0; i < found.size();) {
    const FoundSamples& first = found[i];
    Finding finding;
    finding.kind = "spike";
    finding.where = first.drop.channel;
    if (first.platform > 0) {
      finding.where = fmt::format("platform {}, {}", first.platform, first.drop.channel);
    }
    finding.from = first.drop.from;
    finding.to = first.drop.to;
    finding.confidence = kSure;
    int times = 0;
    for (; i < found.size() && found[i].drop.channel == first.drop.channel; ++i, ++times) {
      finding.flags.insert(finding.flags.end(), {"--drop-samples", to_text(found[i].drop)});
    }
    finding.text = fmt::format(
        "{} time{} it leaves its neighbours for a moment, first to {:.4g} at {} s: no force does",
        times, times == 1 ? "" : "s", first.value, time_text(first.drop.from));
    findings.push_back(std::move(finding));
  }
  return findings;
}

std::vector<SampleDrop> drops_of(const std::vector<FoundSamples>& found) {
  std::vector<SampleDrop> drops;
  for (const FoundSamples& samples : found) drops.push_back(samples.drop);
  return drops;
}

}  // namespace

std::vector<Finding> find_spike_faults(const MarkerTrajectories& markers,
                                       const std::vector<MarkerSwap>& swaps,
                                       const MarkerSpikeOptions& options) {
  std::map<int, std::vector<MarkerSpike>> by_marker;
  for (const MarkerSpike& spike : find_marker_spikes(markers, options)) {
    if (!is_swap(spike, swaps)) by_marker[spike.marker].push_back(spike);
  }
  std::vector<Finding> findings;
  for (const auto& [marker, spikes] : by_marker) {
    // A marker that is nowhere near for the whole record is a stray one.
    if (spikes.size() == 1 && spikes[0].last - spikes[0].first + 1 == markers.frame_count()) {
      continue;
    }
    const MarkerSpike& worst =
        *std::max_element(spikes.begin(), spikes.end(),
                          [](const auto& a, const auto& b) { return a.distance < b.distance; });
    Finding finding;
    finding.kind = "spike";
    finding.where = markers.names[static_cast<std::size_t>(marker)];
    finding.confidence = kSure;
    set_frames(finding, markers, worst.first, worst.last);
    finding.text = fmt::format(
        "is {:.3g} m from where its neighbours in time lead, and back at once{}", worst.distance,
        spikes.size() == 1 ? "" : fmt::format("; so {} times", spikes.size()));
    for (const MarkerDrop& drop : drops_of(markers, spikes)) {
      finding.flags.insert(finding.flags.end(), {"--drop", to_text(drop)});
    }
    findings.push_back(std::move(finding));
  }
  return findings;
}

std::vector<Finding> find_force_spike_faults(const C3dFile& file,
                                             const std::vector<ForcePlatform>& platforms) {
  return findings_of(found_in(file, platforms));
}

std::vector<Finding> find_force_spike_faults(const TimeTable& table) {
  return findings_of(found_in(table));
}

std::vector<MarkerDrop> drops_of(const MarkerTrajectories& markers,
                                 const std::vector<MarkerSpike>& spikes) {
  std::vector<MarkerDrop> drops;
  for (const MarkerSpike& spike : spikes) {
    drops.push_back({markers.names[static_cast<std::size_t>(spike.marker)],
                     markers.time[spike.first], markers.time[spike.last]});
  }
  return drops;
}

std::vector<SampleDrop> force_spikes(const C3dFile& file,
                                     const std::vector<ForcePlatform>& platforms) {
  return drops_of(found_in(file, platforms));
}

std::vector<SampleDrop> force_spikes(const TimeTable& table) { return drops_of(found_in(table)); }

}  // namespace sinew
