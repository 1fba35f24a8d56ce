#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>

#include "data/marker_trajectories.h"

/// What the fuzzers share. An input that a reader refuses with an InputError is fine; everything
/// else that it throws, a crash, a time-out, too much memory and a result that contradicts itself
/// are findings.
namespace sinew::fuzz {

/// The input as a file that lies in memory. The path is the same for every call.
std::filesystem::path as_file(const std::uint8_t* data, std::size_t size);

/// While it lives: stops the program with the stack of the allocation by which all memory that was
/// allocated since then, and is not free again, exceeds so many bytes.
class MemoryLimit {
 public:
  explicit MemoryLimit(std::size_t bytes);
  ~MemoryLimit();
  MemoryLimit(const MemoryLimit&) = delete;
  MemoryLimit& operator=(const MemoryLimit&) = delete;
};

/// What a reader may hold at once: four times its file and a constant, stated by each fuzzer, for
/// blocks that it reads by and for what grows faster than that in small files. A cell of a table
/// takes two bytes at least, but 8 in memory, thrice that while its vector grows; files of a few
/// 10 kB make less than 2 MB of that, and 16 MB a C3D file never holds.
inline std::size_t allowance(std::size_t file_bytes, std::size_t constant) {
  return 4 * file_bytes + constant;
}

/// Stops the program, naming `what`, if `holds` is false.
void require(bool holds, const char* what);

/// That each frame has a time, later than the one before, and each marker a position in it, whole
/// or missing, at a rate.
void require_trajectories(const MarkerTrajectories& markers);

}  // namespace sinew::fuzz
