#pragma once

#include <gtest/gtest.h>

#include "tests/pipeline/command_line.h"

namespace sinew {

/// The embedded walk of a body of 1.80 m and 75 kg as a laboratory records it, its truth, and a
/// generic body of another size: walk.c3d, static.c3d, walk.trc, model.osim, truth_ik.mot,
/// truth_id.sto, ..., other.osim.
class LabTrialFiles {
 public:
  LabTrialFiles() {
    const Outcome example = run_sinew(path(), {"example", "--level", "simplified", "--out", "."});
    EXPECT_EQ(example.exit_code, 0) << example.err;
    const Outcome other = run_sinew(path(), {"model", "export", "whole-body", "--height", "1.65",
                                             "--mass", "60", "--out", "other.osim"});
    EXPECT_EQ(other.exit_code, 0) << other.err;
  }

  const std::filesystem::path& path() const { return folder_.path(); }
  void write(const std::string& name, const std::string& content) const {
    folder_.write(name, content);
  }

 private:
  TemporaryFolder folder_;
};

/// Tests that share one of these, and may write files beside its own.
class WithLabTrial : public ::testing::Test {
 protected:
  static void SetUpTestSuite() { trial_ = new LabTrialFiles; }
  static void TearDownTestSuite() {
    delete trial_;
    trial_ = nullptr;
  }
  static const std::filesystem::path& path() { return trial_->path(); }

  inline static LabTrialFiles* trial_ = nullptr;
};

}  // namespace sinew
