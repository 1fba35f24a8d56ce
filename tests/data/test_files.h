#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <string_view>

#include "data/input_error.h"
#include "data/time_table.h"

namespace sinew {

/// A folder that is made for one test and removed after it.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string pattern = (std::filesystem::temp_directory_path() / "sinew-test-XXXXXX").string();
    path_ = std::filesystem::canonical(::mkdtemp(pattern.data()));
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }
  std::filesystem::path write(const std::string& name, std::string_view content) const {
    std::ofstream(path_ / name, std::ios::binary) << content;
    return path_ / name;
  }

 private:
  std::filesystem::path path_;
};

inline std::string content_of(const std::filesystem::path& path) {
  std::ostringstream content;
  content << std::ifstream(path, std::ios::binary).rdbuf();
  return content.str();
}

/// The message of the InputError that `action` throws, without the folder of the file it names; or
/// "no error".
template <typename Action>
std::string error_of(const std::filesystem::path& folder, Action action) {
  std::string message = "no error";
  try {
    action();
  } catch (const InputError& error) {
    message = error.what();
  }
  const std::string prefix = folder.string() + "/";
  for (std::size_t at = message.find(prefix); at != message.npos; at = message.find(prefix)) {
    message.erase(at, prefix.size());
  }
  return message;
}

/// The texts of warnings, each with its line, one a line.
inline std::string to_text(const std::vector<Warning>& warnings) {
  std::string text;
  for (const Warning& warning : warnings) {
    text += std::to_string(warning.at.line) + ": " + warning.text + "\n";
  }
  return text;
}

/// Equal bit for bit, but for the payload of NaN.
template <typename A, typename B>
bool identical(const Eigen::DenseBase<A>& a, const Eigen::DenseBase<B>& b) {
  if (a.rows() != b.rows() || a.cols() != b.cols()) return false;
  for (Eigen::Index i = 0; i < a.rows(); ++i) {
    for (Eigen::Index j = 0; j < a.cols(); ++j) {
      const double x = a.derived()(i, j), y = b.derived()(i, j);
      const bool same =
          std::isnan(x) ? std::isnan(y) : x == y && std::signbit(x) == std::signbit(y);
      if (!same) return false;
    }
  }
  return true;
}

}  // namespace sinew
