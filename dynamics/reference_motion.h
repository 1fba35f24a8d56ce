#pragma once

#include <span>
#include <vector>

#include "data/reference_walk.h"
#include "model/musculoskeletal_model.h"
#include "model/scalar_function.h"

namespace sinew {

/// The walk's motion in the coordinates of a model: a curve's coordinate follows it, a coupled one
/// its coupler, all others stay at their defaults. Periodic but for the advance.
class ReferenceMotion {
 public:
  /// Throws InputError if a curve names no coordinate of the model or one that is coupled.
  ReferenceMotion(const MusculoskeletalModel& model, const ReferenceWalk& walk);

  /// By coordinate, at any time.
  void evaluate(double time, std::span<double> q, std::span<double> q_dot,
                std::span<double> q_ddot) const;

 private:
  struct Coupler {
    std::size_t dependent, independent;
    CompiledFunction function;
  };
  std::vector<WalkCurve> curves_;
  std::vector<std::size_t> coordinates_;  // of each curve
  std::vector<Coupler> couplers_;
  std::vector<double> defaults_;
  double stride_time_;
};

}  // namespace sinew
