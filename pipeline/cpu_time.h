#pragma once

#include <time.h>

namespace sinew {

/// What this process has computed so far [s]; what others compute meanwhile does not count.
inline double cpu_seconds() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

}  // namespace sinew
