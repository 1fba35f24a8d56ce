#pragma once

#include <string>
#include <vector>

#include "model/musculoskeletal_model.h"

namespace sinew {

enum class Termination {
  kNone,
  kGradient,       // converged by e3
  kCostChange,     // converged by e2
  kStalled,        // no step lowers the cost further: at the limit of rounding
  kMaxIterations,  // e1
  kTimeLimit,      // MinimizerOptions::time_limit has passed
  kNotFinite,      // the cost or its gradient is not a number at the start
  kSolved,         // Newton-Raphson: the equations hold
  kSingular,       // Newton-Raphson: no step, the Jacobian is singular
  kDiverged,       // Newton-Raphson: steps lead nowhere
};

/// `gradient`, `cost-change`, …; what reports print.
const char* to_string(Termination termination);

/// True if the termination is as good as the problem and rounding allow.
bool converged(Termination termination);

/// Where a minimization stood after an iteration.
struct IterationRow {
  int iteration;
  double f, gradient_norm;        // as in Summary
  double step_length, step_norm;  // α, ‖α d‖₂
};

/// How a solve went. Not converging is told here, never thrown.
struct Summary {
  Termination termination = Termination::kNone;
  int iterations = -1;
  int evaluations = -1;  // of the cost, with or without its gradient
  double initial_cost = kNaN, final_cost = kNaN;
  double gradient_norm = kNaN;  // of unknowns that no bound holds, as MinimizerOptions::test says
  int held = -1;                // unknowns that end on a bound
  double bound_push = kNaN;     // largest gradient that a bound holds against; 0 without any
  double seconds = kNaN;
  std::string detail;  // what a library that did the work said of it; may be empty
  std::vector<IterationRow> rows;

  /// One sentence on how it ended.
  std::string message() const;
  bool converged() const { return sinew::converged(termination); }
};

}  // namespace sinew
