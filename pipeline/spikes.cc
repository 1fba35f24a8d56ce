#include "pipeline/spikes.h"

#include <fmt/format.h>

#include "data/finding.h"
#include "data/force_platform.h"
#include "data/preflight_spikes.h"

namespace sinew {
namespace {

template <typename Drop>
std::vector<std::string> texts_of(const std::vector<Drop>& drops) {
  std::vector<std::string> texts;
  for (const Drop& drop : drops) texts.push_back(to_text(drop));
  return texts;
}

template <typename Drop, typename Parse>
std::vector<Drop> settle(Decision decision, const std::vector<Drop>& found, const Parse& parse,
                         DecisionLog& log) {
  if (found.empty() && !log.said(decision.name)) return {};
  decision.found = texts_of(found);
  const std::string option = decision.option;
  const nlohmann::ordered_json value = log.settle(std::move(decision));
  if (value == "none") return {};
  std::vector<Drop> drops;
  if (value.is_array()) {
    for (const auto& item : value) {
      const auto drop = item.is_string() ? parse(item.template get<std::string>()) : std::nullopt;
      if (!drop) break;
      drops.push_back(*drop);
    }
    if (drops.size() == value.size()) return drops;
  }
  throw InputError({option},
                   {"names no samples that are left out", "none, or a list of NAME@FROM-TO",
                    value.dump(), "Correct the value."});
}

}  // namespace

std::vector<MarkerDrop> settle_spikes(const std::string& trial, const MarkerTrajectories& markers,
                                      DecisionLog& log) {
  return settle<MarkerDrop>({trial + "spikes",
                             {},
                             {},
                             "where no marker can be for a moment; taken as not measured",
                             0.9,
                             "",
                             "--spikes"},
                            drops_of(markers, find_marker_spikes(markers)), parse_drop, log);
}

std::vector<SampleDrop> settle_force_spikes(const std::string& trial, const C3dFile& file,
                                            DecisionLog& log) {
  std::vector<Warning> ignored;
  return settle<SampleDrop>({trial + "force spikes",
                             {},
                             {},
                             "where no force is like that for a moment; left out",
                             0.9,
                             "",
                             "--force-spikes"},
                            force_spikes(file, find_force_platforms(file, ignored)),
                            parse_sample_drop, log);
}

void leave_out_spikes(MarkerTrajectories& markers, const std::string& path,
                      const std::string& option, std::vector<Warning>& warnings) {
  const std::vector<MarkerSpike> spikes = find_marker_spikes(markers);
  if (spikes.empty()) return;
  double farthest = 0.0;
  for (const MarkerSpike& spike : spikes) farthest = std::max(farthest, spike.distance);
  warnings.push_back(
      {{path},
       fmt::format(
           "markers are for a moment where they cannot be, up to {:.3g} m off, and taken as "
           "not measured then: {}{}",
           farthest, list_names(texts_of(drops_of(markers, spikes))),
           option.empty() ? "" : "; " + option + " keeps them")});
  leave_out(markers, spikes);
}

void leave_out_spikes(TimeTable& table, const std::string& path, std::vector<Warning>& warnings) {
  // What is no number is refused where loads are read.
  if (!table.values.array().isFinite().all()) return;
  const std::vector<SampleDrop> spikes = force_spikes(table);
  if (spikes.empty()) return;
  warnings.push_back({{path},
                      fmt::format("samples that no force makes are left out: {}; --force-spikes "
                                  "none keeps them",
                                  list_names(texts_of(spikes)))});
  drop_samples(table, spikes);
}

}  // namespace sinew
