#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "ik/tracking.h"
#include "model/musculoskeletal_model.h"

namespace sinew {

/// wires.csv: a row a frame. First the time, then for every virtual link the place of its origin in
/// the world, `<link>.x`, `.y`, `.z` [m], then for every wire `<wire>.length` [m], `<wire>.slack`
/// [m], by how much it could still lengthen, and `<wire>.strain`, by how much it exceeds its
/// natural length, relative to it; slack and strain are 0 where the other is not.
std::string wires_csv(const MusculoskeletalModel& model, const TrackingProblem& tracking,
                      const TrackingResult& result);

/// The part of summary.json about wires: how many there are and are taut, and the most strained.
nlohmann::ordered_json wire_summary(const TrackingProblem& tracking, const TrackingResult& result);

}  // namespace sinew
