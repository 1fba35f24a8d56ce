#pragma once

#include <filesystem>
#include <string>

namespace sinew {

/// The whole content of a file. Throws InputError if it is missing, a folder, unreadable or larger
/// than `max_bytes` (a reader's promise of bounded memory).
std::string read_file(const std::filesystem::path& path,
                      std::size_t max_bytes = std::size_t{4} << 30);

/// SHA-256 of a file's bytes in hexadecimal. Throws as read_file does.
std::string sha256_of_file(const std::filesystem::path& path);

}  // namespace sinew
