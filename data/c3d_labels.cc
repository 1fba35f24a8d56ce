#include "data/c3d_labels.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <unordered_map>
#include <unordered_set>
#include <utility>

#include "data/text.h"

namespace sinew::c3d {
namespace {

void warn(C3dFile& file, std::string text) {
  file.warnings.push_back({{file.path, 0}, std::move(text)});
}

// Names must be unique to be found again; the first of a kind keeps its name.
std::vector<std::string> unique_labels(C3dFile& file, const char* parameter,
                                       std::vector<std::string> labels, int count) {
  const auto wanted = static_cast<std::size_t>(count);
  if (labels.size() < wanted) {
    warn(file, fmt::format("{} has {} labels for {}; the others are called unnamed_1, unnamed_2, "
                           "...",
                           parameter, labels.size(), count));
  }
  labels.resize(std::min(labels.size(), wanted));
  if (const auto blank = std::count(labels.begin(), labels.end(), ""); blank > 0) {
    warn(file, fmt::format("{} of {} are blank; they are called unnamed_1, unnamed_2, ...", blank,
                           parameter));
  }
  labels.resize(wanted);
  std::unordered_set<std::string> taken(labels.begin(), labels.end());
  std::unordered_map<std::string, int> copies;
  int unnamed = 0, duplicates = 0;
  std::string example;
  for (std::string& label : labels) {
    const bool blank = label.empty();
    if (!blank && copies.emplace(label, 1).second) continue;
    const std::string base = blank ? "unnamed" : label;
    int& copy = blank ? unnamed : copies[label];
    std::string unique;
    do unique = fmt::format("{}_{}", base, ++copy);
    while (!taken.insert(unique).second);
    if (!blank && duplicates++ == 0) example = fmt::format("{} is called {}", label, unique);
    label = unique;
  }
  if (duplicates > 0) {
    warn(file, fmt::format("{} repeats {} labels; a second {}", parameter, duplicates, example));
  }
  return labels;
}

struct Kind {
  std::string name, unit;  // of the parameter that lists the labels; as stored
};

// TYPE_GROUPS pairs the names of such parameters, ANGLES, with those of single items, ANGLE, from
// which the units' parameters have their names. Old files have the parameters only.
std::vector<std::pair<std::string, std::string>> type_groups(const C3dGroups& groups) {
  std::vector<std::pair<std::string, std::string>> pairs = {
      {"ANGLES", "ANGLE"}, {"FORCES", "FORCE"},   {"MOMENTS", "MOMENT"},
      {"POWERS", "POWER"}, {"SCALARS", "SCALAR"}, {"REACTIONS", "REACTION"}};
  const std::vector<std::string> texts = find_texts(groups, "POINT", "TYPE_GROUPS");
  for (std::size_t i = 0; i + 1 < texts.size(); i += 2) pairs.push_back({texts[i], texts[i + 1]});
  return pairs;
}

std::unordered_map<std::string, Kind> computed_kinds(const C3dGroups& groups) {
  std::unordered_map<std::string, Kind> kinds;
  for (const auto& [plural, singular] : type_groups(groups)) {
    // Modelled markers are positions like those of measured ones.
    if (plural.find("MARKER") != plural.npos || plural.empty()) continue;
    const std::vector<std::string> units = find_texts(groups, "POINT", singular + "_UNITS");
    for (const std::string& label : find_texts(groups, "POINT", plural)) {
      if (label.empty()) continue;
      kinds.emplace(label, Kind{plural, units.empty() ? "" : units.front()});
    }
  }
  return kinds;
}

std::optional<Eigen::Vector3d> axis(const C3dGroups& groups, const char* name) {
  const std::vector<std::string> texts = find_texts(groups, "POINT", name);
  if (texts.empty() || texts.front().empty()) return std::nullopt;
  const std::string& text = texts.front();
  const double sign = text.front() == '-' ? -1.0 : 1.0;
  const std::size_t which = std::string_view("XYZxyz").find(text.back());
  if (which == std::string_view::npos) return std::nullopt;
  return sign * Eigen::Vector3d::Unit(static_cast<Eigen::Index>(which % 3));
}

std::optional<C3dScreen> find_screen(const C3dGroups& groups) {
  const auto x = axis(groups, "X_SCREEN"), y = axis(groups, "Y_SCREEN");
  if (!x || !y || x->dot(*y) != 0.0) return std::nullopt;
  return C3dScreen{*x, *y};
}

void name_channels(C3dFile& file) {
  C3dAnalog& analog = file.analog;
  const int count = file.layout.analog_channels;
  analog.labels =
      unique_labels(file, "ANALOG:LABELS", find_texts(file.groups, "ANALOG", "LABELS"), count);
  analog.units = find_texts(file.groups, "ANALOG", "UNITS");
  analog.units.resize(static_cast<std::size_t>(count));
  analog.samples_per_frame = file.layout.analog_ratio;
  analog.rate = file.layout.rate * file.layout.analog_ratio;
}

std::string text_at(const std::vector<std::string>& texts, std::size_t i) {
  return i < texts.size() ? texts[i] : "";
}

}  // namespace

std::optional<double> metres_per(const std::string& unit) {
  struct Unit {
    const char *symbol, *word;
    double metres;
  };
  static constexpr std::array<Unit, 7> kUnits = {{{"mm", "mill", 1e-3},
                                                  {"cm", "cent", 1e-2},
                                                  {"dm", "deci", 1e-1},
                                                  {"m", "met", 1.0},
                                                  {"in", "inch", 0.0254},
                                                  {"ft", "f", 0.3048},
                                                  {"um", "micr", 1e-6}}};
  const std::string lower = text::lower(text::trim(unit));
  if (lower.empty()) return std::nullopt;
  for (const Unit& known : kUnits) {
    if (lower == known.symbol || lower.starts_with(known.word)) return known.metres;
  }
  return std::nullopt;
}

PointNames name_everything(C3dFile& file) {
  const std::vector<std::string> raw = find_texts(file.groups, "POINT", "LABELS");
  const std::vector<std::string> labels =
      unique_labels(file, "POINT:LABELS", raw, file.layout.points);
  const std::unordered_map<std::string, Kind> kinds = computed_kinds(file.groups);
  PointNames names;
  for (std::size_t i = 0; i < labels.size(); ++i) {
    const auto kind = i < raw.size() ? kinds.find(raw[i]) : kinds.end();
    if (kind == kinds.end()) {
      names.marker_points.push_back(static_cast<int>(i));
      file.markers.names.push_back(labels[i]);
    } else {
      names.computed_points.push_back(static_cast<int>(i));
      file.computed.labels.push_back(labels[i]);
      file.computed.kinds.push_back(kind->second.name);
      file.computed.units.push_back(kind->second.unit);
    }
  }
  file.screen = find_screen(file.groups);
  name_channels(file);
  return names;
}

std::vector<C3dEvent> find_events(const C3dFile& file, std::vector<Warning>& warnings) {
  const C3dGroups& groups = file.groups;
  std::vector<C3dEvent> events = file.header.events;
  const std::vector<double> times = find_numbers(groups, "EVENT", "TIMES");  // minutes, seconds
  const auto promised = static_cast<std::size_t>(
      std::clamp(find_number(groups, "EVENT", "USED", true).value_or(0.0), 0.0, 65535.0));
  const std::size_t count = std::min(promised, times.size() / 2);
  if (count < promised) {
    warnings.push_back({{file.path, 0},
                        fmt::format("EVENT:USED is {}, but EVENT:TIMES has {}; "
                                    "these were read",
                                    promised, count)});
  }
  const std::vector<std::string> labels = find_texts(groups, "EVENT", "LABELS"),
                                 contexts = find_texts(groups, "EVENT", "CONTEXTS"),
                                 subjects = find_texts(groups, "EVENT", "SUBJECTS"),
                                 descriptions = find_texts(groups, "EVENT", "DESCRIPTIONS");
  for (std::size_t i = 0; i < count; ++i) {
    const double time = 60.0 * times[2 * i] + times[2 * i + 1];
    if (!std::isfinite(time)) continue;
    events.push_back({.time = time,
                      .label = text_at(labels, i),
                      .context = text_at(contexts, i),
                      .subject = text_at(subjects, i),
                      .description = text_at(descriptions, i)});
  }
  for (C3dEvent& event : events) event.time -= file.start_time();
  return events;
}

}  // namespace sinew::c3d
