#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <regex>

#include "data/c3d_file.h"
#include "data/force_platform.h"
#include "data/storage_file.h"
#include "data/trc_file.h"
#include "tests/data/test_files.h"

namespace sinew {
namespace {

namespace fs = std::filesystem;

const fs::path kData = "../shared/data";
const fs::path kSamples = kData / "c3d.org";

class C3dRecordings : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!fs::exists(kData / "INDEX.md")) GTEST_SKIP() << "needs the recordings in " << kData;
  }
};

// What the index of the recordings says about a file; it was made from the bytes by another
// program.
struct Figures {
  std::string path;
  std::string format;  // "DEC/int"
  int points = 0, frames = 0;
  double rate = 0.0;
  int channels = 0;
  double analog_rate = 0.0;
  int first_frame = 1;
  std::vector<double> extent;  // low and high of x, y, z in the file's unit; or none
};

std::optional<Figures> parse_figures(const std::string& line) {
  static const std::regex kStart(
      R"(^\| `([^`]+\.[cC]3[dD])` \| \d+ \| \*\*([^*]+)\*\* (\d+) pts, (\d+) frames @([0-9.]+) Hz)");
  static const std::regex kAnalog(R"(analog (\d+) ch @([0-9.]+) Hz)");
  static const std::regex kFirst(R"(first frame (\d+))");
  static const std::regex kExtent(
      R"(extent X\[([-0-9.e]+),([-0-9.e]+)\] Y\[([-0-9.e]+),([-0-9.e]+)\] Z\[([-0-9.e]+),([-0-9.e]+)\])");
  std::smatch m;
  if (!std::regex_search(line, m, kStart)) return std::nullopt;
  Figures figures;
  figures.path = m[1];
  figures.format = m[2];
  figures.points = std::stoi(m[3]);
  figures.frames = std::stoi(m[4]);
  figures.rate = std::stod(m[5]);
  if (std::regex_search(line, m, kAnalog)) {
    figures.channels = std::stoi(m[1]);
    figures.analog_rate = std::stod(m[2]);
  }
  if (std::regex_search(line, m, kFirst)) figures.first_frame = std::stoi(m[1]);
  if (std::regex_search(line, m, kExtent)) {
    for (std::size_t i = 1; i < m.size(); ++i) figures.extent.push_back(std::stod(m[i]));
  }
  return figures;
}

std::vector<Figures> read_index() {
  std::ifstream index(kData / "INDEX.md");
  std::vector<Figures> all;
  for (std::string line; std::getline(index, line);) {
    if (auto figures = parse_figures(line)) all.push_back(std::move(*figures));
  }
  return all;
}

std::string format_of(const C3dFile& file) {
  const char* processor = file.header.processor == C3dProcessor::kIntel ? "Intel"
                          : file.header.processor == C3dProcessor::kDec ? "DEC"
                                                                        : "SGI/MIPS";
  return fmt::format("{}/{}", processor, file.layout.reals ? "float" : "int");
}

// Of all points, computed ones too, which the index does not tell apart.
std::vector<double> extent_of(const C3dFile& file) {
  std::vector<double> extent;
  for (int axis = 0; axis < 3; ++axis) {
    double low = HUGE_VAL, high = -HUGE_VAL;
    const auto visit = [&](const RowMatrix& values, double scale) {
      for (Eigen::Index i = 0; i < values.rows(); ++i) {
        for (Eigen::Index j = axis; j < values.cols(); j += 3) {
          if (std::isnan(values(i, j))) continue;
          low = std::min(low, values(i, j) * scale);
          high = std::max(high, values(i, j) * scale);
        }
      }
    };
    visit(file.markers.p_WM, 1.0 / file.metres_per_unit);
    visit(file.computed.values, 1.0);
    extent.push_back(low);
    extent.push_back(high);
  }
  return extent;
}

TEST_F(C3dRecordings, EveryFileHasTheFiguresOfTheIndex) {
  const std::vector<Figures> index = read_index();
  EXPECT_EQ(index.size(), 63u);
  for (const Figures& figures : index) {
    SCOPED_TRACE(figures.path);
    const C3dFile file = read_c3d(kData / figures.path);
    EXPECT_EQ(format_of(file), figures.format);
    EXPECT_EQ(file.markers.marker_count() + file.computed.count(), figures.points);
    EXPECT_EQ(file.markers.frame_count(), figures.frames);
    EXPECT_EQ(file.analog.values.rows(), figures.frames * file.layout.analog_ratio);
    EXPECT_NEAR(file.markers.rate, figures.rate, 1e-3 * figures.rate);
    EXPECT_EQ(file.analog.channel_count(), figures.channels);
    EXPECT_NEAR(file.analog.rate, figures.analog_rate, 1e-3 * figures.analog_rate);
    ASSERT_FALSE(file.markers.frame_numbers.empty());
    // The index names a first frame only where it is odd.
    EXPECT_EQ(file.markers.frame_numbers.front(), figures.first_frame);
    if (figures.extent.empty()) continue;
    const std::vector<double> extent = extent_of(file);
    for (std::size_t i = 0; i < 6; ++i) {  // printed to four digits
      EXPECT_NEAR(extent[i], figures.extent[i], 6e-4 * std::abs(figures.extent[i])) << i;
    }
  }
}

// Largest difference; where exactly one is missing that counts as infinite.
double difference(const RowMatrix& a, const RowMatrix& b) {
  if (a.rows() != b.rows() || a.cols() != b.cols()) return HUGE_VAL;
  double largest = 0.0;
  for (Eigen::Index i = 0; i < a.size(); ++i) {
    const double x = a.data()[i], y = b.data()[i];
    if (std::isnan(x) && std::isnan(y)) continue;
    if (std::isnan(x) || std::isnan(y)) return HUGE_VAL;
    largest = std::max(largest, std::abs(x - y));
  }
  return largest;
}

void expect_same(const C3dFile& a, const C3dFile& b, double tolerance, double analog_tolerance) {
  EXPECT_EQ(a.markers.names, b.markers.names);
  EXPECT_LE(difference(a.markers.p_WM, b.markers.p_WM), tolerance);
  EXPECT_LE(difference(a.analog.values, b.analog.values), analog_tolerance);
  EXPECT_EQ(a.analog.labels, b.analog.labels);
}

TEST_F(C3dRecordings, ByteOrdersAndNumberFormatsAgree) {
  const C3dFile first = read_c3d(kSamples / "sample_01/Eb015pi.c3d");
  for (const char* name : {"pr", "si", "sr", "vi", "vr"}) {
    SCOPED_TRACE(name);
    const auto path = kSamples / ("sample_01/Eb015" + std::string(name) + ".c3d");
    expect_same(first, read_c3d(path), 1.1e-7, 0.0);
  }
  const double step = 0.2812e-3;  // of the integers [m]
  const C3dFile second = read_c3d(kSamples / "sample_02/pc_int.c3d");
  const C3dFile reals = read_c3d(kSamples / "sample_02/pc_real.c3d");
  expect_same(second, read_c3d(kSamples / "sample_02/sgi_int.c3d"), 0.0, 0.0);
  expect_same(reals, read_c3d(kSamples / "sample_02/dec_real.c3d"), 0.0, 0.0);
  expect_same(reals, read_c3d(kSamples / "sample_02/sgi_real.c3d"), 0.0, 0.0);
  expect_same(second, reals, step, 0.0);
  // Converted by another program, which rounds.
  expect_same(second, read_c3d(kSamples / "sample_02/dec_int.c3d"), step, 0.0);
}

TEST_F(C3dRecordings, SamplesWithoutSignAreCenteredByTheirOffset) {
  // Converters of 16 bits at rest; some channels have 32768 as offset, -32768 as a signed word.
  const C3dFile file = read_c3d(kSamples / "sample_07/16bitanalog.c3d");
  EXPECT_LE(file.analog.values.rightCols(8).cwiseAbs().maxCoeff(), 50.0);
}

TEST_F(C3dRecordings, MovedBlocksChangeNothing) {
  const C3dFile first = read_c3d(kSamples / "sample_01/Eb015pi.c3d");
  for (const char* name : {"A", "B", "C", "D"}) {
    SCOPED_TRACE(name);
    const C3dFile moved = read_c3d(kSamples / ("sample_08/TEST" + std::string(name) + "PI.c3d"));
    expect_same(first, moved, 0.0, 0.0);
    EXPECT_EQ(first.events, moved.events);
    EXPECT_EQ(moved.warnings.size(), 0u) << to_text(moved.warnings);
  }
}

const fs::path kPublished = kData / "opensim-core/OpenSim/Common/Test";

C3dFile read_walking2() {
  return read_c3d(kData / "opensim-core/OpenSim/Tests/shared/walking2.c3d");
}

TEST_F(C3dRecordings, MarkersAgreeWithOpenSimsToPrintedDigits) {
  const MarkerTrajectories markers = read_walking2().markers;
  const MarkerTrajectories published = read_trc(kPublished / "std_walking2_markers.trc").markers;
  EXPECT_EQ(markers.names, published.names);
  EXPECT_EQ(published.frame_count(), 126);
  for (int i = 0; i < published.frame_count(); ++i) {
    // Every tenth frame, and the last.
    const auto frame = static_cast<int>(std::lround(published.time[i] * published.rate));
    ASSERT_LT(frame, markers.frame_count());
    for (int k = 0; k < 3 * markers.marker_count(); ++k) {
      const double ours = markers.p_WM(frame, k), theirs = published.p_WM(i, k);
      ASSERT_EQ(std::isnan(ours), std::isnan(theirs)) << i << " " << k;
      if (std::isnan(ours)) continue;
      ASSERT_NEAR(ours, theirs, 5.01e-5 * std::abs(theirs)) << i << " " << k;  // five digits
    }
  }
}

TEST_F(C3dRecordings, AnalogAgreesWithOpenSimsToPrintedDigits) {
  const C3dAnalog analog = read_walking2().analog;
  const TimeTable published = read_storage(kPublished / "std_walking2_analog.sto").table;
  ASSERT_EQ(analog.labels.size(), published.labels.size());
  for (Eigen::Index i = 0; i < published.time.size(); ++i) {
    const auto sample = static_cast<Eigen::Index>(std::lround(published.time[i] * analog.rate));
    for (Eigen::Index k = 0; k < published.values.cols(); ++k) {
      const double theirs = published.values(i, k);  // 16 digits
      ASSERT_NEAR(analog.values(sample, k), theirs, 1e-14 * std::abs(theirs)) << i << " " << k;
    }
  }
}

// Columns f1_1 ... p1_1 ... m1_1 ... of platform 1, and of 2; N, mm, N mm.
void expect_forces(const std::string& name, double threshold, bool at_center) {
  const C3dFile file = read_walking2();
  const ForcePlatforms platforms = compute_forces(file, {.threshold = threshold});
  const TimeTable published = read_storage(kPublished / name).table;
  ASSERT_EQ(platforms.recordings.size(), 2u);
  ASSERT_EQ(published.time.size(), 101);
  for (Eigen::Index i = 0; i < published.time.size(); ++i) {
    for (Eigen::Index k = 0; k < 2; ++k) {
      const ForcePlatformRecording& ours = platforms.recordings[static_cast<std::size_t>(k)];
      const auto sample = static_cast<Eigen::Index>(std::lround(published.time[i] * ours.rate));
      Eigen::RowVector3d p = ours.platform.p_WC;
      if (at_center) p = ours.center.row(sample);
      const auto& moments = at_center ? ours.free_moment : ours.moment;
      Eigen::Matrix<double, 1, 9> row;
      row << ours.force.row(sample), 1e3 * p, 1e3 * moments.row(sample);
      for (Eigen::Index c = 0; c < 9; ++c) {
        const double theirs = published.values(i, 9 * k + c);
        // Ten digits, eight of them decimals.
        ASSERT_NEAR(row[c], theirs, 1e-9 * std::abs(theirs) + 6e-9) << i << " " << k << " " << c;
      }
    }
  }
}

TEST_F(C3dRecordings, ForcesAgreeWithOpenSimsToPrintedDigits) {
  expect_forces("std_walking2_grfs.sto", 20.0, false);
}

TEST_F(C3dRecordings, CentersOfPressureAgreeWithOpenSimsToPrintedDigits) {
  expect_forces("std_cop_walking2_grfs.sto", 0.0, true);
}

// Samples in which both platforms are loaded by more than 50 N.
void expect_similar(const fs::path& a, const fs::path& b, double force_tolerance,
                    double center_tolerance) {
  const ForcePlatforms first = compute_forces(read_c3d(a)), second = compute_forces(read_c3d(b));
  ASSERT_EQ(first.recordings.size(), second.recordings.size());
  for (std::size_t k = 0; k < first.recordings.size(); ++k) {
    const ForcePlatformRecording &x = first.recordings[k], &y = second.recordings[k];
    ASSERT_EQ(x.sample_count(), y.sample_count());
    double peak = 0.0, difference = 0.0, distance = 0.0;
    for (int i = 0; i < x.sample_count(); ++i) {
      peak = std::max(peak, x.force.row(i).norm());
      difference = std::max(difference, (x.force.row(i) - y.force.row(i)).norm());
      if (x.force(i, 2) < 50.0 || y.force(i, 2) < 50.0) continue;
      distance = std::max(distance, (x.center.row(i) - y.center.row(i)).norm());
    }
    ::testing::Test::RecordProperty(fmt::format("platform_{}_force_of_peak", k + 1),
                                    std::to_string(difference / peak));
    ::testing::Test::RecordProperty(fmt::format("platform_{}_center_mm", k + 1),
                                    std::to_string(1e3 * distance));
    EXPECT_GT(peak, 300.0);
    EXPECT_LE(difference, force_tolerance * peak) << k;
    EXPECT_LE(distance, center_tolerance) << k;
  }
}

TEST_F(C3dRecordings, PlatformsOfTypes2And4Agree) {
  // One file's scales are the calibration's diagonal, the other has all of it. The calibration
  // transposed would be off by half of the peak.
  expect_similar(kSamples / "sample_10/TYPE-2a.c3d", kSamples / "sample_06/newwalk.c3d", 0.005,
                 0.01);
  expect_similar(kSamples / "sample_10/TYPE-2.C3D", kSamples / "sample_10/TYPE-4.C3D", 0.03, 0.03);
}

TEST_F(C3dRecordings, ForcesOfEveryFileArePlausible) {
  int loaded = 0;
  for (const Figures& figures : read_index()) {
    SCOPED_TRACE(figures.path);
    const C3dFile file = read_c3d(kData / figures.path);
    for (const ForcePlatformRecording& recording : compute_forces(file).recordings) {
      const ForcePlatform& platform = recording.platform;
      if (!platform.usable() || !platform.has_moments) continue;
      int samples = 0, inside = 0;
      double up = 0.0;
      for (int i = 0; i < recording.sample_count(); ++i) {
        if (std::isnan(recording.center(i, 0))) continue;
        const Eigen::Vector3d p_WQ = recording.center.row(i);
        const Eigen::Vector3d p_CQ = platform.R_WP.transpose() * (p_WQ - platform.p_WC);
        const Eigen::Vector3d corner =
            platform.R_WP.transpose() * (platform.corners[0] - platform.p_WC);
        ++samples;
        inside += std::abs(p_CQ.x()) <= corner.x() && std::abs(p_CQ.y()) <= corner.y();
        up -= recording.force.row(i).dot(platform.R_WP.col(2).transpose());
      }
      if (samples < 10) continue;
      ++loaded;
      EXPECT_GE(inside, 0.95 * samples) << "platform " << platform.number;
      EXPECT_GT(up, 0.0) << "platform " << platform.number;
    }
  }
  EXPECT_GE(loaded, 60);
}

}  // namespace
}  // namespace sinew
