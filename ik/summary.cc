#include "ik/summary.h"

#include <fmt/format.h>

namespace sinew {

const char* to_string(Termination termination) {
  switch (termination) {
    case Termination::kNone:
      return "none";
    case Termination::kGradient:
      return "gradient";
    case Termination::kCostChange:
      return "cost-change";
    case Termination::kStalled:
      return "stalled";
    case Termination::kMaxIterations:
      return "max-iterations";
    case Termination::kTimeLimit:
      return "time-limit";
    case Termination::kNotFinite:
      return "not-finite";
    case Termination::kSolved:
      return "solved";
    case Termination::kSingular:
      return "singular";
    case Termination::kDiverged:
      return "diverged";
  }
  return "unknown";
}

bool converged(Termination termination) {
  switch (termination) {
    case Termination::kGradient:
    case Termination::kCostChange:
    case Termination::kStalled:
    case Termination::kSolved:
      return true;
    default:
      return false;
  }
}

std::string Summary::message() const {
  const std::string said = detail.empty() ? "" : fmt::format(" ({})", detail);
  switch (termination) {
    case Termination::kGradient:
      return fmt::format("converged: the gradient's norm is {:.3g}", gradient_norm);
    case Termination::kCostChange:
      return fmt::format("converged: the cost no longer changes at {:.6g}", final_cost);
    case Termination::kStalled:
      return fmt::format("no step lowers the cost {:.6g} further; the gradient's norm is {:.3g}",
                         final_cost, gradient_norm);
    case Termination::kMaxIterations:
      return fmt::format("not converged after {} iterations; the gradient's norm is {:.3g}{}",
                         iterations, gradient_norm, said);
    case Termination::kTimeLimit:
      return fmt::format("out of time after {} iterations; the gradient's norm is {:.3g}",
                         iterations, gradient_norm);
    case Termination::kNotFinite:
      return "the cost or its gradient is not a number at the start";
    case Termination::kSolved:
      return fmt::format("solved in {} iterations; the cost is {:.3g}", iterations, final_cost);
    case Termination::kSingular:
      return fmt::format("the Jacobian is singular after {} iterations; the cost is {:.3g}{}",
                         iterations, final_cost, said);
    case Termination::kDiverged:
      return fmt::format("diverged after {} iterations; the cost is {:.3g}{}", iterations,
                         final_cost, said);
    case Termination::kNone:
      break;
  }
  return "not started";
}

}  // namespace sinew
