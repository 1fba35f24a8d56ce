#include "data/storage_file.h"

#include <gtest/gtest.h>

#include <cstring>
#include <limits>
#include <random>

#include "tests/data/test_files.h"

namespace sinew {
namespace {

using Strings = std::vector<std::string>;

TimeTableFile read_text(const std::string& content) {
  const TemporaryFolder folder;
  return read_storage(folder.write("table.sto", content));
}

TEST(ReadStorage, ReadsTheHeaderOfVersion1) {
  const TimeTableFile file = read_text(
      "Coordinates\nversion=1\nnRows=2\nnColumns=3\ninDegrees=yes\n\nAny text.\nendheader\n"
      "time\ta\tb\n 0.0\t 1.5\t-2\n 0.1\t 3\t4e-1\n");
  EXPECT_EQ(file.table.name, "Coordinates");
  EXPECT_EQ(file.table.labels, (Strings{"a", "b"}));
  EXPECT_EQ(file.table.in_degrees, true);
  EXPECT_EQ(file.table.time, Eigen::Vector2d(0.0, 0.1));
  RowMatrix expected(2, 2);
  expected << 1.5, -2.0, 3.0, 0.4;
  EXPECT_EQ(file.table.values, expected);
  EXPECT_TRUE(file.warnings.empty()) << to_text(file.warnings);
  EXPECT_TRUE(file.table.header.empty());
}

TEST(ReadStorage, KeepsTheOtherKeysOfVersion3) {
  const TimeTableFile file = read_text(
      "DataRate=2000.000000\nDataType=double\nversion=3\nOpenSimVersion=4.5\nendheader\n"
      "time\tx\n0\t1\n");
  EXPECT_EQ(file.table.name, "");
  EXPECT_EQ(file.table.in_degrees, std::nullopt);
  EXPECT_EQ(file.table.header, (std::map<std::string, std::string>{{"DataRate", "2000.000000"},
                                                                   {"OpenSimVersion", "4.5"}}));
}

TEST(ReadStorage, ReadsSimmHeadersAndKeysWithoutEqualsSign) {
  const TimeTableFile simm = read_text(
      "name H:\\run\\grf run.mot\ndatacolumns 2\ndatarows 1\notherdata 1\nrange 0 0.8\nendheader \n"
      "\n \n            time\t  R_vx\n 0.0\t 7\n\n");
  EXPECT_EQ(simm.table.name, "H:\\run\\grf run.mot");
  EXPECT_EQ(simm.table.labels, Strings{"R_vx"});
  EXPECT_TRUE(simm.warnings.empty()) << to_text(simm.warnings);
  const TimeTableFile loose = read_text("t\nnRows 1\nnColumns 2\nendheader\ntime x\n0 1\n");
  EXPECT_TRUE(loose.warnings.empty()) << to_text(loose.warnings);
  EXPECT_EQ(loose.table.name, "t");
}

TEST(ReadStorage, TakesTheSentenceOnDegreesOnlyInOldFiles) {
  const std::string end = "Angles are in degrees.\nendheader\ntime x\n0 1\n";
  EXPECT_EQ(read_text("t\n" + end).table.in_degrees, true);
  EXPECT_EQ(read_text("t\nversion=1\n" + end).table.in_degrees, std::nullopt);
  EXPECT_EQ(read_text("t\nversion=1\ninDegrees=no\n" + end).table.in_degrees, false);
  EXPECT_EQ(read_text("t\nendheader\ntime x\n0 1\n").table.in_degrees, std::nullopt);
}

TEST(ReadStorage, TakesTimeFromAnyColumnAndAnyLineEnding) {
  for (const char* ending : {"\n", "\r\n", "\r"}) {
    std::string content = "t|endheader|x\tTime\ty|1\t0.5\t2|3\t0.6\t4";
    for (std::size_t at = content.find('|'); at != content.npos; at = content.find('|')) {
      content.replace(at, 1, ending);
    }
    const TimeTable table = read_text(content).table;
    EXPECT_EQ(table.labels, (Strings{"x", "y"}));
    EXPECT_EQ(table.time, Eigen::Vector2d(0.5, 0.6));
    EXPECT_EQ(table.values(1, 1), 4.0);
  }
}

TEST(ReadStorage, SplitsLabelsByWhatFitsTheRows) {
  EXPECT_EQ(
      read_text("t\nnColumns=3\nendheader\ntime\tv1 v2\n1.\t10\t20.\n2. 20\t\t40\n").table.labels,
      (Strings{"v1", "v2"}));
  EXPECT_EQ(read_text("t\nnColumns=3\nendheader\ntime\thip flexion\tb\n1\t2\t3\n").table.labels,
            (Strings{"hip flexion", "b"}));
  EXPECT_EQ(read_text("t\nendheader\ntime\thip flexion\tb\n1\t2\t3\n").table.labels,
            (Strings{"hip flexion", "b"}));
  EXPECT_EQ(read_text("t\nendheader\ntime\tr1_z\t\tr1_z_u\n0\t1\t0\n").table.labels,
            (Strings{"r1_z", "r1_z_u"}));
}

TEST(ReadStorage, ReadsNotANumberInAnyCaseAndBlankCells) {
  const TimeTableFile file =
      read_text("t\nendheader\ntime\ta\tb\n0\tNaN\tnan\n1\t\t5\n2\t1.#QNAN\tInf\n3\t7\t\t\t\n");
  EXPECT_TRUE(file.table.values.row(0).array().isNaN().all());
  EXPECT_TRUE(std::isnan(file.table.values(1, 0)));
  EXPECT_EQ(file.table.values(1, 1), 5.0);
  EXPECT_TRUE(std::isnan(file.table.values(2, 0)));
  EXPECT_TRUE(std::isinf(file.table.values(2, 1)));
  EXPECT_TRUE(std::isnan(file.table.values(3, 1)));
  EXPECT_EQ(to_text(file.warnings), "5: 2 blank cells were read as NaN\n");
}

TEST(ReadStorage, FlattensVectorsAsOpenSimDoes) {
  const TimeTable vec3 =
      read_text("DataType=Vec3\nversion=2\nendheader\ntime\tp\tq\n0\t1,2,3\t4, 5, 6\n").table;
  EXPECT_EQ(vec3.labels, (Strings{"p_x", "p_y", "p_z", "q_x", "q_y", "q_z"}));
  EXPECT_EQ(vec3.values(0, 4), 5.0);
  const TimeTable spatial =
      read_text("DataType=SpatialVec\nendheader\ntime\tF\n0\t1,2,3,4,5,6\n").table;
  EXPECT_EQ(spatial.labels, (Strings{"F_rx", "F_ry", "F_rz", "F_tx", "F_ty", "F_tz"}));
  EXPECT_EQ(read_text("DataType=Quaternion\nendheader\ntime\tR\n0\t1,0,0,0\n").table.labels,
            (Strings{"R_1", "R_2", "R_3", "R_4"}));
}

TEST(ReadStorage, WarnsOfWhatTheHeaderGetsWrong) {
  EXPECT_EQ(to_text(read_text("t\nnRows=302\nnColumns=40\nendheader\ntime x\n0 1\n").warnings),
            "3: the header promises nColumns=40, the file has 2 columns; all of them were read\n"
            "2: the header promises nRows=302, the file has 1 rows; all of them were read\n");
}

TEST(ReadStorage, KeepsRepeatedTimesAndLabelsWithAWarning) {
  const TimeTableFile file = read_text(
      "t\nendheader\ntime x x y y y\n0 1 2 3 4 5\n0 1 2 3 4 5\n0 1 2 3 4 5\n1 1 2 3 4 5\n");
  EXPECT_EQ(file.table.time.size(), 4);
  EXPECT_EQ(
      to_text(file.warnings),
      "3: 3 columns repeat the label of an earlier one ('x', 'y', 'y'); by name only the first "
      "of each is found\n5: 2 rows repeat the time of the row before; all are kept\n");
  EXPECT_EQ(file.table.find_column("y"), 2);
  EXPECT_EQ(file.table.find_column("z"), -1);
}

TEST(ReadStorage, TakesIrregularAndNegativeTimes) {
  const TimeTableFile file = read_text("t\nendheader\ntime x\n-2e-7 1\n0.00833 2\n0.02 3\n");
  EXPECT_EQ(file.table.time[0], -2e-7);
  EXPECT_TRUE(file.warnings.empty()) << to_text(file.warnings);
}

TEST(ReadStorage, ReadsATableWithoutRows) {
  const TimeTable table = read_text("controls\nnRows=0\nnColumns=1\nendheader\ntime\n").table;
  EXPECT_EQ(table.time.size(), 0);
  EXPECT_TRUE(table.labels.empty());
}

TEST(ReadStorage, AllocatesByTheFileNotByTheHeader) {
  const TimeTableFile file =
      read_text("t\nnRows=9000000000000000\nnColumns=9000000000000000\nendheader\ntime x\n0 1\n");
  EXPECT_EQ(file.table.values.size(), 1);
  EXPECT_EQ(file.warnings.size(), 2u);
}

TEST(ReadStorageLabels, GivesTheLabelsOfReadStorage) {
  const TemporaryFolder folder;
  const auto path = folder.write("t.sto", "t\nendheader\na\ttime\tb c\n1\t2\t3\n");
  EXPECT_EQ(read_storage_labels(path), read_storage(path).table.labels);
}

TimeTable random_table(int rows, int columns) {
  std::mt19937_64 random(11);
  TimeTable table;
  table.name = "random bits";
  table.in_degrees = false;
  table.header["OpenSimVersion"] = "4.5";
  for (int i = 0; i < columns; ++i) table.labels.push_back("c" + std::to_string(i));
  table.time = Eigen::VectorXd::LinSpaced(rows, -2e-7, 1.0 / 3.0);
  table.values.resize(rows, columns);
  for (double& value : table.values.reshaped()) {
    const std::uint64_t bits = random();
    std::memcpy(&value, &bits, sizeof value);
  }
  table.values(0, 0) = std::numeric_limits<double>::quiet_NaN();
  table.values(0, 1) = -0.0;
  table.values(0, 2) = std::numeric_limits<double>::denorm_min();
  return table;
}

TEST(WriteStorage, RoundTripsEveryNumberExactly) {
  const TemporaryFolder folder;
  const TimeTable table = random_table(500, 20);
  write_storage(folder.path() / "out.sto", table);
  const TimeTableFile back = read_storage(folder.path() / "out.sto");
  EXPECT_TRUE(back.warnings.empty()) << to_text(back.warnings);
  EXPECT_TRUE(identical(back.table.time, table.time));
  EXPECT_TRUE(identical(back.table.values, table.values));
  EXPECT_EQ(back.table.labels, table.labels);
  EXPECT_EQ(back.table.name, table.name);
  EXPECT_EQ(back.table.in_degrees, table.in_degrees);
  EXPECT_EQ(back.table.header, table.header);
}

TEST(WriteStorage, WritesTheFormatOfOpenSim) {
  const TemporaryFolder folder;
  TimeTable table;
  table.name = "Coordinates";
  table.labels = {"a", "b"};
  table.in_degrees = true;
  table.time = Eigen::Vector2d(0.0, 0.01);
  table.values.resize(2, 2);
  table.values << 1.5, -2.0, 0.1, std::numeric_limits<double>::quiet_NaN();
  write_storage(folder.path() / "out.mot", table);
  EXPECT_EQ(content_of(folder.path() / "out.mot"),
            "Coordinates\nversion=1\nnRows=2\nnColumns=3\ninDegrees=yes\nendheader\n"
            "time\ta\tb\n0\t1.5\t-2\n0.01\t0.1\tNaN\n");
}

TEST(WriteStorage, KeepsNamesThatLookLikeKeysAndSilenceOnDegrees) {
  const TemporaryFolder folder;
  for (const char* name : {"", "name of a trial", "nRows of pain", "a=b", "endheader", "range 5"}) {
    TimeTable table;
    table.name = name;
    table.values.resize(0, 0);
    write_storage(folder.path() / "out.sto", table);
    const TimeTable back = read_storage(folder.path() / "out.sto").table;
    EXPECT_EQ(back.name, name);
    EXPECT_EQ(back.in_degrees, std::nullopt);
  }
}

TEST(WriteStorage, RefusesTablesThatNoFileCanHold) {
  const TemporaryFolder folder;
  TimeTable table = random_table(2, 3);
  const auto error = [&] {
    return error_of(folder.path(), [&] { write_storage(folder.path() / "x.sto", table); });
  };
  table.labels[1] = "a\tb";
  EXPECT_EQ(error(),
            "x.sto: write_storage cannot write this label; expected text without tabs and "
            "line breaks, found a\\x09b. Rename it.");
  table.labels[1] = "Time";
  EXPECT_EQ(error(),
            "x.sto: write_storage cannot write this label; expected a name other than "
            "'time', found Time. Rename the column.");
  table.labels.pop_back();
  EXPECT_EQ(error(),
            "x.sto: write_storage got a table whose sizes disagree; expected 2 × 2 values, "
            "found 2 × 3");
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "x.sto"));
}

}  // namespace
}  // namespace sinew
