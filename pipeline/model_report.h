#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "model/furcation.h"
#include "model/model_check.h"
#include "model/model_summary.h"
#include "model/musculoskeletal_model.h"

namespace sinew {

/// Counts, then a row a body in the shape of the tree: its joint, mass, the paths that cross the
/// joint, and its coordinates.
std::string info_text(const MusculoskeletalModel& model, const ModelSummary& summary);
nlohmann::ordered_json info_json(const MusculoskeletalModel& model, const ModelSummary& summary);

/// A row a path: its moment arm at each value, in mm (mm/m for shifts).
std::string moment_arm_text(const MusculoskeletalModel& model, const MomentArmTable& table);
/// In rad and m.
nlohmann::ordered_json moment_arm_json(const MusculoskeletalModel& model,
                                       const MomentArmTable& table);

/// A line a finding, then how many of each severity.
std::string findings_text(const std::vector<ModelFinding>& findings);
nlohmann::ordered_json findings_json(const std::vector<ModelFinding>& findings);
/// A line a virtual link that was made.
std::string furcations_text(const std::vector<Furcation>& furcations);
std::ptrdiff_t count(const std::vector<ModelFinding>& findings, ModelFinding::Severity severity);

}  // namespace sinew
