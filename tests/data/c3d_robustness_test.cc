#include <gtest/gtest.h>

#include <random>

#include "data/c3d_reader.h"
#include "data/c3d_writer.h"
#include "data/force_platform.h"
#include "tests/data/test_files.h"

namespace sinew {
namespace {

namespace fs = std::filesystem;

const fs::path kSamples = "../shared/data/c3d.org";

// One of each byte order and number format, with odd parameters; small, as each is read 150 times.
const std::vector<std::string> kFiles = {"sample_02/pc_real.c3d",  "sample_02/dec_int.c3d",
                                         "sample_02/sgi_int.c3d",  "sample_10/TYPE-3.c3d",
                                         "sample_10/TYPE-4.C3D",   "sample_16/golf.c3d",
                                         "sample_30/admarche2.c3d"};

class C3dRobustness : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!fs::exists(kSamples)) GTEST_SKIP() << "needs the recordings in " << kSamples;
  }

  // Reads, computes forces and writes. False if the file was refused, which must be said in words.
  bool use(const std::string& bytes) const {
    const auto path = folder_.write("a.c3d", bytes);
    try {
      const C3dFile file = read_c3d(path);
      // Nothing may be larger than the file warrants: a number of 2 bytes becomes one of 8.
      const auto numbers = static_cast<std::size_t>(
          file.markers.p_WM.size() + file.computed.values.size() + file.analog.values.size());
      EXPECT_LE(numbers, bytes.size() / 2);
      for (int i = 1; i < file.markers.frame_count(); ++i) {
        EXPECT_GT(file.markers.time[i], file.markers.time[i - 1]);
      }
      compute_forces(file);
      write_c3d(folder_.path() / "b.c3d", file);
      return true;
    } catch (const InputError& error) {
      EXPECT_FALSE(error.parts().problem.empty());
      EXPECT_EQ(error.where().file.find(folder_.path().string()), 0u);
      return false;
    }
  }

  const TemporaryFolder folder_;
};

TEST_F(C3dRobustness, FilesCutAnywhereAreRefusedOrRead) {
  std::mt19937 random(1);
  for (const std::string& name : kFiles) {
    SCOPED_TRACE(name);
    const std::string whole = content_of(kSamples / name);
    int refused = 0, read = 0;
    for (int i = 0; i < 50; ++i) {
      // Half of them in header and parameters.
      const std::size_t range =
          i % 2 == 0 ? std::min<std::size_t>(whole.size(), 8192) : whole.size();
      const std::size_t size = random() % range;
      ++(use(whole.substr(0, size)) ? read : refused);
    }
    EXPECT_GE(refused, 5);
    EXPECT_GE(read, 5);
  }
}

TEST_F(C3dRobustness, FlippedBytesAreRefusedOrRead) {
  std::mt19937 random(2);
  for (const std::string& name : kFiles) {
    SCOPED_TRACE(name);
    const std::string whole = content_of(kSamples / name);
    for (int i = 0; i < 100; ++i) {
      std::string bytes = whole;
      for (int k = 0; k < 4; ++k) {
        // Three of four in header and parameters, where a byte does more harm.
        const std::size_t range =
            k == 0 ? bytes.size() : std::min<std::size_t>(bytes.size(), k == 1 ? 512 : 6144);
        bytes[random() % range] = static_cast<char>(random());
      }
      use(bytes);
    }
  }
}

TEST_F(C3dRobustness, PiecesMakeTheWhole) {
  for (const std::string& name : kFiles) {
    SCOPED_TRACE(name);
    const C3dFile whole = read_c3d(kSamples / name);
    C3dReader reader(kSamples / name);
    C3dFrames frames;
    Eigen::Index row = 0;
    while (const int count = reader.read(7, frames)) {
      EXPECT_EQ(frames.first, row);
      EXPECT_TRUE(identical(frames.p_WM, whole.markers.p_WM.middleRows(row, count)));
      const Eigen::Index ratio = whole.layout.analog_ratio;
      EXPECT_TRUE(
          identical(frames.analog, whole.analog.values.middleRows(row * ratio, count * ratio)));
      row += count;
    }
    EXPECT_EQ(row, whole.markers.frame_count());
    EXPECT_EQ(reader.frames_left(), 0);
    EXPECT_EQ(to_text(reader.description().warnings), to_text(whole.warnings));
  }
}

}  // namespace
}  // namespace sinew
