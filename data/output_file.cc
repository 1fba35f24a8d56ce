#include "data/output_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string>
#include <system_error>
#include <utility>

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

// The name does not build on the target's, which may already be as long as names can be.
std::unique_ptr<OpenFile> open_beside(const fs::path& target) {
  for (int attempt = 0;; ++attempt) {
    auto file = std::make_unique<OpenFile>(
        target.parent_path() / fmt::format(".sinew-{}-{}.tmp", ::getpid(), attempt),
        O_CREAT | O_EXCL);
    if (file->is_open()) return file;
    if (errno != EEXIST) fail(target, "cannot make a temporary file beside the output", errno);
  }
}

}  // namespace

class OutputFile::Implementation {
 public:
  explicit Implementation(const fs::path& path) {
    std::error_code error;
    target_ = fs::weakly_canonical(fs::absolute(path, error), error);
    if (path.empty()) error = std::make_error_code(std::errc::invalid_argument);
    if (error) fail(path, "cannot resolve the output's path", error.value());
    const fs::file_status status = fs::status(target_, error);
    if (fs::is_directory(status)) fail(path, "the output's path is a folder", EISDIR);
    // Devices and pipes are written to: renaming would replace them by a file.
    in_place_ = fs::exists(status) && !fs::is_regular_file(status);
    if (in_place_) {
      file_ = std::make_unique<OpenFile>(target_, 0);
      if (!file_->is_open()) fail(target_, "cannot open the output", errno);
      return;
    }
    fs::create_directories(target_.parent_path(), error);
    if (error) fail(path, "cannot make the output's folder", error.value());
    file_ = open_beside(target_);
  }

  void append(std::string_view content) {
    if (const int error = file_->write(content)) fail(target_, "cannot write the output", error);
  }

  void commit() {
    if (const int error = file_->close()) fail(target_, "cannot write the output", error);
    if (in_place_) return;
    if (::rename(file_->path().c_str(), target_.c_str()) != 0) {
      fail(target_, "cannot put the output in its place", errno);
    }
    file_->keep();
  }

 private:
  fs::path target_;
  bool in_place_ = false;
  std::unique_ptr<OpenFile> file_;
};

OutputFile::OutputFile(const fs::path& path)
    : implementation_(std::make_unique<Implementation>(path)) {}
OutputFile::~OutputFile() = default;
OutputFile::OutputFile(OutputFile&&) noexcept = default;

void OutputFile::append(std::string_view content) { implementation_->append(content); }
void OutputFile::commit() { implementation_->commit(); }

void write_file_atomically(const fs::path& path, std::string_view content) {
  OutputFile file(path);
  file.append(content);
  file.commit();
}

}  // namespace sinew
