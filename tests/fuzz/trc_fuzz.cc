#include "data/trc_file.h"
#include "tests/fuzz/reading.h"

using namespace sinew;

namespace {

// Rows that end early are padded by up to 8 MiB, in a vector that is copied when it grows.
constexpr std::size_t kConstant = std::size_t{32} << 20;

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::filesystem::path path = fuzz::as_file(data, size);
  try {
    const fuzz::MemoryLimit limit(fuzz::allowance(size, kConstant));
    const MarkerTrajectories markers = read_trc(path).markers;
    fuzz::require(markers.frame_count() > 0, "a frame");
    fuzz::require_trajectories(markers);
  } catch (const InputError&) {
  }
  return 0;
}
