#include "tests/data/corruption.h"

#include "data/c3d_file.h"
#include "data/csv_file.h"
#include "data/force_platform.h"
#include "data/storage_file.h"
#include "data/tool_setup.h"
#include "data/trc_file.h"

namespace sinew {
namespace {

namespace fs = std::filesystem;

constexpr double kMiB = 1 << 20;

class Corruption : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!fs::exists("../shared/data")) GTEST_SKIP() << "needs the recordings in ../shared/data";
  }
};

// Without the folder and the numbers of lines and bytes, which tell nothing new.
std::string texts(const std::vector<Warning>& warnings) {
  std::string result;
  for (const Warning& warning : warnings) result += warning.text + "\n";
  return result;
}

Reading of_markers(const MarkerTrajectories& markers, const std::vector<Warning>& warnings) {
  Fingerprint print;
  print.add(markers.names);
  print.add(markers.time);
  print.add(markers.p_WM);
  return {print.text(), texts(warnings)};
}

Reading of_table(const TimeTableFile& file) {
  Fingerprint print;
  print.add(file.table.labels);
  print.add(file.table.time);
  print.add(file.table.values);
  return {print.text(), texts(file.warnings)};
}

Reading of_c3d(const fs::path& path) {
  C3dFile file = read_c3d(path);
  Fingerprint print;
  print.add(of_markers(file.markers, {}).result);
  print.add(file.analog.labels);
  print.add(file.analog.values);
  print.add(file.computed.values);
  for (const C3dEvent& event : file.events) print.add(event.label);
  return {print.text(), texts(file.warnings)};
}

TEST_F(Corruption, C3d) {
  // Blocks of 1 MiB; the file's own numbers become twice to four times as large.
  Battery battery("C3D", of_c3d, 4.0, 4 * kMiB);
  for (const fs::path& path : shared_files({".c3d", ".C3D"})) battery.run(path);
  battery.report();
}

// Forces take more than the file, and are computed from what was read.
TEST_F(Corruption, ForcePlatforms) {
  Battery battery(
      "force platforms",
      [](const fs::path& path) {
        const ForcePlatforms platforms = compute_forces(read_c3d(path));
        Fingerprint print;
        for (const ForcePlatformRecording& recording : platforms.recordings) {
          print.add(recording.force);
        }
        return Reading{print.text(), texts(platforms.warnings)};
      },
      40.0, 8 * kMiB);
  battery.allow_silent_cuts();
  for (const fs::path& path : shared_files({".c3d", ".C3D"})) battery.run(path);
  battery.report();
}

TEST_F(Corruption, Trc) {
  Battery battery(
      "TRC",
      [](const fs::path& path) {
        const MarkerFile file = read_trc(path);
        return of_markers(file.markers, file.warnings);
      },
      4.0, 32 * kMiB);
  for (const fs::path& path : shared_files({".trc"})) battery.run(path);
  battery.report();
}

TEST_F(Corruption, Storage) {
  Battery battery(
      "MOT and STO", [](const fs::path& path) { return of_table(read_storage(path)); }, 4.0,
      4 * kMiB);
  battery.allow_silent_cuts();  // at the end of a row, if nRows is missing
  for (const fs::path& path : shared_files({".sto", ".mot"})) battery.run(path);
  battery.report();
}

// There are no published CSV files; some MOT files become such.
TEST_F(Corruption, Csv) {
  const TemporaryFolder folder;
  Battery battery(
      "CSV", [](const fs::path& path) { return of_table(read_csv(path)); }, 4.0, 4 * kMiB);
  battery.allow_silent_cuts();  // at the end of a row
  for (const fs::path& path : shared_files({".mot"})) {
    TimeTable table = read_storage(path).table;
    write_csv(folder.path() / "a.csv", table);
    battery.run(folder.path() / "a.csv");
  }
  battery.report();
}

// By whichever reader takes the whole file; scale setups and others have none here.
TEST_F(Corruption, Setups) {
  const std::vector<std::pair<const char*, std::function<void(const fs::path&)>>> readers = {
      {"setups of IK", [](const fs::path& path) { read_ik_setup(path); }},
      {"setups of ID", [](const fs::path& path) { read_id_setup(path); }},
      {"external loads", [](const fs::path& path) { read_external_loads(path); }},
      {"tasks of IK", [](const fs::path& path) { read_ik_task_set(path); }}};
  std::vector<Battery> batteries;
  for (const auto& [name, reader] : readers) {
    batteries.emplace_back(
        name,
        [&reader = reader](const fs::path& path) {
          reader(path);
          return Reading{"read", ""};
        },
        16.0, 4 * kMiB);
  }
  int used = 0;
  for (const fs::path& path : shared_files({".xml"})) {
    for (std::size_t i = 0; i < readers.size(); ++i) {
      if (error_of({}, [&] { readers[i].second(path); }) != "no error") continue;
      std::vector<fs::path> beside;  // task sets in files of their own
      for (const fs::directory_entry& entry : fs::directory_iterator(path.parent_path())) {
        if (entry.path().extension() == ".xml") beside.push_back(entry.path());
      }
      batteries[i].run(path, beside);
      ++used;
      break;
    }
  }
  EXPECT_GE(used, 20);
  for (const Battery& battery : batteries) battery.report();
}

}  // namespace
}  // namespace sinew
