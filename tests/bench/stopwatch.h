#pragma once

#include <algorithm>
#include <functional>
#include <limits>
#include <vector>

#include "pipeline/cpu_time.h"

namespace sinew {

/// Seconds a call of each, side by side: every round runs a batch of each in turn, so that whatever
/// else the machine does hits all of them, and the best round of each counts.
inline std::vector<double> best_seconds(const std::vector<std::function<void()>>& calls,
                                        double batch_seconds) {
  const auto run = [](const std::function<void()>& call, int count) {
    const double start = cpu_seconds();
    for (int i = 0; i < count; ++i) call();
    return cpu_seconds() - start;
  };
  std::vector<int> counts;
  for (const auto& call : calls) {
    int count = 1;
    while (run(call, count) < batch_seconds) count *= 2;
    counts.push_back(count);
  }
  constexpr int kRounds = 7;  // more change the best by less than a percent on a quiet machine
  std::vector<double> best(calls.size(), std::numeric_limits<double>::infinity());
  for (int round = 0; round < kRounds; ++round) {
    for (std::size_t i = 0; i < calls.size(); ++i) {
      best[i] = std::min(best[i], run(calls[i], counts[i]) / counts[i]);
    }
  }
  return best;
}

}  // namespace sinew
