#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdlib>

#if defined(__SANITIZE_ADDRESS__)
#include "tests/data/sanitizer_hooks.h"
#else
#include <malloc.h>
#endif

/// The most memory that was live at once. Stands in for malloc, so that one source of a program may
/// include this; a sanitizer has hooks instead.
namespace sinew::live_memory {

inline thread_local bool counting = false;
inline thread_local std::ptrdiff_t live = 0, peak = 0;

inline void add(std::size_t size) {
  if (!counting) return;
  live += static_cast<std::ptrdiff_t>(size);
  peak = std::max(peak, live);
}
inline void remove(std::size_t size) {
  if (counting) live -= static_cast<std::ptrdiff_t>(size);
}

/// Of this thread during `action`, beyond what was live before [bytes].
template <typename Action>
std::ptrdiff_t peak_in(const Action& action) {
  struct Counting {
    Counting() {
      live = peak = 0;
      counting = true;
    }
    ~Counting() { counting = false; }  // also if it throws
  } until_the_end;
  action();
  return peak;
}

}  // namespace sinew::live_memory

#if defined(__SANITIZE_ADDRESS__)

namespace sinew::live_memory {

inline const int hooked = __sanitizer_install_malloc_and_free_hooks(
    [](const volatile void*, std::size_t size) { add(size); },
    [](const volatile void* memory) {
      if (counting && memory) remove(__sanitizer_get_allocated_size(memory));
    });

}  // namespace sinew::live_memory

#else

// glibc's own names for what its malloc family does.
extern "C" {
void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);
void* __libc_memalign(std::size_t, std::size_t);
void __libc_free(void*);

inline void* counted(void* memory) {
  if (memory) sinew::live_memory::add(malloc_usable_size(memory));
  return memory;
}
void* malloc(std::size_t size) noexcept { return counted(__libc_malloc(size)); }
void* calloc(std::size_t items, std::size_t size) noexcept {
  return counted(__libc_calloc(items, size));
}
void* realloc(void* old, std::size_t size) noexcept {
  if (old) sinew::live_memory::remove(malloc_usable_size(old));
  return counted(__libc_realloc(old, size));
}
void* aligned_alloc(std::size_t alignment, std::size_t size) noexcept {
  return counted(__libc_memalign(alignment, size));
}
void free(void* memory) noexcept {
  if (memory) sinew::live_memory::remove(malloc_usable_size(memory));
  __libc_free(memory);
}
}

#endif
