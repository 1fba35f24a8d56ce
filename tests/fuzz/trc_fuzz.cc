#include <cmath>

#include "data/trc_file.h"
#include "tests/fuzz/reading.h"

using namespace sinew;

namespace {

// Rows that end early are padded by up to 8 MiB, in a vector that is copied when it grows.
constexpr std::size_t kConstant = std::size_t{32} << 20;

void check(const MarkerTrajectories& markers) {
  const Eigen::Index frames = markers.time.size();
  fuzz::require(frames > 0 && markers.p_WM.rows() == frames &&
                    markers.p_WM.cols() == 3 * markers.marker_count(),
                "a position for each frame and marker");
  fuzz::require(std::isfinite(markers.rate) && markers.rate > 0.0, "a rate");
  for (Eigen::Index i = 1; i < frames; ++i) {
    fuzz::require(markers.time[i] > markers.time[i - 1], "time increases");
  }
  for (int frame = 0; frame < frames; ++frame) {
    for (int marker = 0; marker < markers.marker_count(); ++marker) {
      const Eigen::Vector3d p = markers.position(frame, marker);
      fuzz::require(p.allFinite() || p.array().isNaN().all(), "a position whole or missing");
    }
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::filesystem::path path = fuzz::as_file(data, size);
  try {
    const fuzz::MemoryLimit limit(fuzz::allowance(size, kConstant));
    check(read_trc(path).markers);
  } catch (const InputError&) {
  }
  return 0;
}
