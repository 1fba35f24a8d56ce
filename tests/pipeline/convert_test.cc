#include <sys/resource.h>

#include "data/c3d_file.h"
#include "data/c3d_writer.h"
#include "data/tool_setup.h"
#include "data/trc_file.h"
#include "tests/pipeline/command_line.h"
#include "tests/pipeline/small_trial.h"

namespace sinew {
namespace {

namespace fs = std::filesystem;

fs::path walking2() { return shared_data() / "opensim-core/OpenSim/Tests/shared/walking2.c3d"; }
const char* const kPublished = "opensim-core/OpenSim/Common/Test";

// A folder with markers whose numbers are as a C3D file can hold them, and a table of two columns.
class Convert : public ::testing::Test {
 protected:
  Convert() {
    markers_ = SmallTrial::recording();
    for (double& p : markers_.p_WM.reshaped()) p = 1e-3 * static_cast<float>(1e3 * p);
    markers_.p_WM.block(40, 3, 5, 3).setConstant(std::nan(""));
    write_trc(path_ / "walk.trc", markers_);
    TimeTable table;
    table.labels = {"force_vx", "force_vy"};
    table.time = Eigen::VectorXd::LinSpaced(1501, 0.0, 1.5);
    table.values.resize(1501, 2);
    table.values.col(0) = table.time.array().sin().cast<float>().cast<double>();
    table.values.col(1).setConstant(700.0);
    write_storage(path_ / "grf.mot", table);
  }

  Outcome convert(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), "convert");
    return run_sinew(path_, arguments);
  }
  void expect_done(const std::vector<std::string>& arguments) const {
    const Outcome outcome = convert(arguments);
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  }

  const TemporaryFolder folder_;
  const fs::path& path_ = folder_.path();
  MarkerTrajectories markers_;
};

// What 32 bits leave of positions within 4 m [m].
constexpr double kSingle = 1.3e-7;

bool same(const RowMatrix& a, const RowMatrix& b, double tolerance) {
  if (a.rows() != b.rows() || a.cols() != b.cols()) return false;
  for (Eigen::Index i = 0; i < a.size(); ++i) {
    const double x = a.data()[i], y = b.data()[i];
    if (std::isnan(x) != std::isnan(y) || std::abs(x - y) > tolerance) return false;
  }
  return true;
}

TEST_F(Convert, TrcAndCsvGiveTheSameBitsBack) {
  expect_done({"walk.trc", "--out", "walk.csv"});
  expect_done({"walk.csv", "--out", "again.trc"});
  const MarkerTrajectories again = read_trc(path_ / "again.trc").markers;
  EXPECT_EQ(again.names, markers_.names);
  EXPECT_EQ(again.time, markers_.time);
  EXPECT_TRUE(same(again.p_WM, markers_.p_WM, 0.0));
}

TEST_F(Convert, C3dIsStableFromTheFirstTimeOn) {
  expect_done({"walk.trc", "grf.mot", "--out", "a.c3d"});
  expect_done({"a.c3d", "--out", "b.c3d"});
  EXPECT_EQ(content_of(path_ / "a.c3d"), content_of(path_ / "b.c3d"));
  expect_done({"a.c3d", "--up", "keep", "--out", "back.trc"});
  EXPECT_TRUE(same(read_trc(path_ / "back.trc").markers.p_WM, markers_.p_WM, kSingle));
  expect_done({"back.trc", "--out", "c.c3d"});
  expect_done({"c.c3d", "--up", "keep", "--out", "back.trc"});
  const std::string second = content_of(path_ / "back.trc");
  expect_done({"back.trc", "--out", "c.c3d"});
  expect_done({"c.c3d", "--up", "keep", "--out", "back.trc"});
  EXPECT_EQ(content_of(path_ / "back.trc"), second);
}

TEST_F(Convert, TablesBecomeChannelsAndBack) {
  expect_done({"walk.trc", "grf.mot", "--out", "a.c3d"});
  expect_done({"a.c3d", "--out", "analog.sto"});
  const TimeTable back = read_storage(path_ / "analog.sto").table;
  const TimeTable given = read_storage(path_ / "grf.mot").table;
  EXPECT_EQ(back.labels, given.labels);
  // Ten samples a frame; the last frame's go on behind the table's end.
  ASSERT_EQ(back.time.size(), 1510);
  EXPECT_TRUE(same(back.values.topRows(1501), given.values, 1e-15));
  expect_done({"grf.mot", "--rate", "100", "--from", "0.5", "--to", "1", "--out", "slow.csv"});
  EXPECT_EQ(csv_rows(path_ / "slow.csv").size(), 52u);
}

TEST_F(Convert, GapsAreFilledOnlyWhenAskedAndListed) {
  expect_done({"walk.trc", "--out", "plain.trc"});
  EXPECT_TRUE(same(read_trc(path_ / "plain.trc").markers.p_WM, markers_.p_WM, 0.0));
  EXPECT_FALSE(fs::exists(path_ / "plain_filled.csv"));
  const Outcome outcome = convert({"walk.trc", "--max-gap", "0.05", "--out", "filled.trc"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_NE(outcome.err.find("walk.trc: 2 gaps of 10 marker samples were filled; 0 gaps of 0 stay"),
            std::string::npos)
      << outcome.err;
  const auto rows = csv_rows(path_ / "filled_filled.csv");
  ASSERT_EQ(rows.size(), 3u);
  EXPECT_EQ(rows[1][1], std::to_string(markers_.frame_numbers[40]));
  EXPECT_EQ(rows[1][5], "5");
  EXPECT_EQ(rows[1][6], "spline");
  const MarkerTrajectories whole = SmallTrial::recording();
  const RowMatrix filled = read_trc(path_ / "filled.trc").markers.p_WM;
  EXPECT_FALSE(filled.hasNaN());
  EXPECT_TRUE(same(filled.leftCols(12), whole.p_WM.leftCols(12), 1e-4));
}

TEST_F(Convert, RotatesOnRequest) {
  expect_done({"walk.trc", "--up", "-z", "--forward", "y", "--out", "turned.trc"});
  const MarkerTrajectories turned = read_trc(path_ / "turned.trc").markers;
  const Eigen::Vector3d p = markers_.position(7, 2), q = turned.position(7, 2);
  // x' = y, y' = -z, z' = x' × y' = -x.
  EXPECT_LT((q - Eigen::Vector3d(p.y(), -p.z(), -p.x())).norm(), 1e-15);
}

TEST_F(Convert, WritesAllInputsIntoAFolder) {
  write_trc(path_ / "second.trc", markers_);
  expect_done({"walk.trc", "second.trc", "--format", "c3d", "--out", "c3d"});
  EXPECT_EQ(tree_of(path_ / "c3d"), (std::vector<std::string>{"second.c3d", "walk.c3d"}));
}

TEST_F(Convert, SaysWhatCannotBeDone) {
  folder_.write("short.mot", "version=1\nnRows=2\nnColumns=2\nendheader\ntime\ta\n0\t1\n0.1\t1\n");
  const std::pair<std::vector<std::string>, const char*> cases[] = {
      {{"walk.trc", "--out", "a.xlsx"},
       "a.xlsx: is of no known format; expected .c3d, .trc, .mot, .sto or .csv at the end, found "
       ".xlsx. Name the file so, or convert it elsewhere."},
      {{"walk.trc", "grf.mot", "--out", "a.trc"},
       "several inputs become one file only if that is a C3D file: give --out FILE.c3d, or "
       "--format "
       "trc and a folder as --out"},
      {{"grf.mot", "--out", "a.trc"},
       "grf.mot: column 'force_vx' begins no marker; expected NAME.x, NAME.y, NAME.z, one after "
       "the "
       "other. Name the columns so, or convert to a table instead (.mot, .sto, .csv)."},
      {{"walk.trc", "walk.trc", "--out", "a.c3d"},
       "walk.trc: is a second recording of markers; expected one. Merge one recording of markers "
       "with tables."},
      {{"walk.trc", "short.mot", "--out", "a.c3d"},
       "short.mot: does not cover the markers; expected 0 s to 1.5 s, found 0 s to 0.1 s. Crop the "
       "markers with --from and --to."},
      {{"walk.trc", "--out", "walk.trc"},
       "walk.trc: is both the output and an input (input). Choose another output, so that the "
       "input "
       "is kept."},
      {{"walk.trc", "--what", "forces", "--out", "a.mot"},
       "--what chooses a part of a C3D file, which walk.trc is not: leave it out"},
      {{"grf.mot", "--up", "z", "--out", "a.mot"},
       "grf.mot is a table whose columns say nothing of axes, markers or forces: of the options "
       "that "
       "change values only --analog-cutoff, --rate, --from and --to apply to it"},
      {{"walk.trc", "--up", "z", "--forward", "-z", "--out", "a.trc"},
       "--forward -z is not at right angles to up, which is z by the option --up: choose another "
       "axis"},
      {{"walk.trc", "--up", "w", "--out", "a.trc"},
       "--up: w is not auto, keep, x, y, z, -x, -y or -z"},
      {{"walk.trc", "--marker-cutoff", "80", "--out", "a.trc"},
       "the low-pass cutoff of 80 Hz is not below half the sampling rate of 100 Hz. Choose a "
       "cutoff "
       "below 50 Hz."},
      {{"walk.trc", "--from", "2", "--out", "a.trc"},
       "walk.trc: no frame lies in the time range, from 2 s on; walk.trc has 0 s to 1.5 s. Choose "
       "another with --from and --to."},
      {{"walk.trc"}, "no output: give --out FILE"}};
  for (const auto& [arguments, message] : cases) {
    const Outcome outcome = convert(arguments);
    EXPECT_EQ(outcome.exit_code, 2);
    EXPECT_EQ(error_line(outcome, path_), message);
  }
  EXPECT_FALSE(fs::exists(path_ / "a.trc"));
}

// Frames as floats fill 31 MB and would take four times that in memory.
TEST_F(Convert, AC3dFileNeedNotFitIntoMemory) {
  {
    C3dFile file;
    file.markers.rate = 100.0;
    const int frames = 65000, count = 30;
    file.markers.p_WM = RowMatrix::Random(frames, 3 * count);
    for (int i = 0; i < count; ++i) file.markers.names.push_back("M" + std::to_string(i));
    for (int i = 1; i <= frames; ++i) file.markers.frame_numbers.push_back(i);
    write_c3d(path_ / "large.c3d", file);
  }
  const std::string input = path_ / "large.c3d", output = path_ / "large.trc";
  const std::string binary = sinew_binary();
  const pid_t child = ::fork();
  if (child == 0) {
    ::dup2(::open("/dev/null", O_WRONLY), 1);
    ::execl(binary.c_str(), binary.c_str(), "convert", input.c_str(), "--up", "keep", "--out",
            output.c_str(), nullptr);
    ::_exit(127);
  }
  int status = 0;
  rusage usage = {};
  ASSERT_EQ(::wait4(child, &status, 0, &usage), child);
  ASSERT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0);
  EXPECT_GT(fs::file_size(input), 31'000'000u);
#if !defined(__SANITIZE_ADDRESS__)
  EXPECT_LT(usage.ru_maxrss, 30 << 10);  // kB; 17 MB of it are libraries
#endif
}

// A Z-up laboratory; the published files are in its axes.
TEST_F(Convert, MarkersOfWalking2AreThePublishedOnesTurned) {
  if (!fs::exists(walking2())) GTEST_SKIP() << "needs " << walking2();
  const Outcome outcome = convert({walking2(), "--out", "w.trc"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_NE(
      outcome.out.find("up is z (the forces that carry the subject, 98 % sure), forward is x "
                       "(the way that the markers go, 95 % sure); rotated to y up, x forward"),
      std::string::npos)
      << outcome.out;
  const MarkerTrajectories ours = read_trc(path_ / "w.trc").markers;
  const MarkerTrajectories published =
      read_trc(shared_data() / kPublished / "std_walking2_markers.trc").markers;
  EXPECT_EQ(ours.names, published.names);
  for (int i = 0; i < published.frame_count(); ++i) {
    const auto frame = static_cast<int>(std::lround(published.time[i] * ours.rate));
    for (int m = 0; m < ours.marker_count(); ++m) {
      const Eigen::Vector3d p = published.position(i, m), q = ours.position(frame, m);
      ASSERT_EQ(p.hasNaN(), q.hasNaN());
      if (!p.hasNaN()) {
        ASSERT_LT((q - Eigen::Vector3d(p.x(), p.z(), -p.y())).norm(), 1e-4 * p.norm());
      }
    }
  }
  // Read whole and then filtered by next to nothing: the same file but for the filter.
  expect_done({walking2(), "--from", "1", "--to", "2", "--out", "part.trc"});
  const MarkerTrajectories part = read_trc(path_ / "part.trc").markers;
  EXPECT_EQ(part.frame_count(), 251);
  EXPECT_EQ(part.frame_numbers.front(), 251);
  EXPECT_TRUE(same(part.p_WM, ours.p_WM.middleRows(250, 251), 0.0));
  expect_done({walking2(), "--max-gap", "0.001", "--out", "whole.trc"});
  EXPECT_TRUE(same(read_trc(path_ / "whole.trc").markers.p_WM, ours.p_WM,
                   2.0 * kSingle));  // up to 8 m away
}

TEST_F(Convert, ForcesOfWalking2AreThePublishedOnesTurned) {
  if (!fs::exists(walking2())) GTEST_SKIP() << "needs " << walking2();
  expect_done({walking2(), "--out", "w.mot"});
  const TimeTable ours = read_storage(path_ / "w.mot").table;
  const TimeTable published =
      read_storage(shared_data() / kPublished / "std_cop_walking2_grfs.sto").table;
  int loaded = 0;
  for (Eigen::Index i = 0; i < published.time.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(std::lround(published.time[i] * 2000.0));
    for (int plate = 0; plate < 2; ++plate) {
      Eigen::Matrix3d theirs;  // force, centre, moment as columns; N, mm, N mm
      theirs << published.values.row(i).segment<9>(9 * plate).reshaped(3, 3);
      Eigen::Matrix3d found;
      found << ours.values.row(row).segment<9>(9 * plate).reshaped(3, 3);
      if (theirs(2, 0) < 20.0) {
        EXPECT_EQ(found.col(0).norm(), 0.0);
        continue;
      }
      ++loaded;
      Eigen::Matrix3d R;
      R << 1, 0, 0, 0, 0, 1, 0, -1, 0;
      theirs.rightCols(2) *= 1e-3;
      ASSERT_LT((found - R * theirs).norm(), 1e-8 * theirs.norm()) << i << "\n" << found;
    }
  }
  EXPECT_GT(loaded, 20);
}

// The left foot of this trial steps beside the second platform with its heel, 16 cm from its edge:
// corners at 0 and 609.6 mm along the way, the heel at -160 mm.
TEST_F(Convert, FeetOfWalking2AreAssigned) {
  if (!fs::exists(walking2())) GTEST_SKIP() << "needs " << walking2();
  const Outcome outcome = convert({walking2(), "--out", "grf.mot", "--loads", "grf.xml"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_NE(outcome.out.find(": platform 1, 2.67 s to 3.24 s: right foot (94 % sure)\n"),
            std::string::npos)
      << outcome.out;
  EXPECT_NE(
      outcome.out.find(": platform 2, 2.25 s to 2.75 s: unusable: the foot reaches 16 cm over "
                       "its edge, where nothing measures the force\n"),
      std::string::npos)
      << outcome.out;
  const ExternalLoadsSetup loads = read_external_loads(path_ / "grf.xml");
  ASSERT_EQ(loads.forces.size(), 2u);
  EXPECT_EQ(loads.forces[0].applied_to_body, "calcn_r");
  const TimeTable table = read_storage(loads.data_file).table;
  EXPECT_NEAR(table.values.col(table.find_column("right_force_vy")).maxCoeff(), 951.0, 0.1);
  EXPECT_EQ(table.values.col(table.find_column("left_force_vy")).maxCoeff(), 0.0);
  const auto rows = csv_rows(path_ / "grf_contacts.csv");
  ASSERT_EQ(rows.size(), 3u);
  EXPECT_EQ(rows[2][5], "unusable");
  expect_done({walking2(), "--out", "said.mot", "--loads", "said.xml", "--assign", "2:left"});
  const TimeTable said = read_storage(path_ / "said.mot").table;
  EXPECT_NEAR(said.values.col(said.find_column("left_force_vy")).maxCoeff(), 747.0, 0.5);
}

TEST_F(Convert, SaysWhatCannotBeAssigned) {
  const std::pair<std::vector<std::string>, const char*> cases[] = {
      {{"walk.trc", "--out", "g.mot", "--loads", "g.xml"},
       "feet are assigned to the platforms of one C3D file: give FILE.c3d --out GRF.mot --loads "
       "GRF.xml"},
      {{"a.c3d", "--out", "g.mot", "--loads", "g.xml", "--assign", "right"},
       "--assign right is not PLATE:FOOT or PLATE:FOOT@FROM-TO, such as 1:right or 2:none@0.5-1.2"},
      {{"a.c3d", "--out", "g.mot", "--loads", "g.xml"},
       "a.c3d: has no force platform that can be used. Choose another part with --what, or another "
       "file."}};
  expect_done({"walk.trc", "grf.mot", "--out", "a.c3d"});
  for (const auto& [arguments, message] : cases) {
    const Outcome outcome = convert(arguments);
    EXPECT_EQ(outcome.exit_code, 2);
    EXPECT_EQ(error_line(outcome, path_), message);
  }
}

}  // namespace
}  // namespace sinew
