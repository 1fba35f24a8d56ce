#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "model/musculoskeletal_model.h"
#include "model/whole_body_table.h"

namespace sinew::anatomy {

/// Appends ground, the bones and the joints of joints.csv to an empty model: first the rows as they
/// stand, then the left side's. Bones have no mass yet. Throws InputError if a parent does not
/// stand before its child, or lists of coordinates, axes and ranges differ in length.
void add_bones(std::span<const EmbeddedTable> tables, double scale, MusculoskeletalModel& model);

/// Places of the bodies' origins in the neutral pose, where all frames are parallel to the world's,
/// from the hips [m].
std::vector<Eigen::Vector3d> neutral_places(const MusculoskeletalModel& model);

/// The body that a row's field names. Throws InputError if there is none.
int find_bone(const MusculoskeletalModel& model, const TableRow& row, std::string_view column);

/// X, -X, Y, … as a unit vector, or three numbers joined by ':'. Throws InputError otherwise.
Eigen::Vector3d direction(const TableRow& row, std::string_view column, std::string_view word);

}  // namespace sinew::anatomy
