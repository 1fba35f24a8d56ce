#pragma once

#include <span>

#include "model/musculoskeletal_model.h"
#include "model/whole_body_table.h"

namespace sinew::anatomy {

/// Appends the bodies of virtual_links_leg.csv, …_trunk.csv and …_arm.csv, each on a free joint
/// with coordinates NAME_rx, NAME_ry, NAME_rz, NAME_tx, NAME_ty, NAME_tz. Throws InputError if a
/// bone is unknown.
void add_virtual_links(std::span<const EmbeddedTable> tables, double scale,
                       MusculoskeletalModel& model);

/// Appends the wires of wires_leg.csv, …_trunk.csv and …_arm.csv that belong to the level, between
/// the landmarks of landmarks_*.csv: the rows as they stand, then the left side's. Virtual links
/// must stand in the model already. Natural lengths as whole_body.h says. Throws InputError if a
/// landmark or virtual link is unknown, a number is out of its bounds or a path is shorter than
/// 5 mm.
void add_paths(std::span<const EmbeddedTable> tables, double scale, bool detailed,
               MusculoskeletalModel& model);

/// Appends the markers of markers.csv. Names of those on `_r` bones begin with R, and with L on the
/// left. Throws InputError if a bone is unknown.
void add_markers(std::span<const EmbeddedTable> tables, double scale, MusculoskeletalModel& model);

}  // namespace sinew::anatomy
