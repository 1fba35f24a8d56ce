#pragma once

#include <cstddef>

// What AddressSanitizer's allocator offers. LLVM has these in <sanitizer/allocator_interface.h>,
// GCC 12 ships them in its library but not in a header.
extern "C" {
/// Has both called after each allocation and before each release, in the order of installation;
/// zero if there is no room for more hooks.
int __sanitizer_install_malloc_and_free_hooks(void (*malloc_hook)(const volatile void* memory,
                                                                  std::size_t size),
                                              void (*free_hook)(const volatile void* memory));
/// The size that was asked for [bytes].
std::size_t __sanitizer_get_allocated_size(const volatile void* memory);
}
