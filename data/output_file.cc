#include "data/output_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string>
#include <system_error>

#include "data/input_error.h"

namespace sinew {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail(const fs::path& path, const std::string& problem, int error) {
  throw InputError({path.string(), 0},
                   {.problem = problem,
                    .expected = "",
                    .found = std::strerror(error),
                    .remedy = "Check the path, its permissions and the space left on the disk."});
}

// An open file that closes and, until kept, removes itself.
class OpenFile {
 public:
  OpenFile(fs::path path, int flags) : path_(std::move(path)) {
    descriptor_ = ::open(path_.c_str(), flags | O_WRONLY | O_CLOEXEC, 0666);
    owned_ = descriptor_ >= 0 && (flags & O_EXCL) != 0;
  }
  ~OpenFile() {
    if (descriptor_ >= 0) ::close(descriptor_);
    if (owned_) ::unlink(path_.c_str());
  }
  OpenFile(const OpenFile&) = delete;
  OpenFile& operator=(const OpenFile&) = delete;

  bool is_open() const { return descriptor_ >= 0; }
  const fs::path& path() const { return path_; }
  void keep() { owned_ = false; }

  // Zero, or errno.
  int write(std::string_view content) {
    while (!content.empty()) {
      const ssize_t written = ::write(descriptor_, content.data(), content.size());
      if (written < 0 && errno == EINTR) continue;
      if (written < 0) return errno;
      content.remove_prefix(static_cast<std::size_t>(written));
    }
    return 0;
  }
  int close() {
    const int result = ::close(descriptor_);
    descriptor_ = -1;
    return result == 0 ? 0 : errno;
  }

 private:
  fs::path path_;
  int descriptor_ = -1;
  bool owned_ = false;
};

// Devices and pipes are written to: renaming would replace them by a file.
void write_in_place(const fs::path& path, std::string_view content) {
  OpenFile file(path, 0);
  if (!file.is_open()) fail(path, "cannot open the output", errno);
  int error = file.write(content);
  if (error == 0) error = file.close();
  if (error != 0) fail(path, "cannot write the output", error);
}

void replace(const fs::path& target, std::string_view content) {
  // The name does not build on the target's, which may already be as long as names can be.
  for (int attempt = 0;; ++attempt) {
    OpenFile file(target.parent_path() / fmt::format(".sinew-{}-{}.tmp", ::getpid(), attempt),
                  O_CREAT | O_EXCL);
    if (!file.is_open() && errno == EEXIST) continue;
    if (!file.is_open()) fail(target, "cannot make a temporary file beside the output", errno);
    int error = file.write(content);
    if (error == 0) error = file.close();
    if (error != 0) fail(target, "cannot write the output", error);
    if (::rename(file.path().c_str(), target.c_str()) != 0) {
      fail(target, "cannot put the output in its place", errno);
    }
    file.keep();
    return;
  }
}

}  // namespace

void write_file_atomically(const fs::path& path, std::string_view content) {
  std::error_code error;
  const fs::path target = fs::weakly_canonical(fs::absolute(path, error), error);
  if (path.empty()) error = std::make_error_code(std::errc::invalid_argument);
  if (error) fail(path, "cannot resolve the output's path", error.value());
  const fs::file_status status = fs::status(target, error);
  if (fs::is_directory(status)) fail(path, "the output's path is a folder", EISDIR);
  if (fs::exists(status) && !fs::is_regular_file(status)) return write_in_place(target, content);
  fs::create_directories(target.parent_path(), error);
  if (error) fail(path, "cannot make the output's folder", error.value());
  replace(target, content);
}

}  // namespace sinew
