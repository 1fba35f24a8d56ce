#include "dynamics/reference_motion.h"

#include <fmt/format.h>

#include <algorithm>

namespace sinew {

ReferenceMotion::ReferenceMotion(const MusculoskeletalModel& model, const ReferenceWalk& walk)
    : curves_(walk.curves), stride_time_(walk.stride_time) {
  for (const Coordinate& c : model.coordinates) defaults_.push_back(c.default_value);
  for (const CoordinateCoupler& c : model.couplers) {
    couplers_.push_back({static_cast<std::size_t>(c.dependent),
                         static_cast<std::size_t>(c.independent), CompiledFunction(c.function)});
  }
  for (const WalkCurve& curve : curves_) {
    const int c = model.find_coordinate(curve.coordinate);
    const auto moves = [&](const CoordinateCoupler& coupler) { return coupler.dependent == c; };
    if (c < 0 || std::any_of(model.couplers.begin(), model.couplers.end(), moves)) {
      throw InputError({"the reference walk", 0},
                       {fmt::format("a curve for '{}'", curve.coordinate),
                        "an uncoupled coordinate of the model", "", "Correct the name."});
    }
    coordinates_.push_back(static_cast<std::size_t>(c));
  }
}

void ReferenceMotion::evaluate(double time, std::span<double> q, std::span<double> q_dot,
                               std::span<double> q_ddot) const {
  std::copy(defaults_.begin(), defaults_.end(), q.begin());
  std::fill(q_dot.begin(), q_dot.end(), 0.0);
  std::fill(q_ddot.begin(), q_ddot.end(), 0.0);
  const double phase = time / stride_time_, rate = 1.0 / stride_time_;
  for (std::size_t i = 0; i < curves_.size(); ++i) {
    const WalkCurve& curve = curves_[i];
    const auto [f, df, ddf] = sinew::evaluate(curve.series, phase - curve.delay);
    const std::size_t c = coordinates_[i];
    q[c] = f + curve.advance * phase;
    q_dot[c] = (df + curve.advance) * rate;
    q_ddot[c] = ddf * rate * rate;
  }
  for (const Coupler& coupler : couplers_) {
    const auto f = coupler.function.evaluate(q[coupler.independent]);
    const double v = q_dot[coupler.independent];
    q[coupler.dependent] = f.f;
    q_dot[coupler.dependent] = f.df * v;
    q_ddot[coupler.dependent] = f.ddf * v * v + f.df * q_ddot[coupler.independent];
  }
}

}  // namespace sinew
