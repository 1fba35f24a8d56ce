#include "ik/assembler_goal.h"

#include <cmath>

namespace sinew {

AssemblerGoal::AssemblerGoal(const SimbodyModel& model, const TrackingProblem& tracking)
    : AssemblyCondition("coordinate targets and wires"), model_(model), tracking_(tracking) {}

void AssemblerGoal::set_targets(const IkTargets& targets) {
  double sum = 0.0;
  for (std::size_t i = 0; i < tracking_.markers.size(); ++i) {
    if (!std::isnan(targets.positions[i].x())) sum += tracking_.markers[i].weight;
  }
  scale_ = sum > 0.0 ? 1.0 / sum : 1.0;
  values_ = targets.coordinates;
  weights_.resize(values_.size());
  for (std::size_t i = 0; i < values_.size(); ++i) {
    weights_[i] = coordinate_weight(tracking_.problem, targets, i);
  }
}

// A wire's condition is on a q of the tree; without quaternions that is a coordinate's.
void AssemblerGoal::find_path(const SimTK::State& state, const WireResidual& wire) const {
  path_.clear();
  places_.clear();
  for (int i = 0; i < wire.point_count; ++i) {
    const WirePoint& point = wire_point(tracking_.problem, wire, i);
    if (point.condition_q >= 0) {
      const double q = state.getQ()[model_.q_index(point.condition_q)];
      if (q < point.condition_min || q > point.condition_max) continue;
    }
    path_.push_back({point.link, to_simtk(point.p_BP)});
    places_.push_back(model_.matter()
                          .getMobilizedBody(model_.body(point.link))
                          .findStationLocationInGround(state, path_.back().p_BP));
  }
}

double AssemblerGoal::path_length() const {
  double length = 0.0;
  for (std::size_t i = 1; i < places_.size(); ++i) length += (places_[i] - places_[i - 1]).norm();
  return length;
}

int AssemblerGoal::calcGoal(const SimTK::State& state, SimTK::Real& goal) const {
  goal = 0.0;
  for (std::size_t i = 0; i < tracking_.coordinates.size(); ++i) {
    if (std::isnan(values_[i])) continue;
    const TrackedCoordinate& c = tracking_.coordinates[i];
    const double delta = state.getQ()[model_.q_index(c.coordinate)] - values_[i];
    goal += 0.5 * weights_[i] * delta * delta;
  }
  for (const WireResidual& wire : tracking_.problem.wires) {
    find_path(state, wire);
    const double excess = path_length() - wire.natural_length;
    if (excess > 0.0) goal += 0.5 * wire.weight * excess * excess;
  }
  goal *= scale_;
  return 0;
}

int AssemblerGoal::calcGoalGradient(const SimTK::State& state, SimTK::Vector& gradient) const {
  const SimTK::SimbodyMatterSubsystem& matter = model_.matter();
  SimTK::Vector_<SimTK::SpatialVec> pulls(matter.getNumBodies(),
                                          SimTK::SpatialVec(SimTK::Vec3(0), SimTK::Vec3(0)));
  for (const WireResidual& wire : tracking_.problem.wires) {
    find_path(state, wire);
    const double excess = path_length() - wire.natural_length;
    if (!(excess > 0.0)) continue;
    for (std::size_t i = 1; i < places_.size(); ++i) {
      const SimTK::Vec3 segment = places_[i] - places_[i - 1];
      const double length = segment.norm();
      if (length == 0.0) continue;
      const SimTK::Vec3 pull = (wire.weight * excess / length) * segment;
      matter.getMobilizedBody(model_.body(path_[i].body))
          .applyForceToBodyPoint(state, path_[i].p_BP, pull, pulls);
      matter.getMobilizedBody(model_.body(path_[i - 1].body))
          .applyForceToBodyPoint(state, path_[i - 1].p_BP, -pull, pulls);
    }
  }
  SimTK::Vector by_u, by_q(state.getNQ());
  matter.multiplyBySystemJacobianTranspose(state, pulls, by_u);
  matter.multiplyByNInv(state, true, by_u, by_q);
  for (std::size_t i = 0; i < tracking_.coordinates.size(); ++i) {
    if (std::isnan(values_[i])) continue;
    const TrackedCoordinate& c = tracking_.coordinates[i];
    const int q = model_.q_index(c.coordinate);
    by_q[q] += weights_[i] * (state.getQ()[q] - values_[i]);
  }
  gradient.resize(getNumFreeQs());
  for (SimTK::Assembler::FreeQIndex i(0); i < getNumFreeQs(); ++i) {
    gradient[i] = scale_ * by_q[getQIndexOfFreeQ(i)];
  }
  return 0;
}

}  // namespace sinew
