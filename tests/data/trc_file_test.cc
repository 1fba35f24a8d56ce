#include "data/trc_file.h"

#include <gtest/gtest.h>

#include <limits>
#include <random>

#include "tests/data/test_files.h"

namespace sinew {
namespace {

using Strings = std::vector<std::string>;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

// A file with `markers` promised and, from the line of names on, `rest`.
std::string trc(const std::string& rest, int frames, int markers, const std::string& units = "mm") {
  return "PathFileType\t4\t(X/Y/Z)\tt.trc\nDataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\t"
         "OrigDataRate\tOrigDataStartFrame\tOrigNumFrames\n100\t100\t" +
         std::to_string(frames) + "\t" + std::to_string(markers) + "\t" + units + "\t100\t1\t2\n" +
         rest;
}

const std::string kNames = "Frame#\tTime\tA\t\t\tB.1\t\t\n\t\tX1\tY1\tZ1\tX2\tY2\tZ2\n";

MarkerFile read_text(const std::string& content) {
  const TemporaryFolder folder;
  return read_trc(folder.write("t.trc", content));
}

TEST(ReadTrc, ConvertsEveryUnitToMetres) {
  for (const auto& [units, text] : {std::pair{"mm", "1500"},
                                    {"cm", "150"},
                                    {"m", "1.5"},
                                    {"MM", "1.5e3"},
                                    {"Meters", "1.5"},
                                    {"millimetres", "1500"}}) {
    const MarkerFile file = read_text(trc(
        kNames + "\n1\t0\t" + text + "\t0\t0\t1\t2\t3\n2\t0.01\t1\t2\t3\t4\t5\t6\n", 2, 2, units));
    EXPECT_EQ(file.markers.position(0, 0), Eigen::Vector3d(1.5, 0.0, 0.0)) << units;
    EXPECT_EQ(file.markers.rate, 100.0);
    EXPECT_EQ(file.markers.names, (Strings{"A", "B.1"}));
    EXPECT_TRUE(file.warnings.empty()) << to_text(file.warnings);
  }
}

TEST(ReadTrc, TakesBlankNaNAndZeroForMissing) {
  const MarkerFile file = read_text(trc(kNames + "10\t0\t\t\t\t1\t2\t3\n"
                                                 "11\t0.01\tNaN\tnan\tNAN\t 0 \t0.0\t-0\n"
                                                 "12\t0.02\t1\t\t3\t0\t0\t1\n"
                                                 "13\t0.03\t1\t2\t3\t\t\t\t\t\n",
                                        4, 2));
  EXPECT_EQ(file.markers.frame_numbers, (std::vector<int>{10, 11, 12, 13}));
  RowMatrix expected(4, 6);
  expected << kNaN, kNaN, kNaN, 0.001, 0.002, 0.003,  //
      kNaN, kNaN, kNaN, kNaN, kNaN, kNaN,             //
      kNaN, kNaN, kNaN, 0.0, 0.0, 0.001,              //
      0.001, 0.002, 0.003, kNaN, kNaN, kNaN;
  EXPECT_TRUE(identical(file.markers.p_WM, expected)) << file.markers.p_WM;
  EXPECT_EQ(to_text(file.warnings),
            "7: 1 marker samples at exactly 0, 0, 0 were read as not measured\n"
            "8: 1 marker samples lack one or two coordinates and were read as not measured\n");
}

TEST(ReadTrc, TakesAnyNumberOfBlankLinesAndEveryLineEnding) {
  const std::string rows = "1\t0\t1\t2\t3\t4\t5\t6\n2\t0.01\t1\t2\t3\t4\t5\t6\n";
  const MarkerFile none = read_text(trc(kNames + rows, 2, 2));
  for (std::string content :
       {trc(kNames + "\n\n\t\t\n" + rows + "\n\t\n", 2, 2),
        trc(kNames + "1\t0\t1\t2\t3\t4\t5\t6\n\n2\t0.01\t1\t2\t3\t4\t5\t6", 2, 2)}) {
    for (const char* ending : {"\r\n", "\r"}) {
      std::string other;
      for (const char c : content) other += c == '\n' ? ending : std::string(1, c);
      EXPECT_EQ(read_text(other).markers, none.markers);
    }
    EXPECT_EQ(read_text(content).markers, none.markers);
  }
}

TEST(ReadTrc, ReadsHeadersPaddedWithBlanksAndTabs) {
  const MarkerFile file = read_text(
      "PathFileType  4\t(X/Y/Z) C:\\a b\\\nDataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\n"
      "  100.0\t\t  100.0\t\t    1\t\t     2\t\t mm\t\t\n" +
      kNames + "1\t0\t1\t2\t3\t4\t5\t6\t\t\n");
  EXPECT_EQ(file.markers.rate, 100.0);
  EXPECT_TRUE(file.warnings.empty()) << to_text(file.warnings);
}

TEST(ReadTrc, MatchesNamesThatLeaveTwoCellsToAMarker) {
  const MarkerFile file =
      read_text(trc("Frame#\tTime\t\tA b\t\tB\n\t\t\tX1\tY1\tZ1\tX2\tY2\tZ2\n\n"
                    "1\t0\t1\t2\t3\t4\t5\t6\n",
                    1, 2));
  EXPECT_EQ(file.markers.names, (Strings{"A b", "B"}));
  EXPECT_EQ(file.markers.position(0, 1), Eigen::Vector3d(0.004, 0.005, 0.006));
}

TEST(ReadTrc, ReadsCellsBetweenBlanksWhereNoneIsBlank) {
  const MarkerFile file =
      read_text(trc("Frame# Time A B\nX1 Y1 Z1 X2 Y2 Z2\n"
                    "1 0.00  1 2 3  4 5 6\n2 0.01 1 2 3 NaN NaN NaN\n",
                    2, 2));
  EXPECT_EQ(file.markers.names, (Strings{"A", "B"}));
  EXPECT_TRUE(std::isnan(file.markers.p_WM(1, 3)));
}

TEST(ReadTrc, WarnsOfWhatTheHeaderGetsWrong) {
  const MarkerFile file =
      read_text(trc(kNames + "1\t0\t1\t2\t3\t4\t5\t6\n2\t0.02\t1\t2\t3\t4\t5\t6\n", 323, 40));
  EXPECT_EQ(to_text(file.warnings),
            "3: the header promises NumFrames=323, the file has 2 frames; all of them were read\n"
            "3: the header promises NumMarkers=40, the file has 2 markers; all of them were read\n"
            "3: the header's DataRate is 100 Hz, the times step at 50 Hz\n");
}

TEST(ReadTrc, NamesUnnamedAndRepeatedMarkers) {
  const MarkerFile file =
      read_text(trc("Frame#\tTime\tA\t\t\t\t\t\tA\t\t\tA_2\n"
                    "\t\tX1\tY1\tZ1\tX2\tY2\tZ2\tX3\tY3\tZ3\tX4\tY4\tZ4\n"
                    "1\t0\t1\t1\t1\t2\t2\t2\t3\t3\t3\t4\t4\t4\n",
                    1, 4));
  EXPECT_EQ(file.markers.names, (Strings{"A", "unnamed_1", "A_3", "A_2"}));
  EXPECT_EQ(to_text(file.warnings),
            "4: 1 markers have no name; they are called unnamed_1, unnamed_2, ...\n"
            "4: marker 'A' appears again; this one is called 'A_3'\n");
  EXPECT_EQ(file.markers.find_marker("A_3"), 2);
  EXPECT_EQ(file.markers.find_marker("a"), -1);
}

TEST(ReadTrc, LeavesOutNamesWithoutCoordinates) {
  const MarkerFile file =
      read_text(trc("Frame#\tTime\tA\t\t\tB\t\t\tC\n\t\tX1\tY1\tZ1\tX2\tY2\tZ2\n"
                    "1\t0\t1\t1\t1\t2\t2\t2\n",
                    1, 3));
  EXPECT_EQ(file.markers.names, (Strings{"A", "B"}));
  EXPECT_EQ(to_text(file.warnings),
            "4: 3 names for 2 triples of coordinates; the last names were left out\n"
            "3: the header promises NumMarkers=3, the file has 2 markers; all of them were read\n");
}

TEST(ReadTrc, ReadsFilesWithoutCoordinateLabels) {
  const MarkerFile file =
      read_text(trc("Frame#\tTime\tA\t\t\tB\t\t\n1\t0\t1\t1\t1\t2\t2\t2\n", 1, 2));
  EXPECT_EQ(file.markers.names, (Strings{"A", "B"}));
}

TEST(ReadTrc, CompletesRowsThatEndEarlyAtAWholeMarker) {
  const MarkerFile file =
      read_text(trc(kNames + "1\t0\t1\t2\t3\n2\t0.01\n3\t0.02\t1\t2\t3\t4\t5\t6\n", 3, 2));
  EXPECT_TRUE(std::isnan(file.markers.p_WM(0, 5)));
  EXPECT_TRUE(file.markers.p_WM.row(1).array().isNaN().all());
  EXPECT_EQ(to_text(file.warnings),
            "6: 2 rows end early; their last markers were read as not measured\n");
}

TEST(ReadTrc, BoundsMemoryByTheSizeOfTheFile) {
  // 20 thousand names and 20 thousand rows of two cells would be 1.2e9 numbers.
  std::string names = "Frame#\tTime", rows;
  for (int i = 0; i < 20'000; ++i) {
    names += "\tm" + std::to_string(i) + "\t\t";
    rows += std::to_string(i) + "\t" + std::to_string(i) + "\n";
  }
  const TemporaryFolder folder;
  const auto path = folder.write("t.trc", trc(names + "\n" + rows, 1, 1));
  EXPECT_EQ(
      error_of(folder.path(), [&] { read_trc(path); }),
      "t.trc:38: a row does not fit the markers; expected 60002 values: frame, time and three "
      "for each of 20000 markers, found 2. Correct the row or the header.");
}

TEST(WriteTrc, RoundTripsEveryNumberExactly) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> metres(-3.0, 3.0);
  MarkerTrajectories markers;
  markers.names = {"R.ASIS", "V Sacral", "C7"};
  markers.rate = 119.88012;
  markers.time = Eigen::VectorXd::LinSpaced(2000, 0.1, 0.1 + 1999 / 119.88012);
  markers.p_WM.resize(2000, 9);
  for (double& value : markers.p_WM.reshaped()) value = metres(random);
  for (int i = 0; i < 2000; ++i) markers.frame_numbers.push_back(389 + i);
  markers.p_WM.block<5, 3>(100, 6).setConstant(kNaN);
  const TemporaryFolder folder;
  write_trc(folder.path() / "out.trc", markers);
  const MarkerFile back = read_trc(folder.path() / "out.trc");
  EXPECT_TRUE(back.warnings.empty()) << to_text(back.warnings);
  EXPECT_EQ(back.markers.names, markers.names);
  EXPECT_EQ(back.markers.rate, markers.rate);
  EXPECT_EQ(back.markers.frame_numbers, markers.frame_numbers);
  EXPECT_TRUE(identical(back.markers.time, markers.time));
  EXPECT_TRUE(identical(back.markers.p_WM, markers.p_WM));
}

TEST(WriteTrc, WritesMillimetresAndBlanks) {
  MarkerTrajectories markers;
  markers.names = {"A", "B"};
  markers.rate = 100.0;
  markers.frame_numbers = {7};
  markers.time = Eigen::VectorXd::Constant(1, 0.06);
  markers.p_WM.resize(1, 6);
  markers.p_WM << 0.1, -2.0, 1e-9, kNaN, kNaN, kNaN;
  const TemporaryFolder folder;
  write_trc(folder.path() / "out.trc", markers);
  EXPECT_EQ(
      content_of(folder.path() / "out.trc"),
      "PathFileType\t4\t(X/Y/Z)\tout.trc\nDataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\t"
      "OrigDataRate\tOrigDataStartFrame\tOrigNumFrames\n100\t100\t1\t2\tmm\t100\t7\t1\n"
      "Frame#\tTime\tA\t\t\tB\t\t\n\t\tX1\tY1\tZ1\tX2\tY2\tZ2\n\n"
      "7\t0.06\t100\t-2000\t1e-06\t\t\t\t\n");
}

TEST(WriteTrc, RefusesTrajectoriesThatNoFileCanHold) {
  MarkerTrajectories markers;
  markers.names = {"A\nB"};
  markers.p_WM.resize(0, 3);
  const TemporaryFolder folder;
  const auto error = [&] {
    return error_of(folder.path(), [&] { write_trc(folder.path() / "x.trc", markers); });
  };
  EXPECT_EQ(error(),
            "x.trc: write_trc cannot write this marker name; expected a name without tabs "
            "and line breaks, found A\\x0aB. Rename the marker.");
  markers.frame_numbers = {1};
  EXPECT_EQ(error(),
            "x.trc: write_trc got trajectories whose sizes disagree; expected 0 frames, "
            "0 × 3 positions, found 1 frame numbers, 0 × 3 positions");
}

}  // namespace
}  // namespace sinew
