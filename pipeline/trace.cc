#include "pipeline/trace.h"

#include <fmt/format.h>

#include <iterator>

namespace sinew {

std::string trace_csv(const TrackingResult& result, int first_frame) {
  std::string text = "frame,time_s,iteration,cost,gradient_norm,step_length,step_norm\n";
  for (std::size_t i = 0; i < result.frames.size(); ++i) {
    for (const IterationRow& row : result.frames[i].rows) {
      fmt::format_to(std::back_inserter(text), "{},{},{},{},{},{},{}\n",
                     first_frame + static_cast<int>(i) + 1,
                     result.time[static_cast<Eigen::Index>(i)], row.iteration, row.f,
                     row.gradient_norm, row.step_length, row.step_norm);
    }
  }
  return text;
}

}  // namespace sinew
