#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iostream>

#include "dynamics/coordinate_table.h"
#include "dynamics/external_loads.h"
#include "dynamics/inverse_dynamics.h"
#include "dynamics/reference_recording.h"
#include "ik/tracking.h"

namespace sinew {
namespace {

using Eigen::VectorXd;

const ReferenceRecording& recording() {
  static const ReferenceRecording made = make_reference_recording();
  return made;
}

// The coordinates that 70 markers determine, spine, shoulder girdle and fingers aside. What markers
// leave free, wires hold where they are taut, and there are minima with other wires taut less than
// 1e-13 m² apart. The free directions bend: over the way from the truth to the solution they may
// take along (C7, by 1e-3 rad) what they leave in place at one end.
TEST(ReferenceRecording, InverseKinematicsFindsTheTruth) {
  const ReferenceRecording& r = recording();
  const KinematicTree tree = compile_tree(r.model);
  const MarkerFile file{"walk", r.markers, {}};
  const TrackingProblem tracking = bind_recording(r.model, tree, file, nullptr, nullptr);
  EXPECT_TRUE(tracking.warnings.empty());
  // As `sinew run` solves it: what markers hold weakly needs a small gradient to be where it
  // belongs.
  TrackingOptions options;
  options.minimizer.gradient_tolerance = 1e-11;
  const TrackingResult solved = track(r.model, tree, tracking, r.markers, options);
  IkTargets targets(tracking.problem);
  set_targets(tracking, r.markers, 0, targets);
  TrackingProblem markers_alone = tracking;
  markers_alone.problem.wires.clear();
  std::vector<bool> determinate(r.model.coordinates.size(), true);
  for (const RowMatrix* end : {&r.true_coordinates.values, &solved.coordinates}) {
    std::vector<double> q(tree.default_q);
    for (std::size_t c = 0; c < r.model.coordinates.size(); ++c) {
      q[static_cast<std::size_t>(tree.q_of_coordinate[c])] =
          (*end)(0, static_cast<Eigen::Index>(c));
    }
    for (const int c : undetermined_coordinates(r.model, tree, markers_alone, targets, q)) {
      determinate[static_cast<std::size_t>(c)] = false;
    }
  }
  double largest = 0.0;
  std::string worst;
  int compared = 0;
  for (std::size_t c = 0; c < r.model.coordinates.size(); ++c) {
    const Coordinate& coordinate = r.model.coordinates[c];
    const bool link = r.model.bodies[static_cast<std::size_t>(coordinate.joint) + 1].virtual_link;
    if (!determinate[c] || link) continue;
    ++compared;
    const auto column = static_cast<Eigen::Index>(c);
    const double error = (solved.coordinates.col(column) - r.true_coordinates.values.col(column))
                             .cwiseAbs()
                             .maxCoeff();
    if (error > largest) {
      largest = error;
      worst = coordinate.name;
    }
  }
  EXPECT_GE(compared, 30);
  std::cout << compared << " determinate coordinates; largest error " << largest << " rad or m, of "
            << worst << "\n";
  EXPECT_LE(largest, 1e-5);
}

// Largest error as a part of the largest true torque of its column, from 0.15 s after the start to
// 0.15 s before the end: where a spline has lost its end conditions.
double torque_error(const ReferenceRecording& r, double cutoff) {
  const SimbodyModel compiled(r.model);
  const CoordinateTable motion =
      coordinate_table(r.model, TimeTableFile{"truth", r.true_coordinates, {}});
  EXPECT_TRUE(motion.warnings.empty());
  const ExternalLoads loads(r.model, r.loads, TimeTableFile{"forces", r.forces, {}});
  EXPECT_TRUE(loads.warnings().empty());
  InverseDynamicsOptions options;
  options.cutoff = cutoff;
  const TimeTable found = inverse_dynamics(r.model, compiled, motion, loads, options).forces;
  EXPECT_EQ(found.labels, r.true_forces.labels);
  const Eigen::Index first = 15, rows = found.time.size() - 2 * first;
  double worst = 0.0;
  for (Eigen::Index c = 6; c < found.values.cols(); ++c) {
    const double peak = r.true_forces.values.col(c).cwiseAbs().maxCoeff();
    if (peak < 1.0) continue;  // [N m]; patellae and toes
    const VectorXd error = (found.values.col(c) - r.true_forces.values.col(c)).segment(first, rows);
    worst = std::max(worst, error.cwiseAbs().maxCoeff() / peak);
  }
  std::cout << "cutoff " << cutoff << " Hz: largest error " << 100.0 * worst << " % of the peak\n";
  return worst;
}

// Markers without noise need no filter. One of 6 Hz takes away part of the swing leg's true motion.
TEST(ReferenceRecording, InverseDynamicsFindsTheTruth) {
  EXPECT_LE(torque_error(recording(), -1.0), 1e-3);
  EXPECT_LE(torque_error(recording(), 6.0), 0.25);
}

}  // namespace
}  // namespace sinew
