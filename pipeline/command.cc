#include "pipeline/command.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <memory>

namespace sinew {
namespace {

volatile std::sig_atomic_t g_interrupts = 0;

extern "C" void on_interrupt(int) {
  g_interrupts = 1;
  std::signal(SIGINT, SIG_DFL);
}

}  // namespace

void watch_interrupts() { std::signal(SIGINT, on_interrupt); }

bool interrupted() { return g_interrupts > 0; }

void report(std::vector<Warning>& all, const std::vector<Warning>& more) {
  for (const Warning& warning : more) {
    if (std::find(all.begin(), all.end(), warning) != all.end()) continue;
    all.push_back(warning);
    fmt::print(stderr, "warning: {}\n", to_string(warning));
  }
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
