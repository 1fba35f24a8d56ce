#include "data/csv_file.h"

#include <gtest/gtest.h>

#include "data/marker_table.h"
#include "tests/data/test_files.h"

namespace sinew {
namespace {

TimeTableFile read_text(const TemporaryFolder& folder, const std::string& content) {
  return read_csv(folder.write("t.csv", content));
}

TEST(CsvFile, WhatIsWrittenIsReadBack) {
  TimeTable table;
  table.labels = {"plain", "with, comma", "with \"quotes\"", " blank at ends "};
  table.time = Eigen::Vector3d(0.0, 0.1, 1.0 / 3.0);
  table.values.resize(3, 4);
  table.values << 1.0 / 7.0, -2e-300, 3.0, 4.0, 5.0, std::nan(""), 7.0, 8.0, 9.0, 1e22, -0.0, 12.0;
  const TemporaryFolder folder;
  write_csv(folder.path() / "t.csv", table);
  EXPECT_TRUE(content_of(folder.path() / "t.csv")
                  .starts_with("time,plain,\"with, comma\",\"with \"\"quotes\"\"\",\" blank at "
                               "ends \"\n0,0.14285714285714285,"));
  const TimeTableFile back = read_csv(folder.path() / "t.csv");
  EXPECT_EQ(back.table.labels[1], table.labels[1]);
  EXPECT_EQ(back.table.labels[2], table.labels[2]);
  EXPECT_EQ(back.table.time, table.time);
  for (Eigen::Index i = 0; i < table.values.size(); ++i) {
    const double a = table.values.data()[i], b = back.table.values.data()[i];
    EXPECT_TRUE(a == b || (std::isnan(a) && std::isnan(b))) << i;
  }
  ASSERT_EQ(back.warnings.size(), 1u);
  EXPECT_EQ(back.warnings[0].text, "1 blank cells were read as NaN");
  EXPECT_EQ(back.warnings[0].at.line, 3);
}

TEST(CsvFile, SemicolonsGoWithDecimalCommas) {
  const TemporaryFolder folder;
  const TimeTable table =
      read_text(folder, "\xEF\xBB\xBFx;Time [s];y\r\n1,5;0;2\r\n\r\n-3;0,01;1e2\r\n").table;
  EXPECT_EQ(table.labels, (std::vector<std::string>{"x", "y"}));
  EXPECT_EQ(table.time, Eigen::Vector2d(0.0, 0.01));
  EXPECT_EQ(table.values, (RowMatrix(2, 2) << 1.5, 2.0, -3.0, 100.0).finished());
}

TEST(CsvFile, SaysWhatCannotBeUsed) {
  const std::pair<const char*, const char*> cases[] = {
      {"", "t.csv: is empty; expected a CSV file. Was it written completely?"},
      {"x,y\n1,2\n",
       "t.csv:1: no column is the time; expected one column 'time' [s], found x,y. Name the "
       "columns "
       "in line 1."},
      {"time,T\n1,2\n",
       "t.csv:1: two columns are the time; expected one column 'time' [s], found time,T. Name the "
       "columns in line 1."},
      {"time,,b\n1,2,3\n", "t.csv:1: column 2 has no label; expected a name. Name it."},
      {"time,a\n0,1\n1\n",
       "t.csv:3: a row does not fit the column labels; expected 2 cells, found 1. Correct the row "
       "or "
       "the labels."},
      {"time,a\n0,1\n1",
       "t.csv:3: a row does not fit the column labels; expected 2 cells, found 1. It is the last "
       "row: "
       "was the file written completely?"},
      {"time,a\n0,1\n1,x\n",
       "t.csv:3: column 'a' has a value that is no number; expected a number, found x. Correct the "
       "value."},
      {"time,a\n1,1\n0,1\n",
       "t.csv:3: time decreases; expected at least 1 s, the time of the row before, found 0. Sort "
       "the "
       "rows by time."},
      {"time,\"a\n1,1\n",
       "t.csv:1: a quote is not closed; expected '\"' before the end of the line. "
       "Close it."},
      {"time,a\nnan,1\n",
       "t.csv:2: the time is no number; expected a time in seconds, found nan. Correct the "
       "value."}};
  for (const auto& [content, message] : cases) {
    const TemporaryFolder folder;
    EXPECT_EQ(error_of(folder.path(), [&] { read_text(folder, content); }), message);
  }
}

TEST(MarkerTable, ColumnsInThreesAreMarkers) {
  const TemporaryFolder folder;
  const MarkerFile file = markers_from_table(read_text(
      folder, "time,A.x,A.y,A.z,B_X [mm],B_Y [mm],B_Z [mm]\n0,1,2,3,4,5,6\n0.01,1,2,3,,,\n"));
  EXPECT_EQ(file.markers.names, (std::vector<std::string>{"A", "B"}));
  EXPECT_DOUBLE_EQ(file.markers.rate, 100.0);
  EXPECT_EQ(file.markers.position(0, 0), Eigen::Vector3d(1, 2, 3));
  EXPECT_LT((file.markers.position(0, 1) - Eigen::Vector3d(4e-3, 5e-3, 6e-3)).norm(), 1e-17);
  EXPECT_TRUE(file.markers.position(1, 1).array().isNaN().all());
  const TimeTable table = marker_table(file.markers);
  EXPECT_EQ(table.labels[5], "B.z");
  EXPECT_TRUE(holds_markers(table));
}

TEST(MarkerTable, SaysWhatIsNone) {
  const TemporaryFolder folder;
  const auto message = [&](const std::string& content) {
    return error_of(folder.path(), [&] { markers_from_table(read_text(folder, content)); });
  };
  EXPECT_EQ(message("time,A.x,A.y,A.q\n0,1,2,3\n1,1,2,3\n"),
            "t.csv: column 'A.x' begins no marker; expected NAME.x, NAME.y, NAME.z, one after the "
            "other. Name the columns so, or convert to a table instead (.mot, .sto, .csv).");
  EXPECT_EQ(
      message("time,A.x,A.y,A.z\n0,1,2,3\n1,1,,3\n"),
      "t.csv: marker 'A' is torn at 1 s; expected three coordinates or none. Correct the row.");
  EXPECT_EQ(
      message("time,A.x,A.y,A.z\n0,1,2,3\n"),
      "t.csv: is too short to tell the rate of markers; expected at least 2 rows, found 1. Was "
      "it written completely?");
  EXPECT_EQ(message("time,A.x,A.y,A.z\n0,1,2,3\n0,1,2,3\n"),
            "t.csv: row 2 repeats the time 0 s; expected times that increase. Remove the row.");
}

}  // namespace
}  // namespace sinew
