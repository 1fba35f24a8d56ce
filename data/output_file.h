#pragma once

#include <filesystem>
#include <string_view>

namespace sinew {

/// Writes `content` under a temporary name beside `path` and renames it, so that a reader sees the
/// old file or the whole new one, never a part. Missing folders are made. The temporary file is
/// removed on failure. Throws InputError naming the path and the system's reason.
void write_file_atomically(const std::filesystem::path& path, std::string_view content);

}  // namespace sinew
