#include "ik/manipulator_case.h"

#include <fmt/format.h>

#include <stdexcept>

#include "model/manipulator.h"

namespace sinew {

ManipulatorCase make_manipulator_case(char letter, int links) {
  if (letter != 'A' && letter != 'B') {
    throw std::invalid_argument(fmt::format("there is no case '{}'; expected A or B", letter));
  }
  MusculoskeletalModel model = make_manipulator(links);
  KinematicTree tree = compile_tree(model, {.quaternions = true});
  IkProblem problem;
  const Marker& tip = model.markers[0];
  problem.positions.push_back({tip.body, tip.p_BM, Eigen::Matrix3d::Identity()});
  problem.orientations.push_back(
      {tip.body, Eigen::Matrix3d::Identity(), Eigen::Matrix3d::Identity()});
  if (letter == 'B') {
    for (int i = 1; 2 * i < links; ++i) {
      problem.positions.push_back(
          {2 * i + 1, Eigen::Vector3d::Zero(), Eigen::Matrix3d::Identity()});
    }
  }
  IkTargets targets(problem);
  targets.positions[0] = {0.5, 0.0, 0.0};
  targets.orientations[0] << 0, 0, 1, 0, 1, 0, -1, 0, 0;
  for (std::size_t i = 1; i < targets.positions.size(); ++i) {
    const double reach = 2.0 * static_cast<double>(i) * manipulator_link_length(links);
    targets.positions[i] = {reach, 0.0, 0.0};
  }
  return {std::move(model), std::move(tree), std::move(problem), std::move(targets)};
}

}  // namespace sinew
