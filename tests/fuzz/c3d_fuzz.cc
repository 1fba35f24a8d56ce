#include "data/c3d_file.h"
#include "data/force_platform.h"
#include "tests/fuzz/reading.h"

using namespace sinew;

namespace {

// Blocks of 1 MiB, and 20 bytes for the 2 of a frame that holds one sample.
constexpr std::size_t kConstant = std::size_t{4} << 20;

void check(const C3dFile& file) {
  const MarkerTrajectories& markers = file.markers;
  const Eigen::Index frames = markers.time.size();
  fuzz::require(file.layout.frames == frames, "as many frames as the layout says");
  fuzz::require_trajectories(markers);
  fuzz::require(markers.frame_numbers.size() == static_cast<std::size_t>(frames),
                "a number for each frame");
  fuzz::require(file.analog.values.rows() == frames * file.layout.analog_ratio &&
                    file.analog.values.cols() == file.analog.channel_count(),
                "a sample for each frame and channel");
  fuzz::require(file.computed.values.cols() == 3 * file.computed.count(), "three numbers each");
  fuzz::require(file.metres_per_unit > 0.0, "a unit");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::filesystem::path path = fuzz::as_file(data, size);
  try {
    const fuzz::MemoryLimit limit(fuzz::allowance(size, kConstant));
    const C3dFile file = read_c3d(path);
    check(file);
    compute_forces(file);
  } catch (const InputError&) {
  }
  return 0;
}
