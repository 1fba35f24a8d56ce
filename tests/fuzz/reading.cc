#include "tests/fuzz/reading.h"

#include <sanitizer/allocator_interface.h>
#include <sanitizer/common_interface_defs.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>

namespace sinew::fuzz {
namespace {

// The fuzzers have one thread.
bool limited = false;
std::ptrdiff_t live = 0, limit = 0;

void on_malloc(const volatile void*, std::size_t size) {
  if (!limited) return;
  live += static_cast<std::ptrdiff_t>(size);
  if (live <= limit) return;
  limited = false;  // what follows may allocate
  std::fprintf(stderr, "an allocation of %zu bytes makes %td, where %td are allowed\n", size, live,
               limit);
  __sanitizer_print_stack_trace();
  std::abort();
}

void on_free(const volatile void* memory) {
  if (!limited || memory == nullptr) return;
  live -=
      static_cast<std::ptrdiff_t>(__sanitizer_get_allocated_size(const_cast<const void*>(memory)));
}

}  // namespace

std::filesystem::path as_file(const std::uint8_t* data, std::size_t size) {
  static const int file = ::memfd_create("input", MFD_CLOEXEC);
  require(file >= 0 && ::ftruncate(file, 0) == 0 &&
              ::pwrite(file, data, size, 0) == static_cast<ssize_t>(size),
          "no file in memory");
  return "/proc/self/fd/" + std::to_string(file);
}

MemoryLimit::MemoryLimit(std::size_t bytes) {
  static const int hooked = __sanitizer_install_malloc_and_free_hooks(on_malloc, on_free);
  require(hooked != 0, "the sanitizer takes no hooks");
  live = 0;
  limit = static_cast<std::ptrdiff_t>(bytes);
  limited = true;
}

MemoryLimit::~MemoryLimit() { limited = false; }

void require(bool holds, const char* what) {
  if (holds) return;
  std::fprintf(stderr, "does not hold: %s\n", what);
  std::abort();
}

void require_trajectories(const MarkerTrajectories& markers) {
  const Eigen::Index frames = markers.time.size();
  require(markers.p_WM.rows() == frames && markers.p_WM.cols() == 3 * markers.marker_count(),
          "a position for each frame and marker");
  require(std::isfinite(markers.rate) && markers.rate > 0.0, "a rate");
  for (Eigen::Index i = 1; i < frames; ++i) {
    require(markers.time[i] > markers.time[i - 1], "time increases");
  }
  for (int frame = 0; frame < frames; ++frame) {
    for (int marker = 0; marker < markers.marker_count(); ++marker) {
      const Eigen::Vector3d p = markers.position(frame, marker);
      require(p.allFinite() || p.array().isNaN().all(), "a position whole or missing");
    }
  }
}

}  // namespace sinew::fuzz
