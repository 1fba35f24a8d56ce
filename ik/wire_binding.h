#pragma once

#include <string>
#include <vector>

#include "data/input_error.h"
#include "ik/residuals.h"
#include "model/musculoskeletal_model.h"

namespace sinew {

/// How a model's muscles, tendons and ligaments take part in inverse kinematics, eq. (38).
struct WireOptions {
  enum class Use {
    kAuto,  // in models with virtual links, which nothing else holds
    kAll,
    kNone,
  };

  Use use = Use::kAuto;
  double penalty = 10.0;  // ρ, Ayusawa & Nakamura's value
  // σ_D [1/m²]; a marker's weight is 1.
  double muscle_weight = 1.0, tendon_weight = 1.0, ligament_weight = 1.0;
  // Of every coordinate of a virtual link, towards its default [1/m², 1/rad²]: where slack wires
  // leave a link free it stays in its place on the bone. Taut wires outweigh it ten million times,
  // so that it moves bones by less than a ten-thousandth of a radian in walking.
  double virtual_link_weight = 1e-6;

  /// Throws std::invalid_argument naming field, value and bound.
  void validate() const;
};

/// A wire of the problem and the path that it comes from.
struct TrackedWire {
  std::string name;
  int path = -1;  // index into MusculoskeletalModel::paths
};

/// Adds a coordinate residual for every coordinate of a virtual link that can move, all with
/// options.virtual_link_weight, and returns the coordinates in the order of the residuals. Their
/// targets are the coordinates' defaults.
std::vector<int> bind_virtual_links(const MusculoskeletalModel& model, const KinematicTree& tree,
                                    const WireOptions& options, IkProblem& problem);

/// Adds a wire for every path that has a natural length and no wrap object or moving point, and
/// names the others in a warning. Returns them in the order of problem.wires.
std::vector<TrackedWire> bind_wires(const MusculoskeletalModel& model, const KinematicTree& tree,
                                    const WireOptions& options, IkProblem& problem,
                                    std::vector<Warning>& warnings);

}  // namespace sinew
