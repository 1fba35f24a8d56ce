#include "data/output_file.h"

#include <gtest/gtest.h>

#include <atomic>
#include <thread>

#include "tests/data/test_files.h"

namespace sinew {
namespace {

namespace fs = std::filesystem;

std::size_t count_files(const fs::path& folder) {
  return static_cast<std::size_t>(
      std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
}

TEST(WriteFileAtomically, MakesFoldersAndReplaces) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "a" / "b" / "out.sto";
  write_file_atomically(path, "first");
  write_file_atomically(path, "second");
  EXPECT_EQ(content_of(path), "second");
  EXPECT_EQ(count_files(path.parent_path()), 1u);
}

TEST(WriteFileAtomically, WritesThroughALinkAndTakesTheLongestName) {
  const TemporaryFolder folder;
  const fs::path file = folder.write("file", "old");
  fs::create_symlink(file, folder.path() / "link");
  write_file_atomically(folder.path() / "link", "new");
  EXPECT_TRUE(fs::is_symlink(folder.path() / "link"));
  EXPECT_EQ(content_of(file), "new");
  write_file_atomically(folder.path() / std::string(255, 'n'), "long");
  EXPECT_EQ(content_of(folder.path() / std::string(255, 'n')), "long");
}

TEST(WriteFileAtomically, ReadersSeeTheOldOrTheNewFile) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "out";
  const std::string a(100'000, 'a'), b(100'000, 'b');
  write_file_atomically(path, a);
  std::atomic<bool> done = false;
  std::thread writer([&] {
    for (int i = 0; i < 50; ++i) write_file_atomically(path, i % 2 == 0 ? b : a);
    done = true;
  });
  while (!done) {
    const std::string seen = content_of(path);
    EXPECT_TRUE(seen == a || seen == b) << seen.size();
  }
  writer.join();
}

TEST(WriteFileAtomically, NamesThePathAndTheReason) {
  const TemporaryFolder folder;
  folder.write("file", "");
  const std::string remedy = ". Check the path, its permissions and the space left on the disk.";
  const auto error = [&](const fs::path& path) {
    return error_of(folder.path(), [&] { write_file_atomically(path, "content"); });
  };
  EXPECT_EQ(error(folder.path() / "file" / "out"),
            "file/out: cannot make the output's folder; found Not a directory" + remedy);
  EXPECT_EQ(
      error(folder.path()),
      folder.path().string() + ": the output's path is a folder; found Is a directory" + remedy);
  EXPECT_EQ(error(""), ": cannot resolve the output's path; found Invalid argument" + remedy);
  EXPECT_EQ(error("/dev/full"),
            "/dev/full: cannot write the output; found No space left on device" + remedy);
  EXPECT_EQ(count_files(folder.path()), 1u);
}

}  // namespace
}  // namespace sinew
