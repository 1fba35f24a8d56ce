#pragma once

#include <filesystem>
#include <memory>
#include <string_view>

namespace sinew {

/// Writes `content` under a temporary name beside `path` and renames it, so that a reader sees the
/// old file or the whole new one, never a part. Missing folders are made. The temporary file is
/// removed on failure. Throws InputError naming the path and the system's reason.
void write_file_atomically(const std::filesystem::path& path, std::string_view content);

/// A file that is written piece by piece under a temporary name and put into its place by commit;
/// dropped if that is never called. For outputs that shall not lie in memory at once. Devices and
/// pipes are written to at once. Throws InputError as write_file_atomically does.
class OutputFile {
 public:
  explicit OutputFile(const std::filesystem::path& path);
  ~OutputFile();
  OutputFile(OutputFile&&) noexcept;

  void append(std::string_view content);
  void commit();

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace sinew
