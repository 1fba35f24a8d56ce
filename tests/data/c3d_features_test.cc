// What C3D files of laboratories do, each in all byte orders, from bytes that write_c3d has no part
// in. Files that contradict themselves are in c3d_malformed_test.cc.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/LU>

#include "data/c3d_file.h"
#include "tests/data/raw_c3d.h"
#include "tests/data/test_files.h"

namespace sinew {
namespace {

class C3dFeatures : public ::testing::TestWithParam<C3dProcessor> {
 protected:
  C3dFile read(const RawC3d& raw) const { return read_c3d(folder_.write("a.c3d", raw.bytes())); }

  // Points A and B in millimetres, as many frames as there are `fourth` numbers of A.
  RawC3d two_points(const std::vector<double>& fourth, float scale = -1.0f) const {
    RawC3d raw(GetParam());
    raw.points = 2;
    raw.scale = scale;
    raw.last_frame = static_cast<int>(fourth.size());
    raw.group(1, "POINT").integers(1, "USED", {2}).reals(1, "SCALE", {scale});
    raw.reals(1, "RATE", {100}).integers(1, "FRAMES", {raw.last_frame});
    raw.texts(1, "LABELS", {"A", "B"}, 4).texts(1, "UNITS", {"mm"}, 2);
    for (const double number : fourth) raw.data({1000, -200, 30, number, 10, 20, 4000, 0});
    return raw;
  }

  const TemporaryFolder folder_;
};

INSTANTIATE_TEST_SUITE_P(ByteOrders, C3dFeatures,
                         ::testing::Values(C3dProcessor::kIntel, C3dProcessor::kDec,
                                           C3dProcessor::kMips),
                         [](const auto& info) {
                           return fmt::format("Processor{}", static_cast<int>(info.param));
                         });

TEST_P(C3dFeatures, AFileNeedsNoGroupButPoint) {
  const C3dFile file = read(two_points({0, 0, 0}));
  EXPECT_EQ(to_text(file.warnings), "");
  EXPECT_EQ(file.header.processor, GetParam());
  EXPECT_EQ(file.markers.names, (std::vector<std::string>{"A", "B"}));
  EXPECT_EQ(file.markers.position(2, 0), Eigen::Vector3d(1000 * 1e-3, -200 * 1e-3, 30 * 1e-3));
  EXPECT_EQ(file.analog.channel_count(), 0);
  EXPECT_FALSE(file.screen);
  EXPECT_TRUE(file.events.empty());
}

TEST_P(C3dFeatures, GroupsMayFollowTheirParametersInAnyOrder) {
  RawC3d raw(GetParam());
  raw.points = 1;
  raw.last_frame = 2;
  raw.texts(9, "UNITS", {"m"}, 1).integers(9, "USED", {1}).reals(4, "NOISE", {0.5f});
  raw.group(4, "LAB").texts(9, "LABELS", {"A"}, 1).group(9, "POINT").reals(9, "RATE", {100});
  raw.reals(9, "SCALE", {-1}).integers(9, "FRAMES", {2});
  raw.data({1, 2, 3, 0, 4, 5, 6, 0});
  const C3dFile file = read(raw);
  EXPECT_EQ(file.markers.names, std::vector<std::string>{"A"});
  EXPECT_EQ(file.markers.position(1, 0), Eigen::Vector3d(4, 5, 6));
  EXPECT_EQ(find_number(file.groups, "LAB", "NOISE"), 0.5);
  EXPECT_EQ(find_parameter(file.groups, "LAB", "NOISE")->description, "of NOISE");
}

TEST_P(C3dFeatures, TheFourthNumberHoldsResidualAndCameras) {
  // Cameras 1, 2 and 4, five steps; no camera, made by a program; not measured; the seventh camera.
  const std::vector<double> fourth = {0x0b05, 0, -1, 0x40ff};
  for (const float scale : {0.125f, -0.125f}) {
    SCOPED_TRACE(scale);
    const C3dFile file = read(two_points(fourth, scale));
    EXPECT_EQ(file.layout.reals, scale < 0.0f);
    const double unit = scale < 0.0f ? 1e-3 : 0.125e-3;
    for (const int frame : {0, 1, 3}) {
      EXPECT_NEAR(file.markers.position(frame, 0).x(), 1000 * unit, 1e-12);
      EXPECT_NEAR(file.markers.position(frame, 0).y(), -200 * unit, 1e-12);
    }
    EXPECT_TRUE(file.markers.position(2, 0).array().isNaN().all());
    EXPECT_EQ(file.quality.cameras.col(0),
              (Eigen::Vector4i(0x0b, 0, 0, 0x40).cast<std::uint8_t>()));
    EXPECT_FLOAT_EQ(file.quality.residual(0, 0), 5 * 0.125e-3);
    EXPECT_EQ(file.quality.residual(1, 0), 0.0f);
    EXPECT_TRUE(std::isnan(file.quality.residual(2, 0)));
    EXPECT_FLOAT_EQ(file.quality.residual(3, 0), 255 * 0.125e-3);
  }
}

TEST_P(C3dFeatures, LabelsGoOnInNumberedParameters) {
  RawC3d raw(GetParam());
  raw.points = 600;
  raw.group(1, "POINT").integers(1, "USED", {600}).reals(1, "SCALE", {-1}).reals(1, "RATE", {100});
  raw.texts(1, "UNITS", {"mm"}, 2).integers(1, "FRAMES", {1});
  std::vector<std::string> all;
  for (int i = 0; i < 600; ++i) {
    all.push_back(fmt::format("m{}", i));
    raw.data({static_cast<double>(i + 1), 2, 3, 0});
  }
  const auto part = [&](int from, int to) {
    return std::vector<std::string>(all.begin() + from, all.begin() + to);
  };
  // The first with more room for a name than the others.
  raw.texts(1, "LABELS2", part(255, 510), 4).texts(1, "LABELS", part(0, 255), 6);
  raw.texts(1, "LABELS3", part(510, 600), 4);
  const C3dFile file = read(raw);
  EXPECT_EQ(file.markers.names, all);
  EXPECT_EQ(file.markers.position(0, 599), Eigen::Vector3d(600 * 1e-3, 2 * 1e-3, 3 * 1e-3));
}

TEST_P(C3dFeatures, MoreLabelsThanPointsAreLeftOut) {
  RawC3d raw(GetParam());
  raw.points = 1;
  raw.group(1, "POINT").integers(1, "USED", {1}).reals(1, "SCALE", {-1}).reals(1, "RATE", {100});
  raw.texts(1, "UNITS", {"mm"}, 2).texts(1, "LABELS", {"A", "B", "A"}, 4);
  raw.integers(1, "FRAMES", {1}).data({1, 2, 3, 0});
  const C3dFile file = read(raw);
  EXPECT_EQ(file.markers.names, std::vector<std::string>{"A"});
}

// One point of integers a frame; words cannot count the frames.
constexpr int kManyFrames = 66000;

RawC3d many_frames(C3dProcessor processor) {
  RawC3d raw(processor);
  raw.points = 1;
  raw.scale = 0.5f;
  raw.last_frame = 65535;
  raw.group(1, "POINT").integers(1, "USED", {1}).reals(1, "SCALE", {0.5f}).reals(1, "RATE", {100});
  raw.texts(1, "UNITS", {"mm"}, 2).texts(1, "LABELS", {"A"}, 1).integers(1, "FRAMES", {65535});
  for (int i = 0; i < kManyFrames; ++i) raw.data({static_cast<double>(i % 1000 + 1), 2, 3, 0});
  return raw;
}

void expect_many_frames(const C3dFile& file) {
  ASSERT_EQ(file.markers.frame_count(), kManyFrames);
  EXPECT_EQ(file.markers.frame_numbers.back(), kManyFrames);
  EXPECT_NEAR(file.markers.position(kManyFrames - 1, 0).x(), 0.5e-3 * 1000, 1e-15);
}

TEST_P(C3dFeatures, TrialFieldsCountMoreFramesThanAWord) {
  RawC3d raw = many_frames(GetParam());
  raw.group(2, "TRIAL").integers(2, "ACTUAL_START_FIELD", {1, 0});
  raw.integers(2, "ACTUAL_END_FIELD", {kManyFrames & 0xffff, kManyFrames >> 16});
  expect_many_frames(read(raw));
}

TEST_P(C3dFeatures, LongFramesCountMoreFramesThanAWord) {
  RawC3d raw = many_frames(GetParam());
  raw.reals(1, "LONG_FRAMES", {kManyFrames});
  expect_many_frames(read(raw));
}

TEST_P(C3dFeatures, ScreenAxesSayWhichWayIsUp) {
  RawC3d raw = two_points({0});
  raw.texts(1, "X_SCREEN", {"-Y"}, 2).texts(1, "Y_SCREEN", {"+Z"}, 2);
  const C3dFile file = read(raw);
  ASSERT_TRUE(file.screen);
  EXPECT_EQ(file.screen->x, -Eigen::Vector3d::UnitY());
  EXPECT_EQ(file.screen->y, Eigen::Vector3d::UnitZ());
  const auto R = rotation_to_y_up(file);
  ASSERT_TRUE(R);
  EXPECT_EQ(*R * Eigen::Vector3d::UnitZ(), Eigen::Vector3d::UnitY());
  EXPECT_EQ(*R * -Eigen::Vector3d::UnitY(), Eigen::Vector3d::UnitX());
  EXPECT_EQ(R->determinant(), 1.0);
}

// Two channels, three samples a frame, two frames of one point of integers.
RawC3d samples(C3dProcessor processor, const std::vector<double>& values) {
  RawC3d raw(processor);
  raw.points = 1;
  raw.scale = 0.5f;
  raw.last_frame = 2;
  raw.samples_per_frame = 6;
  raw.ratio = 3;
  raw.group(1, "POINT").integers(1, "USED", {1}).reals(1, "SCALE", {0.5f}).reals(1, "RATE", {50});
  raw.rate = 50;
  raw.texts(1, "UNITS", {"mm"}, 2).texts(1, "LABELS", {"A"}, 1).integers(1, "FRAMES", {2});
  raw.group(2, "ANALOG").integers(2, "USED", {2}).reals(2, "RATE", {150});
  raw.texts(2, "LABELS", {"Fz", "EMG"}, 4).texts(2, "UNITS", {"N", "mV"}, 2);
  raw.reals(2, "GEN_SCALE", {0.5f});
  for (std::size_t i = 0; i < values.size(); i += 6) {
    raw.data({1, 2, 3, 0});
    raw.data({values.begin() + static_cast<std::ptrdiff_t>(i),
              values.begin() + static_cast<std::ptrdiff_t>(i) + 6});
  }
  return raw;
}

TEST_P(C3dFeatures, SamplesHaveScaleOffsetAndRate) {
  RawC3d raw = samples(GetParam(), {100, -7, 101, -6, 102, -5, 103, -4, 104, -3, 105, -2});
  raw.reals(2, "SCALE", {-0.25f, 4}).integers(2, "OFFSET", {90, -10});
  const C3dAnalog analog = read(raw).analog;
  EXPECT_EQ(analog.rate, 150.0);
  EXPECT_EQ(analog.samples_per_frame, 3);
  EXPECT_EQ(analog.labels, (std::vector<std::string>{"Fz", "EMG"}));
  EXPECT_EQ(analog.units, (std::vector<std::string>{"N", "mV"}));
  for (int i = 0; i < 6; ++i) {
    EXPECT_EQ(analog.values(i, 0), (100 + i - 90) * 0.5 * -0.25) << i;
    EXPECT_EQ(analog.values(i, 1), (-7 + i + 10) * 0.5 * 4) << i;
  }
}

TEST_P(C3dFeatures, ConvertersOf12And16BitsCountFromZero) {
  RawC3d raw = samples(GetParam(), {0, 2048, 4095, 2047, 2048, 0, 1, 2, 3, 4, 5, 6});
  raw.reals(2, "SCALE", {1, 1}).integers(2, "OFFSET", {2048, 2048});
  raw.texts(2, "FORMAT", {"UNSIGNED"}, 8).integers(2, "BITS", {12});
  C3dAnalog analog = read(raw).analog;
  EXPECT_EQ(analog.values(0, 0), -1024.0);
  EXPECT_EQ(analog.values(1, 0), 0.5 * (4095 - 2048));
  EXPECT_EQ(analog.values(1, 1), -0.5);

  RawC3d wide = samples(GetParam(), {0, 32768, 65535, 32767, 40000, 0, 1, 2, 3, 4, 5, 6});
  wide.reals(2, "SCALE", {1, 1}).integers(2, "OFFSET", {32768, 0});
  wide.texts(2, "FORMAT", {"UNSIGNED"}, 8).integers(2, "BITS", {16});
  analog = read(wide).analog;
  EXPECT_EQ(analog.values(0, 0), -0.5 * 32768);
  EXPECT_EQ(analog.values(1, 0), 0.5 * 32767);
  EXPECT_EQ(analog.values(0, 1), 0.5 * 32768);
  EXPECT_EQ(analog.values(2, 0), 0.5 * (40000 - 32768));
}

TEST_P(C3dFeatures, EventsCountMinutesAndSecondsFromFrameOne) {
  RawC3d raw = two_points({0, 0, 0});
  raw.first_frame = 101;
  raw.last_frame = 103;
  raw.group(5, "EVENT").integers(5, "USED", {2}).reals(5, "TIMES", {0, 1.01f, 1, 2.5f}, {2, 2});
  raw.texts(5, "LABELS", {"Foot Strike", "Foot Off"}, 16)
      .texts(5, "CONTEXTS", {"Left", "Right"}, 8);
  raw.texts(5, "SUBJECTS", {"Bob", ""}, 4);
  const C3dFile file = read(raw);
  ASSERT_EQ(file.events.size(), 2u);
  EXPECT_NEAR(file.events[0].time, 0.01, 1e-7);
  EXPECT_EQ(file.events[0].label, "Foot Strike");
  EXPECT_EQ(file.events[0].context, "Left");
  EXPECT_EQ(file.events[0].subject, "Bob");
  EXPECT_NEAR(file.events[1].time, 61.5, 1e-6);
  EXPECT_EQ(file.events[1].context, "Right");
  EXPECT_EQ(file.markers.frame_numbers.front(), 101);
}

TEST_P(C3dFeatures, ComputedTrajectoriesAreNoMarkers) {
  RawC3d raw = two_points({0, -1});
  raw.texts(1, "ANGLES", {"B"}, 4).texts(1, "ANGLE_UNITS", {"deg"}, 3);
  const C3dFile file = read(raw);
  EXPECT_EQ(file.markers.names, std::vector<std::string>{"A"});
  EXPECT_EQ(file.computed.labels, std::vector<std::string>{"B"});
  EXPECT_EQ(file.computed.kinds, std::vector<std::string>{"ANGLES"});
  EXPECT_EQ(file.computed.units, std::vector<std::string>{"deg"});
  EXPECT_EQ(file.computed.values(0, 2), 4000.0);  // in its own unit
}

}  // namespace
}  // namespace sinew
