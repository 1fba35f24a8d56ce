#include <cmath>

#include "data/storage_file.h"
#include "tests/fuzz/reading.h"

using namespace sinew;

namespace {

// A block of 1 MiB, and 24 bytes for the 2 of a cell.
constexpr std::size_t kConstant = std::size_t{4} << 20;

void check(const TimeTable& table) {
  const Eigen::Index rows = table.time.size();
  fuzz::require(table.values.rows() == rows &&
                    table.values.cols() == static_cast<Eigen::Index>(table.labels.size()),
                "a value for each row and label");
  for (Eigen::Index i = 0; i < rows; ++i) {
    fuzz::require(std::isfinite(table.time[i]), "times are numbers");
    fuzz::require(i == 0 || table.time[i] >= table.time[i - 1], "time does not decrease");
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::filesystem::path path = fuzz::as_file(data, size);
  try {
    const fuzz::MemoryLimit limit(fuzz::allowance(size, kConstant));
    check(read_storage(path).table);
  } catch (const InputError&) {
  }
  return 0;
}
