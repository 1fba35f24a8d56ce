#include <fmt/format.h>

#include "ik/articulated_cg.h"
#include "tests/bench/bench_tables.h"
#include "tests/bench/stopwatch.h"
#include "tests/ik/factorized_direction.h"
#include "tests/ik/whole_body_problem.h"

namespace sinew {

void print_direction_times(double batch_seconds) {
  fmt::print(
      "A Gauss-Newton direction of the detailed whole body, taut wires across several joints "
      "[us]\n\n"
      "| off by | taut wires | factorized | cg 1e-2 | iterations | cg 1e-6 | iterations | cg 1e-10 "
      "| "
      "iterations |\n"
      "| -----: | ---------: | ---------: | ------: | ---------: | ------: | ---------: | -------: "
      "| "
      "---------: |\n");
  const WholeBodyProblem body;
  const IkProblem& problem = body.tracking.problem;
  const int n = body.tree.unknown_count();
  for (const double off : {0.01, 0.05, 0.2}) {
    KinematicWorkspace ws = body.workspace(1, off);
    const IkTargets targets = body.targets_at(2, off);
    const Eigen::VectorXd zero = Eigen::VectorXd::Zero(n);
    Iterate at{body.tree,
               problem,
               &targets,
               ws,
               0,
               0.0,
               zero,
               zero,
               zero,
               zero,
               std::vector<char>(static_cast<std::size_t>(n), 0)};
    at.f = decomposed_gradient(body.tree, problem, targets, ws, at.g);
    int taut = 0;
    for (const WireResidual& r : problem.wires) {
      taut += wire_length(problem, r, ws) > r.natural_length;
    }
    FactorizedDirection factorized(body.tree, problem, ArticulatedCg::Options{}.damping);
    ArticulatedCg coarse(body.tree, problem, {.tolerance = 1e-2});
    ArticulatedCg medium(body.tree, problem, {.tolerance = 1e-6});
    ArticulatedCg fine(body.tree, problem, {.tolerance = 1e-10});
    Eigen::VectorXd d(n);
    const auto call = [&](Direction& direction) {
      return [&] {
        direction.start();
        direction.compute(at, d);
      };
    };
    const std::vector<double> seconds =
        best_seconds({call(factorized), call(coarse), call(medium), call(fine)}, batch_seconds);
    fmt::print(
        "| {:6} | {:10} | {:10.0f} | {:7.0f} | {:10} | {:7.0f} | {:10} | {:8.0f} | {:10} |\n", off,
        taut, 1e6 * seconds[0], 1e6 * seconds[1], coarse.iterations(), 1e6 * seconds[2],
        medium.iterations(), 1e6 * seconds[3], fine.iterations());
  }
  fmt::print("\n");
}

}  // namespace sinew
