#include "pipeline/trace.h"

#include <gtest/gtest.h>

namespace sinew {
namespace {

TEST(TraceCsv, HasARowForEveryIterationOfEveryFrame) {
  TrackingResult result;
  result.time = Eigen::Vector3d(0.5, 0.75, 1.0);
  result.frames.resize(3);
  result.frames[0].rows = {{1, 0.5, 0.25, 1.0, 0.125}, {2, 0.25, 1e-12, 0.5, 1e-6}};
  result.frames[2].rows = {{1, 0.125, 2.0, 1.0, 3.0}};
  EXPECT_EQ(trace_csv(result, 10),
            "frame,time_s,iteration,cost,gradient_norm,step_length,step_norm\n"
            "11,0.5,1,0.5,0.25,1,0.125\n"
            "11,0.5,2,0.25,1e-12,0.5,1e-06\n"
            "13,1,1,0.125,2,1,3\n");
}

}  // namespace
}  // namespace sinew
