#include "dynamics/furcation_pose.h"

#include <fmt/format.h>

#include <stdexcept>

namespace sinew {
namespace {

// With couplers gone and all but the virtual links' coordinates locked.
KinematicTree compile_links_only(MusculoskeletalModel model) {
  model.couplers.clear();
  for (Coordinate& c : model.coordinates) {
    const bool of_link = model.bodies[static_cast<std::size_t>(c.joint) + 1].virtual_link;
    c.prescribed.reset();
    c.clamped = false;
    if (!of_link) c.locked = true;
  }
  return compile_tree(model);
}

IkProblem links_problem(const MusculoskeletalModel& model, const KinematicTree& tree,
                        const WireOptions& options, std::vector<int>& free,
                        std::vector<TrackedWire>& wires) {
  IkProblem problem;
  std::vector<Warning> warnings;  // the tracking that this stands in for gives them
  free = bind_virtual_links(model, tree, options, problem);
  wires = bind_wires(model, tree, options, problem, warnings);
  return problem;
}

IkTargets default_targets(const MusculoskeletalModel& model, const IkProblem& problem,
                          const std::vector<int>& free) {
  IkTargets targets(problem);
  for (std::size_t i = 0; i < free.size(); ++i) {
    targets.coordinates[i] = model.coordinates[static_cast<std::size_t>(free[i])].default_value;
  }
  return targets;
}

}  // namespace

FurcationPose::FurcationPose(const MusculoskeletalModel& model, const WireOptions& options)
    : tree_(compile_links_only(model)),
      problem_(links_problem(model, tree_, options, free_, wires_)),
      targets_(default_targets(model, problem_, free_)),
      minimizer_(tree_, problem_, {}),
      q_(tree_.default_q) {}

void FurcationPose::solve(std::span<double> q) {
  for (std::size_t c = 0; c < q.size(); ++c) {
    q_[static_cast<std::size_t>(tree_.q_of_coordinate[c])] = q[c];
  }
  const Summary& summary = minimizer_.minimize(targets_, q_);
  if (!summary.converged()) {
    throw std::runtime_error(fmt::format("virtual links found no place: {} after {} iterations",
                                         to_string(summary.termination), summary.iterations));
  }
  for (const int c : free_) {
    const auto i = static_cast<std::size_t>(c);
    q[i] = q_[static_cast<std::size_t>(tree_.q_of_coordinate[i])];
  }
}

FurcationPose::Strain FurcationPose::largest_strain() {
  Strain largest;
  for (std::size_t i = 0; i < problem_.wires.size(); ++i) {
    const WireResidual& wire = problem_.wires[i];
    const double strain =
        wire_length(problem_, wire, minimizer_.workspace()) / wire.natural_length - 1.0;
    if (strain > largest.value) largest = {wires_[i].path, strain};
  }
  return largest;
}

}  // namespace sinew
