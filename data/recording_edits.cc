#include "data/recording_edits.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <stdexcept>
#include <utility>

#include "data/c3d_labels.h"
#include "data/finding.h"
#include "data/force_platform.h"
#include "data/marker_names.h"
#include "data/numbers.h"
#include "data/sample_spikes.h"
#include "data/text.h"

namespace sinew {
namespace {

struct Times {
  double from, to;
};

// `FROM-TO`; the sign that separates is the first minus behind a digit or a point.
std::optional<Times> parse_times(const std::string& text) {
  for (std::size_t at = 1; at < text.size(); ++at) {
    const bool behind_number = std::string_view("0123456789.").find(text[at - 1]) != text.npos;
    if (text[at] != '-' || !behind_number) continue;
    const auto from = text::parse_number(text.substr(0, at));
    const auto to = text::parse_number(text.substr(at + 1));
    if (!from || !to || !std::isfinite(*from) || !std::isfinite(*to)) continue;
    return Times{*from, *to};
  }
  return std::nullopt;
}

struct Timed {
  std::string text;
  std::optional<double> from, to;
};

// Without a text where the times end before they begin.
Timed split_times(const std::string& text) {
  const std::size_t at = text.rfind('@');
  if (at == text.npos) return {text, {}, {}};
  const std::optional<Times> times = parse_times(text.substr(at + 1));
  if (!times) return {text, {}, {}};
  if (times->from > times->to) return {};
  return {text.substr(0, at), times->from, times->to};
}

int require_marker(const MarkerTrajectories& markers, const std::string& name, const char* option) {
  const int marker = markers.find_marker(name);
  if (marker >= 0) return marker;
  throw std::invalid_argument(
      fmt::format("{} names '{}', which is no marker of the recording", option, name));
}

// Frames within times; a quarter of a frame allows for the digits of times.
std::pair<int, int> frames_between(const MarkerTrajectories& markers, std::optional<double> from,
                                   std::optional<double> to, const char* option) {
  if (!from) return {0, markers.frame_count()};
  const double slack = 0.25 / markers.rate;
  int first = 0, end = markers.frame_count();
  while (first < end && markers.time[first] < *from - slack) ++first;
  while (end > first && markers.time[end - 1] > *to + slack) --end;
  if (first < end) return {first, end};
  throw std::invalid_argument(
      fmt::format("{}: no frame lies between {} s and {} s", option, *from, *to));
}

// Calls f(table, columns a marker) for every table that has columns for markers.
template <typename Action>
void for_marker_tables(MarkerTrajectories& markers, C3dQuality* quality, const Action& act) {
  act(markers.p_WM, 3);
  if (!quality || quality->residual.size() == 0) return;
  act(quality->residual, 1);
  act(quality->cameras, 1);
}

void swap_names(MarkerTrajectories& markers, C3dQuality* quality, const NameSwap& swap) {
  const int a = require_marker(markers, swap.a, "--swap");
  const int b = require_marker(markers, swap.b, "--swap");
  const auto [first, end] = frames_between(markers, swap.from, swap.to, "--swap");
  for_marker_tables(markers, quality, [&, begin = first, count = end - first](auto& t, int width) {
    const auto kept = t.block(begin, width * a, count, width).eval();
    t.block(begin, width * a, count, width) = t.block(begin, width * b, count, width).eval();
    t.block(begin, width * b, count, width) = kept;
  });
}

void drop_column(MarkerTrajectories& markers, C3dQuality* quality, int marker) {
  for_marker_tables(markers, quality, [&](auto& t, int width) {
    const Eigen::Index behind = t.cols() - width * (marker + 1);
    t.middleCols(width * marker, behind) = t.rightCols(behind).eval();
    t.conservativeResize(Eigen::NoChange, t.cols() - width);
  });
  markers.names.erase(markers.names.begin() + marker);
}

void drop(MarkerTrajectories& markers, C3dQuality* quality, const MarkerDrop& what) {
  const int marker = require_marker(markers, what.name, "--drop");
  if (!what.from) {
    if (markers.marker_count() == 1) {
      throw std::invalid_argument("--drop leaves no marker: leave one out of it");
    }
    return drop_column(markers, quality, marker);
  }
  const auto [first, end] = frames_between(markers, what.from, what.to, "--drop");
  markers.p_WM.block(first, 3 * marker, end - first, 3).setConstant(kNaN);
}

void swap_sides(MarkerTrajectories& markers) {
  const std::vector<MarkerPair> pairs = find_marker_pairs(markers.names);
  if (pairs.empty()) {
    throw std::invalid_argument("--swap-sides: no marker has a partner on the other side");
  }
  for (const MarkerPair& pair : pairs) {
    std::swap(markers.names[static_cast<std::size_t>(pair.left)],
              markers.names[static_cast<std::size_t>(pair.right)]);
  }
}

void rename(MarkerTrajectories& markers, const MarkerRename& names) {
  const int marker = require_marker(markers, names.from, "--rename");
  if (markers.find_marker(names.to) >= 0 && names.to != names.from) {
    throw std::invalid_argument(
        fmt::format("--rename: there is a marker '{}' already; drop or rename it first", names.to));
  }
  markers.names[static_cast<std::size_t>(marker)] = names.to;
}

double metres_of(const std::string& unit) {
  if (const auto metres = c3d::metres_per(unit)) return *metres;
  throw std::invalid_argument("--unit " + unit + " is no unit of length: give mm, cm, m, in or ft");
}

void edit_trajectories(MarkerTrajectories& markers, C3dQuality* quality, double metres_per_unit,
                       const RecordingEdits& edits) {
  if (!edits.unit.empty()) markers.p_WM *= metres_of(edits.unit) / metres_per_unit;
  for (const NameSwap& swap : edits.swaps) swap_names(markers, quality, swap);
  for (const MarkerDrop& what : edits.drops) drop(markers, quality, what);
  if (edits.swap_sides) swap_sides(markers);
  for (const MarkerRename& names : edits.renames) rename(markers, names);
  for (const MarkerDrop& spike : edits.spikes) drop(markers, quality, spike);
}

int usable_platforms(const C3dFile& file) {
  std::vector<Warning> ignored;
  const std::vector<ForcePlatform> platforms = find_force_platforms(file, ignored);
  return static_cast<int>(
      std::count_if(platforms.begin(), platforms.end(), [](const auto& p) { return p.usable(); }));
}

void scale_parameter(C3dFile& file, const char* name, double factor) {
  const C3dParameter* parameter = find_parameter(file.groups, "FORCE_PLATFORM", name);
  if (!parameter) return;
  std::vector<float> values;
  for (const double value : parameter->numbers()) {
    values.push_back(static_cast<float>(value * factor));
  }
  set_parameter(file.groups, "FORCE_PLATFORM",
                C3dParameter::of_reals(name, parameter->dimensions, std::move(values)));
}

void set_unit(C3dFile& file, const std::string& unit) {
  const double metres = metres_of(unit), factor = metres / file.metres_per_unit;
  const int before = usable_platforms(file);
  file.unit = unit;
  file.metres_per_unit = metres;
  if (file.quality.residual.size() > 0) file.quality.residual *= static_cast<float>(factor);
  if (usable_platforms(file) >= before) return;
  // The platforms were right: what they say in the old unit is said in the new one.
  scale_parameter(file, "CORNERS", 1.0 / factor);
  scale_parameter(file, "ORIGIN", 1.0 / factor);
}

// Samples whose times lie within `drop`; a third of a step allows for the digits of times.
void bridge(RowMatrix& values, const std::vector<std::string>& labels, const SampleDrop& drop,
            const std::function<double(Eigen::Index)>& time, double step) {
  const auto label = std::find(labels.begin(), labels.end(), drop.channel);
  if (label == labels.end()) {
    throw std::invalid_argument(fmt::format(
        "--drop-samples names '{}', which is no channel or column of the file", drop.channel));
  }
  Eigen::Index first = 0, end = values.rows();
  while (first < end && time(first) < drop.from - step / 3.0) ++first;
  while (end > first && time(end - 1) > drop.to + step / 3.0) --end;
  if (first == end) {
    throw std::invalid_argument(
        fmt::format("--drop-samples: no sample lies between {} s and {} s", drop.from, drop.to));
  }
  bridge_samples(values.col(label - labels.begin()), first, end - 1);
}

// The mean of columns over samples, and the middle of their times.
struct Baseline {
  double center = 0.0;  // [s]
  Eigen::RowVectorXd mean;
};

Baseline mean_within(const C3dFile& file, const std::vector<int>& channels,
                     const UnloadedTime& time) {
  const auto limited = [&](double seconds) {
    return static_cast<Eigen::Index>(std::clamp(std::round(seconds * file.analog.rate), 0.0,
                                                static_cast<double>(file.analog.values.rows())));
  };
  const Eigen::Index first = limited(time.from), count = limited(time.to) - first;
  if (count < 1) {
    throw std::invalid_argument(
        fmt::format("--zero-plates: no sample lies between {} s and {} s", time.from, time.to));
  }
  Baseline baseline;
  baseline.center =
      (static_cast<double>(first) + 0.5 * static_cast<double>(count - 1)) / file.analog.rate;
  baseline.mean.resize(static_cast<Eigen::Index>(channels.size()));
  for (std::size_t i = 0; i < channels.size(); ++i) {
    baseline.mean[static_cast<Eigen::Index>(i)] =
        file.analog.values.col(channels[i]).segment(first, count).mean();
  }
  return baseline;
}

// Subtracts what goes straight from each mean to the next, and level outside of them.
void subtract_baseline(C3dFile& file, const std::vector<int>& channels,
                       std::vector<UnloadedTime> times) {
  std::sort(times.begin(), times.end(),
            [](const UnloadedTime& a, const UnloadedTime& b) { return a.from < b.from; });
  std::vector<Baseline> means;
  for (const UnloadedTime& time : times) means.push_back(mean_within(file, channels, time));
  std::size_t k = 0;
  for (Eigen::Index row = 0; row < file.analog.values.rows(); ++row) {
    const double t = static_cast<double>(row) / file.analog.rate;
    while (k + 1 < means.size() && t >= means[k + 1].center) ++k;
    Eigen::RowVectorXd baseline = means[k].mean;
    if (k + 1 < means.size() && t > means[k].center) {
      const double s = (t - means[k].center) / (means[k + 1].center - means[k].center);
      baseline += s * (means[k + 1].mean - means[k].mean);
    }
    for (std::size_t i = 0; i < channels.size(); ++i) {
      file.analog.values(row, channels[i]) -= baseline[static_cast<Eigen::Index>(i)];
    }
  }
}

void zero_platforms(C3dFile& file, const std::vector<UnloadedTime>& times) {
  std::vector<Warning> ignored;
  const std::vector<ForcePlatform> platforms = find_force_platforms(file, ignored);
  if (std::none_of(platforms.begin(), platforms.end(), [](const auto& p) { return p.usable(); })) {
    throw std::invalid_argument("--zero-plates: the file has no force platform that can be used");
  }
  for (const UnloadedTime& time : times) {
    const auto fits = [&](const ForcePlatform& p) { return p.number == time.plate && p.usable(); };
    if (time.plate == 0 || std::any_of(platforms.begin(), platforms.end(), fits)) continue;
    throw std::invalid_argument(fmt::format(
        "--zero-plates names platform {}; the file has {}, of which it can be none or not be used",
        time.plate, platforms.size()));
  }
  for (const ForcePlatform& platform : platforms) {
    if (!platform.usable()) continue;
    std::vector<UnloadedTime> own;
    for (const UnloadedTime& time : times) {
      if (time.plate == 0 || time.plate == platform.number) own.push_back(time);
    }
    std::vector<int> channels = platform.channels;
    // Places of type 1 have no offset to lose.
    if (platform.type == 1) channels.erase(channels.begin() + 3, channels.begin() + 5);
    if (!own.empty()) subtract_baseline(file, channels, std::move(own));
  }
}

void shift_channels(C3dFile& file, double seconds) {
  const Eigen::Index rows = file.analog.values.rows();
  if (rows == 0) throw std::invalid_argument("--shift-forces: the file has no analog channels");
  const auto by = static_cast<Eigen::Index>(std::lround(seconds * file.analog.rate));
  const RowMatrix before = file.analog.values;
  for (Eigen::Index row = 0; row < rows; ++row) {
    file.analog.values.row(row) = before.row(std::clamp<Eigen::Index>(row - by, 0, rows - 1));
  }
}

}  // namespace

bool RecordingEdits::edits_markers() const {
  return !unit.empty() || !swaps.empty() || !drops.empty() || swap_sides || !renames.empty() ||
         !spikes.empty();
}

std::optional<NameSwap> parse_swap(const std::string& text) {
  const Timed timed = split_times(text);
  const std::size_t comma = timed.text.find(',');
  if (comma == timed.text.npos || comma == 0 || comma + 1 == timed.text.size()) return std::nullopt;
  // Names with commas cannot be told apart.
  if (timed.text.find(',', comma + 1) != timed.text.npos) return std::nullopt;
  NameSwap swap{timed.text.substr(0, comma), timed.text.substr(comma + 1), timed.from, timed.to};
  return swap.a == swap.b ? std::nullopt : std::optional<NameSwap>(std::move(swap));
}

std::optional<MarkerDrop> parse_drop(const std::string& text) {
  Timed timed = split_times(text);
  if (timed.text.empty()) return std::nullopt;
  return MarkerDrop{std::move(timed.text), timed.from, timed.to};
}

std::optional<MarkerRename> parse_rename(const std::string& text) {
  const std::size_t equals = text.find('=');
  if (equals == text.npos || equals == 0 || equals + 1 == text.size()) return std::nullopt;
  return MarkerRename{text.substr(0, equals), text.substr(equals + 1)};
}

std::optional<UnloadedTime> parse_unloaded(const std::string& text) {
  const std::size_t at = text.find('@');
  const std::optional<Times> times = parse_times(at == text.npos ? text : text.substr(at + 1));
  if (!times || !(times->from < times->to)) return std::nullopt;
  if (at == text.npos) return UnloadedTime{0, times->from, times->to};
  const auto plate = text::parse_integer(text.substr(0, at));
  if (!plate || *plate < 1 || *plate > 255) return std::nullopt;
  return UnloadedTime{static_cast<int>(*plate), times->from, times->to};
}

std::optional<SampleDrop> parse_sample_drop(const std::string& text) {
  Timed timed = split_times(text);
  if (timed.text.empty() || !timed.from) return std::nullopt;
  return SampleDrop{std::move(timed.text), *timed.from, *timed.to};
}

std::string to_text(const MarkerDrop& drop) {
  if (!drop.from) return drop.name;
  return fmt::format("{}@{}-{}", drop.name, time_text(*drop.from), time_text(*drop.to));
}

std::string to_text(const SampleDrop& drop) {
  return fmt::format("{}@{}-{}", drop.channel, time_text(drop.from), time_text(drop.to));
}

void drop_samples(TimeTable& table, const std::vector<SampleDrop>& samples) {
  const Eigen::Index rows = table.time.size();
  const double step =
      rows > 1 ? (table.time[rows - 1] - table.time[0]) / static_cast<double>(rows - 1) : 0.0;
  for (const SampleDrop& drop : samples) {
    bridge(
        table.values, table.labels, drop, [&](Eigen::Index i) { return table.time[i]; }, step);
  }
}

void edit_markers(MarkerTrajectories& markers, double metres_per_unit,
                  const RecordingEdits& edits) {
  edit_trajectories(markers, nullptr, metres_per_unit, edits);
}

void edit_recording(C3dFile& file, const RecordingEdits& edits) {
  edit_trajectories(file.markers, &file.quality, file.metres_per_unit, edits);
  if (!edits.unit.empty()) set_unit(file, edits.unit);
  for (const SampleDrop& sample : edits.samples) {
    const double step = 1.0 / file.analog.rate;
    const auto time = [&](Eigen::Index i) { return static_cast<double>(i) * step; };
    bridge(file.analog.values, file.analog.labels, sample, time, step);
  }
  if (!edits.unloaded.empty()) zero_platforms(file, edits.unloaded);
  if (edits.shift_forces != 0.0) shift_channels(file, edits.shift_forces);
}

}  // namespace sinew
