#include "pipeline/command.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <sstream>
#include <string_view>

namespace sinew {
namespace {

volatile std::sig_atomic_t g_interrupts = 0;

extern "C" void on_interrupt(int) {
  g_interrupts = 1;
  std::signal(SIGINT, SIG_DFL);
}

// Names, numbers and what is quoted differ between warnings of a kind.
bool is_name(const std::string& word) {
  int capitals = 0;
  for (const char c : word) {
    const auto letter = static_cast<unsigned char>(c);
    if (std::isdigit(letter) != 0 || c == '_' || c == '/' || c == '<') return true;
    capitals += std::isupper(letter) != 0 ? 1 : 0;
  }
  const std::size_t dot = word.find('.');
  return capitals > 1 || (dot != word.npos && dot + 1 < word.size());
}

// The words of a warning with `*` for every run of names.
std::string kind_of(const Warning& warning) {
  std::string text;
  bool quoted = false;
  for (const char c : warning.text) {
    if (c == '\'') quoted = !quoted;
    text += quoted || c == '\'' ? '_' : c;
  }
  std::istringstream words(text);
  std::string kind = warning.at.file, last;
  for (std::string word; words >> word;) {
    while (!word.empty() &&
           std::string_view(",;:().").find(word.back()) != std::string_view::npos) {
      word.pop_back();
    }
    while (!word.empty() && word.front() == '(') word.erase(0, 1);
    if (is_name(word)) word = "*";
    if (last == "*" && (word == "*" || word == "and")) continue;
    kind += " " + word;
    last = word;
  }
  return kind;
}

std::string without_folder(const Warning& warning) {
  std::string text = to_string(warning);
  const std::filesystem::path file = warning.at.file;
  if (!file.has_parent_path() || !file.has_filename()) return text;
  const std::string path = file.string(), name = file.filename().string();
  for (std::size_t at = text.find(path); at != text.npos; at = text.find(path, at + name.size())) {
    text.replace(at, path.size(), name);
  }
  return text;
}

}  // namespace

void watch_interrupts() { std::signal(SIGINT, on_interrupt); }

bool interrupted() { return g_interrupts > 0; }

std::vector<std::string> warning_lines(const std::vector<Warning>& warnings) {
  struct Group {
    const Warning* first;
    std::string kind;
    int more = 0;
  };
  std::vector<Group> groups;
  for (const Warning& warning : warnings) {
    const std::string kind = kind_of(warning);
    const auto same = std::find_if(groups.begin(), groups.end(),
                                   [&](const Group& group) { return group.kind == kind; });
    if (same == groups.end()) {
      groups.push_back({&warning, kind});
    } else {
      ++same->more;
    }
  }
  std::vector<std::string> lines;
  for (const Group& group : groups) {
    lines.push_back(without_folder(*group.first) +
                    (group.more > 0 ? fmt::format(" (and {} more like it)", group.more) : ""));
  }
  return lines;
}

void report(std::vector<Warning>& all, const std::vector<Warning>& more) {
  std::vector<Warning> fresh;
  for (const Warning& warning : more) {
    if (std::find(all.begin(), all.end(), warning) != all.end()) continue;
    all.push_back(warning);
    fresh.push_back(warning);
  }
  for (const std::string& line : warning_lines(fresh)) fmt::print(stderr, "warning: {}\n", line);
}

std::function<bool(int, int)> progress_bar(std::string what, std::string steps) {
  struct State {
    std::string what, steps;
    std::chrono::steady_clock::time_point start = std::chrono::steady_clock::now();
    std::chrono::steady_clock::time_point last = start;
    bool shown = false;
  };
  watch_interrupts();
  auto state = std::make_shared<State>();
  state->what = std::move(what);
  state->steps = std::move(steps);
  return [state](int done, int total) {
    using namespace std::chrono_literals;
    const auto now = std::chrono::steady_clock::now();
    const bool finished = done >= total;
    if (now - state->start > 2s && (now - state->last > 200ms || (finished && state->shown))) {
      fmt::print(stderr, "\r{}: {} of {} {}{}", state->what, done, total, state->steps,
                 finished ? "\n" : "");
      std::fflush(stderr);
      state->last = now;
      state->shown = true;
    }
    if (interrupted() && state->shown && !finished) fmt::print(stderr, "\n");
    return !interrupted();
  };
}

}  // namespace sinew
