#pragma once

#include <string>
#include <vector>

#include "model/musculoskeletal_model.h"

namespace sinew {

/// What a model consists of, for people to look at.
struct ModelSummary {
  int dof = 0;            // coordinates that no coupler sets; locked ones count
  int coupled = 0;        // coordinates that a coupler sets
  int locked = 0;         // locked or prescribed coordinates
  int bodies = 0;         // without ground and virtual links
  int virtual_links = 0;  // six of the degrees of freedom each
  int wires = 0;          // paths with a natural length
  int muscles = 0, tendons = 0, ligaments = 0, actuators = 0;  // paths by kind
  int markers = 0;
  double mass = 0.0;                // [kg]
  std::vector<int> depth;           // by joint: joints between its child and ground
  std::vector<int> crossing_paths;  // by joint: paths with points on either side of it
};

/// O(bodies · paths).
ModelSummary summarize(const MusculoskeletalModel& model);

/// True where the path has points on bodies beyond the joint and on others, so that the joint's
/// motion can change its length.
std::vector<bool> joints_crossed(const MusculoskeletalModel& model, const PathElement& path);

/// Moment arms of all paths about one coordinate over its range, the others at their defaults.
struct MomentArmTable {
  int coordinate = -1;
  std::vector<double> values;  // of the coordinate [rad or m]
  struct Row {
    int path = -1;
    std::vector<double> lengths;  // a value each [m]
    std::vector<double> arms;     // −∂length/∂coordinate, couplings included [m, m/m]
  };
  std::vector<Row> rows;  // paths that the coordinate moves, in the model's order
};

/// `count` ≥ 2 values, evenly over the coordinate's range. Where that is endless: ±90° for a turn,
/// ±0.1 m for a shift. Locks and prescribed motions are left aside. Throws InputError if the model
/// has no such coordinate, a coupler sets it, or it is no range.
MomentArmTable moment_arm_table(const MusculoskeletalModel& model, const std::string& coordinate,
                                int count);

}  // namespace sinew
