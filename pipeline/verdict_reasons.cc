#include "pipeline/verdict_reasons.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "pipeline/verdict_limits.h"

namespace sinew {

VerdictReason* judge_figure(std::vector<VerdictReason>& reasons, const Judged& judged,
                            double per_unit, const char* unit, const char* code,
                            const char* source) {
  const double sign = judged.worst < judged.limit ? -1.0 : 1.0;
  const auto beyond = [&](double limit) { return sign * judged.figure > sign * limit; };
  if (!beyond(judged.limit)) return nullptr;
  VerdictReason reason;
  const bool unusable = std::isfinite(judged.worst) && beyond(judged.worst);
  reason.weight = unusable ? VerdictReason::Weight::kUnusable : VerdictReason::Weight::kRemark;
  reason.code = code;
  reason.figure = judged.figure * per_unit;
  reason.limit = judged.limit * per_unit;
  reason.unit = unit;
  reason.source = source;
  reasons.push_back(reason);
  return &reasons.back();
}

VerdictReason own_reason(const char* code, std::string text, std::string remedy) {
  VerdictReason r;
  r.code = code;
  r.text = std::move(text);
  r.source = limits::kOwn;
  r.remedy = std::move(remedy);
  return r;
}

void append(std::vector<VerdictReason>& reasons, const std::vector<VerdictReason>& more) {
  reasons.insert(reasons.end(), more.begin(), more.end());
}

std::string some_names(const std::vector<std::string>& names, std::size_t shown) {
  // One more is no longer than what says that there is one more.
  if (names.size() == shown + 1) ++shown;
  std::string text;
  for (std::size_t i = 0; i < std::min(names.size(), shown); ++i) {
    text += (i == 0 ? "" : ", ") + names[i];
  }
  if (names.size() > shown) text += fmt::format(" and {} more", names.size() - shown);
  return text;
}

}  // namespace sinew
