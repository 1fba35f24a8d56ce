#pragma once

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <optional>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "data/storage_file.h"
#include "tests/data/test_files.h"

namespace sinew {

// After which a command hangs [s]; AddressSanitizer makes a search of 9 s one of 130 s.
#ifdef __SANITIZE_ADDRESS__
constexpr double kHangs = 600.0;
#else
constexpr double kHangs = 120.0;
#endif

/// The command, which is built beside the test program.
inline std::string sinew_binary() {
  return (std::filesystem::read_symlink("/proc/self/exe").parent_path() / "sinew").string();
}

/// What a run of the command left.
struct Outcome {
  int exit_code = -1;  // −1: ended by a signal
  std::string out, err;
  double seconds = 0.0;  // from the signal on, if one was sent
};

/// How a run is disturbed.
struct Interruption {
  double after_seconds = 0.0;  // SIGINT then, or
  std::string after_text;      // as soon as standard error holds this
};

/// Runs `sinew` with these arguments in `folder`. A run is killed after two minutes.
inline Outcome run_sinew(const std::filesystem::path& folder, std::vector<std::string> arguments,
                         const std::optional<Interruption>& interruption = std::nullopt) {
  using Clock = std::chrono::steady_clock;
  const TemporaryFolder streams;
  const std::string out = (streams.path() / "out").string(),
                    err = (streams.path() / "err").string();
  arguments.insert(arguments.begin(), sinew_binary());
  std::vector<char*> argv;
  for (std::string& argument : arguments) argv.push_back(argument.data());
  argv.push_back(nullptr);
  const auto seconds_since = [](Clock::time_point t) {
    return std::chrono::duration<double>(Clock::now() - t).count();
  };
  auto start = Clock::now();
  const pid_t child = ::fork();
  if (child == 0) {
    const int null = ::open("/dev/null", O_RDONLY);
    ::dup2(null, 0);
    ::dup2(::open(out.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0666), 1);
    ::dup2(::open(err.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0666), 2);
    if (::chdir(folder.c_str()) == 0) ::execv(argv[0], argv.data());
    ::_exit(127);
  }
  bool sent = false;
  int status = 0;
  while (::waitpid(child, &status, WNOHANG) == 0) {
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
    if (interruption && !sent) {
      const bool now = interruption->after_text.empty()
                           ? seconds_since(start) > interruption->after_seconds
                           : content_of(err).find(interruption->after_text) != std::string::npos;
      if (now) {
        ::kill(child, SIGINT);
        sent = true;
        start = Clock::now();
      }
    }
    if (seconds_since(start) > kHangs) ::kill(child, SIGKILL);
  }
  Outcome outcome;
  outcome.seconds = seconds_since(start);
  outcome.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  outcome.out = content_of(out);
  outcome.err = content_of(err);
  return outcome;
}

/// Lines that begin with `error: `, without it and without the folder's path.
inline std::string error_line(const Outcome& outcome, const std::filesystem::path& folder) {
  std::istringstream lines(outcome.err);
  std::string found;
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with("error: ")) found += line.substr(7);
  }
  const std::string prefix = folder.string() + "/";
  for (std::size_t at = found.find(prefix); at != found.npos; at = found.find(prefix)) {
    found.erase(at, prefix.size());
  }
  return found;
}

/// Names of all files and folders below a folder, sorted.
inline std::vector<std::string> tree_of(const std::filesystem::path& folder) {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    names.push_back(std::filesystem::relative(entry.path(), folder).string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

/// A row of cells, quoted or not (RFC 4180).
inline std::vector<std::string> csv_cells(const std::string& line) {
  std::vector<std::string> cells = {""};
  bool quoted = false;
  for (const char c : line) {
    if (c == '"') {
      quoted = !quoted;
    } else if (c == ',' && !quoted) {
      cells.emplace_back();
    } else {
      cells.back() += c;
    }
  }
  return cells;
}

inline std::vector<std::vector<std::string>> csv_rows(const std::filesystem::path& path) {
  std::istringstream lines(content_of(path));
  std::vector<std::vector<std::string>> rows;
  for (std::string line; std::getline(lines, line);) rows.push_back(csv_cells(line));
  return rows;
}

/// ../shared/data, or empty where it is missing.
inline std::filesystem::path shared_data() {
  const std::filesystem::path folder = std::filesystem::absolute("../shared/data");
  std::error_code error;
  return std::filesystem::is_directory(folder, error) ? std::filesystem::canonical(folder)
                                                      : std::filesystem::path();
}

}  // namespace sinew
