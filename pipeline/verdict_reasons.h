#pragma once

#include <string>
#include <vector>

#include "data/verdict_reason.h"

namespace sinew {

/// A figure and the two limits that it is held against: beyond the first a remark, beyond the
/// second not usable. `worst` NaN: never that. A worst limit below the first bounds from below.
struct Judged {
  double figure;
  double limit;
  double worst;
};

/// A reason if the figure is beyond its first limit, else nothing; weight, figure and the limit
/// that it broke are set, all times `per_unit`. A NaN figure is never beyond. Appends to `reasons`
/// and returns the new one, or null.
VerdictReason* judge_figure(std::vector<VerdictReason>& reasons, const Judged& judged,
                            double per_unit, const char* unit, const char* code,
                            const char* source);

/// A remark of our own (limits::kOwn), without a figure.
VerdictReason own_reason(const char* code, std::string text, std::string remedy);

void append(std::vector<VerdictReason>& reasons, const std::vector<VerdictReason>& more);

/// `a, b, c and 4 more`.
std::string some_names(const std::vector<std::string>& names, std::size_t shown = 6);

}  // namespace sinew
