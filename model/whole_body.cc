#include "model/whole_body.h"

#include <fmt/format.h>

#include <stdexcept>

#include "model/whole_body_masses.h"
#include "model/whole_body_skeleton.h"
#include "model/whole_body_wires.h"

namespace sinew {
namespace {

// The tables describe a man of this stature [m].
constexpr double kTableHeight = 1.80;

constexpr double kLowestHeight = 1.20, kGreatestHeight = 2.30;  // [m] of grown-ups
constexpr double kLowestMass = 20.0, kGreatestMass = 250.0;     // [kg]

void require_within(const char* field, double value, double low, double high, const char* unit) {
  if (value >= low && value <= high) return;
  throw std::invalid_argument(fmt::format("WholeBodyOptions::{} is {} {}; it must be {} to {}",
                                          field, value, unit, low, high));
}

}  // namespace

void WholeBodyOptions::validate() const {
  require_within("height", height, kLowestHeight, kGreatestHeight, "m");
  require_within("mass", mass, kLowestMass, kGreatestMass, "kg");
}

MusculoskeletalModel whole_body(const WholeBodyOptions& options) {
  return whole_body(options, anatomy::whole_body_tables());
}

MusculoskeletalModel whole_body(const WholeBodyOptions& options,
                                std::span<const anatomy::EmbeddedTable> tables) {
  options.validate();
  const bool detailed = options.level == WholeBodyOptions::Level::kDetailed;
  const double scale = options.height / kTableHeight;
  MusculoskeletalModel model;
  model.name = detailed ? "whole_body_detailed" : "whole_body";
  model.document_version = 40000;
  anatomy::add_bones(tables, scale, model);
  anatomy::set_masses(tables, {scale, options.mass, options.sex == WholeBodyOptions::Sex::kFemale},
                      model);
  if (detailed) anatomy::add_virtual_links(tables, scale, model);
  anatomy::add_paths(tables, scale, detailed, model);
  anatomy::add_markers(tables, scale, model);
  validate(model);
  return model;
}

std::optional<WholeBodyOptions> find_whole_body(std::string_view name) {
  WholeBodyOptions options;
  if (name == "whole-body-detailed") return options;
  options.level = WholeBodyOptions::Level::kSimplified;
  if (name == "whole-body") return options;
  return std::nullopt;
}

}  // namespace sinew
