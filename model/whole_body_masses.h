#pragma once

#include <span>

#include "model/musculoskeletal_model.h"
#include "model/whole_body_table.h"

namespace sinew::anatomy {

struct MassOptions {
  double scale = 1.0;   // of lengths, against the tables
  double mass = 75.0;   // of the whole body [kg]
  bool female = false;  // whose rows of segments.csv
};

/// Gives the bones of `model` the masses of segments.csv, segment_places.csv and bones.csv. In the
/// neutral pose the bones of each segment have together exactly the segment's mass m, mass centre c
/// and inertia I, by one of two rules:
///
///  - One bone's share is `rest`: it is the segment less the others (Steiner), which are boxes.
///  - Spread: bone i of share s_i has its mass centre at c + k (p_i − Σ s_j p_j), p_i being the
///    table's place, and its own inertia is s_i (I − P), P being the inertia of the bones' masses
///    as points. k ≤ 1 is the largest number that leaves to the bones' own extension at least
///    kOwnPart of the segment's second moment in every direction, so that the inertia is one that
///    a body can have.
///
/// Percentages of mass are divided by their sum, so that the whole has exactly `options.mass`.
/// Throws InputError if a bone or segment is unknown or missing, shares do not add up to 1, or a
/// rest has no mass or no possible inertia.
void set_masses(std::span<const EmbeddedTable> tables, const MassOptions& options,
                MusculoskeletalModel& model);

}  // namespace sinew::anatomy
