#include "data/input_file.h"

#include <fmt/format.h>
#include <openssl/evp.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <memory>

#include "data/input_error.h"

namespace sinew {

std::string read_file(const std::filesystem::path& path, std::size_t max_bytes) {
  const SourceLocation at{path.string()};
  std::error_code error;
  const auto status = std::filesystem::status(path, error);
  if (!std::filesystem::exists(status)) {
    throw InputError(at, {"no such file", "", "", "Check the path and its spelling."});
  }
  if (std::filesystem::is_directory(status)) {
    throw InputError(at, {"is a folder", "a file", "", "Name a file in it."});
  }
  std::ifstream stream(path, std::ios::binary);
  if (!stream) {
    throw InputError(at, {fmt::format("cannot be opened ({})", std::strerror(errno)), "", "",
                          "Check its permissions."});
  }
  std::string content;
  // One pass by blocks: works for pipes too, whose size is not known beforehand.
  constexpr std::size_t kBlock = std::size_t{1} << 20;
  while (stream) {
    const std::size_t old_size = content.size();
    if (old_size > max_bytes) {
      throw InputError(at, {"is too large", fmt::format("at most {} MiB", max_bytes >> 20), "",
                            "Is it really the file you meant?"});
    }
    content.resize(old_size + kBlock);
    stream.read(content.data() + old_size, static_cast<std::streamsize>(kBlock));
    content.resize(old_size + static_cast<std::size_t>(stream.gcount()));
  }
  if (stream.bad()) {
    throw InputError(at, {fmt::format("cannot be read ({})", std::strerror(errno)), "", "", ""});
  }
  return content;
}

std::string sha256_of_file(const std::filesystem::path& path) {
  const std::string content = read_file(path);
  unsigned char digest[EVP_MAX_MD_SIZE];
  unsigned int length = 0;
  if (EVP_Digest(content.data(), content.size(), digest, &length, EVP_sha256(), nullptr) != 1) {
    throw std::runtime_error("SHA-256 is not available in this build of OpenSSL");
  }
  std::string hex;
  for (unsigned int i = 0; i < length; ++i) hex += fmt::format("{:02x}", digest[i]);
  return hex;
}

}  // namespace sinew
