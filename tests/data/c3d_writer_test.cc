#include "data/c3d_writer.h"

#include <gtest/gtest.h>

#include <cstdlib>

#include "tests/data/test_files.h"

namespace sinew {
namespace {

namespace fs = std::filesystem;

const fs::path kData = "../shared/data";

std::vector<fs::path> recordings() {
  std::vector<fs::path> paths;
  if (!fs::exists(kData)) return paths;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(kData)) {
    const std::string extension = entry.path().extension().string();
    if (extension == ".c3d" || extension == ".C3D") paths.push_back(entry.path());
  }
  return paths;
}

// 300 markers, 2 channels, 3 frames from number 70000 on: more than bytes and words count.
C3dFile large_numbers() {
  C3dFile file;
  MarkerTrajectories& markers = file.markers;
  markers.rate = 100.0;
  for (int i = 0; i < 300; ++i) markers.names.push_back("marker_" + std::to_string(i));
  markers.frame_numbers = {70000, 70001, 70002};
  markers.time = Eigen::Vector3d(0.0, 0.01, 0.02);
  markers.p_WM.resize(3, 900);
  for (Eigen::Index i = 0; i < markers.p_WM.size(); ++i) {
    markers.p_WM.data()[i] = 1e-3 * static_cast<float>(0.25 * static_cast<double>(i + 1));
  }
  markers.p_WM.row(1).segment<3>(30).setConstant(std::nan(""));
  file.analog = {.labels = {"Fx", "Fy"},
                 .units = {"N", "N"},
                 .rate = 200.0,
                 .samples_per_frame = 2,
                 .values = RowMatrix::Random(6, 2).cast<float>().cast<double>()};
  file.events = {
      {.time = 0.01, .label = "Foot Strike", .context = "Left", .subject = "", .description = ""},
      {.time = 0.02,
       .label = "END",
       .context = "",
       .subject = "",
       .description = "",
       .in_header = true}};
  return file;
}

TEST(C3dWriter, ReadsBackWhatItWrote) {
  const TemporaryFolder folder;
  const C3dFile file = large_numbers();
  write_c3d(folder.path() / "a.c3d", file);
  const C3dFile read = read_c3d(folder.path() / "a.c3d");
  EXPECT_EQ(to_text(read.warnings), "");
  EXPECT_EQ(read.markers.names, file.markers.names);
  EXPECT_EQ(read.markers.frame_numbers, file.markers.frame_numbers);
  EXPECT_TRUE(identical(read.markers.p_WM, file.markers.p_WM));
  EXPECT_TRUE(identical(read.analog.values, file.analog.values));
  EXPECT_EQ(read.analog.labels, file.analog.labels);
  ASSERT_EQ(read.events.size(), 2u);
  EXPECT_EQ(read.events[0].label, "END");
  EXPECT_EQ(read.events[1].label, "Foot Strike");
  EXPECT_EQ(read.events[1].context, "Left");
  // A real of seven digits, at 700 s.
  EXPECT_NEAR(read.events[1].time, 0.01, 1e-4);
  for (const char* name : {"USED", "SCALE", "RATE", "DATA_START", "FRAMES", "LABELS", "LABELS2",
                           "DESCRIPTIONS", "UNITS"}) {
    EXPECT_NE(find_parameter(read.groups, "POINT", name), nullptr) << name;
  }
}

TEST(C3dWriter, RoundsIntegersToHalfAStep) {
  const TemporaryFolder folder;
  const C3dFile file = large_numbers();
  write_c3d(folder.path() / "a.c3d", file, {.integers = true});
  const C3dFile read = read_c3d(folder.path() / "a.c3d");
  EXPECT_FALSE(read.layout.reals);
  const double step = read.layout.scale * read.metres_per_unit;
  EXPECT_LT(step, 675.0 * 1e-3 / 31999.0);
  for (Eigen::Index i = 0; i < file.markers.p_WM.size(); ++i) {
    const double a = file.markers.p_WM.data()[i], b = read.markers.p_WM.data()[i];
    ASSERT_EQ(std::isnan(a), std::isnan(b));
    if (std::isnan(a)) continue;
    ASSERT_NEAR(a, b, 0.51 * step);
  }
  EXPECT_LE((read.analog.values - file.analog.values).cwiseAbs().maxCoeff(), 0.51 / 31999.0);
}

TEST(C3dWriter, CutsLongDescriptions) {
  const TemporaryFolder folder;
  C3dFile file = large_numbers();
  C3dParameter note = C3dParameter::of_text("NOTE", "text");
  note.description = std::string(200, 'd');
  file.groups.push_back(
      {.id = 1, .name = "LAB", .description = std::string(300, 'g'), .parameters = {note}});
  write_c3d(folder.path() / "a.c3d", file);
  const C3dFile read = read_c3d(folder.path() / "a.c3d");
  EXPECT_EQ(to_text(read.warnings), "");
  EXPECT_EQ(read.markers.names, file.markers.names);
  const C3dGroup* group = find_group(read.groups, "LAB");
  ASSERT_NE(group, nullptr);
  EXPECT_EQ(group->description, std::string(127, 'g'));
  EXPECT_EQ(group->find("NOTE")->description, std::string(127, 'd'));
}

TEST(C3dWriter, KeepsMoreFramesThanAWordCounts) {
  const TemporaryFolder folder;
  C3dFile file;
  const int frames = 70001;
  file.markers.names = {"A"};
  file.markers.rate = 1000.0;
  file.markers.p_WM = RowMatrix::Constant(frames, 3, 1.0);
  for (int i = 0; i < frames; ++i) file.markers.frame_numbers.push_back(i + 1);
  file.markers.p_WM(frames - 1, 2) = 2.0;
  write_c3d(folder.path() / "a.c3d", file);
  const C3dFile read = read_c3d(folder.path() / "a.c3d");
  EXPECT_EQ(to_text(read.warnings), "");
  EXPECT_TRUE(identical(read.markers.p_WM, file.markers.p_WM));
  EXPECT_EQ(read.markers.frame_numbers, file.markers.frame_numbers);
}

TEST(C3dWriter, RepeatsItsBytesFromTheSecondTimeOn) {
  const std::vector<fs::path> paths = recordings();
  if (paths.empty()) GTEST_SKIP() << "needs the recordings in " << kData;
  const TemporaryFolder folder;
  for (const bool integers : {false, true}) {
    for (const fs::path& path : paths) {
      SCOPED_TRACE(path.string() + (integers ? " as integers" : " as reals"));
      const C3dFile original = read_c3d(path);
      const auto a = folder.path() / "a.c3d", b = folder.path() / "b.c3d",
                 c = folder.path() / "c.c3d";
      write_c3d(a, original, {.integers = integers});
      const C3dFile first = read_c3d(a);
      write_c3d(b, first, {.integers = integers});
      write_c3d(c, read_c3d(b), {.integers = integers});
      EXPECT_EQ(content_of(b) == content_of(c), true);
      EXPECT_EQ(original.markers.names, first.markers.names);
      EXPECT_EQ(original.computed.labels, first.computed.labels);
      EXPECT_EQ(original.markers.frame_numbers.front(), first.markers.frame_numbers.front());
      EXPECT_EQ(original.events.size(), first.events.size());
      if (integers || !original.layout.reals) continue;
      // Positions of files of reals keep every bit.
      EXPECT_TRUE(identical(original.markers.p_WM, first.markers.p_WM));
    }
  }
}

TEST(C3dWriter, SaysWhatItCannotWrite) {
  const TemporaryFolder folder;
  const auto message = [&](const C3dFile& file) {
    return error_of(folder.path(), [&] { write_c3d(folder.path() / "a.c3d", file); });
  };
  C3dFile file = large_numbers();
  file.markers.names.pop_back();
  EXPECT_EQ(message(file),
            "a.c3d: write_c3d got positions of the wrong size; expected 3 × 897, found 3 × 900");
  file = large_numbers();
  file.markers.rate = 0.0;
  EXPECT_EQ(message(file), "a.c3d: write_c3d got no rate; expected a rate above 0 Hz, found 0");
  file = large_numbers();
  file.analog.values.conservativeResize(5, 2);
  EXPECT_EQ(message(file),
            "a.c3d: write_c3d got samples of the wrong size; expected 6 × 2, found 5 × 2");
  file = large_numbers();
  file.metres_per_unit = 1.0;
  EXPECT_EQ(message(file),
            "a.c3d: write_c3d got a unit that is not metres_per_unit; expected the name of 1 m, "
            "found mm. Set C3dFile::unit.");
}

}  // namespace
}  // namespace sinew
