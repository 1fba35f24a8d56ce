#include <gtest/gtest.h>

#include "tests/pipeline/command_line.h"
#include "tests/pipeline/small_trial.h"

namespace sinew {
namespace {

using Arguments = std::vector<std::string>;

// Recordings so long that solving them takes many seconds.
constexpr int kLong = 60000;

class Interrupt : public ::testing::Test {
 protected:
  Interrupt() {
    SmallTrial::write(folder_);
    MarkerTrajectories markers = SmallTrial::recording(kLong);
    // Noise, so that no frame starts at its solution.
    for (int frame = 0; frame < kLong; ++frame) {
      for (int k = 0; k < 18; ++k) markers.p_WM(frame, k) += 0.01 * std::sin(7.0 * frame + k);
    }
    write_trc(folder_.path() / "long.trc", markers);
    files_ = tree_of(folder_.path());
  }

  // Stopped while it works: exit 1 within a second or two, nothing left behind.
  void expect_stop(const Arguments& arguments) {
    const Outcome outcome = run_sinew(folder_.path(), arguments, Interruption{0.0, "frames"});
    EXPECT_EQ(outcome.exit_code, 1) << outcome.err << outcome.out;
    EXPECT_LT(outcome.seconds, 3.0);
    EXPECT_NE(outcome.err.find("stopped; no"), std::string::npos) << outcome.err;
    EXPECT_EQ(tree_of(folder_.path()), files_);
  }

  TemporaryFolder folder_;
  std::vector<std::string> files_;
};

TEST_F(Interrupt, LeavesNothingBehind) {
  // L-BFGS with an unreachable tolerance works long enough on every frame.
  const Arguments slow = {
      "--model",          "model.osim",           "--markers", "long.trc", "--method",
      "steepest-descent", "--gradient-tolerance", "1e-15"};
  const auto with = [&](Arguments head, const Arguments& tail) {
    head.insert(head.end(), slow.begin(), slow.end());
    head.insert(head.end(), tail.begin(), tail.end());
    return head;
  };
  expect_stop(with({"run"}, {"--out", "r"}));
  expect_stop(with({"ik"}, {"--out", "r/q.mot"}));
  expect_stop({"validate", "--model", "model.osim", "--markers", "long.trc", "--json", "v.json"});
}

}  // namespace
}  // namespace sinew
