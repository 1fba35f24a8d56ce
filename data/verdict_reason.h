#pragma once

#include <string>
#include <vector>

#include "data/numbers.h"

namespace sinew {

/// One thing that keeps a result from being good: a figure beyond its limit, in words that a
/// physiotherapist reads. What finds it hands it on; the verdict of a run gathers them.
struct VerdictReason {
  enum class Weight {
    kRemark,    // results can be used by somebody who has read this
    kUnusable,  // results must not be used
  };

  Weight weight = Weight::kRemark;
  std::string code;  // stable, for scripts: "marker-rms", "moved-marker", …
  std::string text;  // a sentence without its full stop: "one of the thighs has no marker"
  // What was found and the limit that it is held against, in `unit`; NaN where there is none.
  double figure = kNaN, limit = kNaN;
  std::string unit;    // "mm", "%", …
  std::string source;  // where the limit is from; "Sinew" for our own
  std::string remedy;  // what to do, with the option that helps
  // Coordinates of the model whose angles, and whose torques, cannot be used for this reason.
  std::vector<std::string> angles, torques;

  bool operator==(const VerdictReason&) const = default;
};

}  // namespace sinew
