#include <string>

#include "model/osim_file.h"
#include "tests/fuzz/reading.h"

using namespace sinew;

namespace {

// Nodes of an XML document take 64 bytes and more where the file has 4, `<a/>`; elements of a model
// hundreds.
constexpr std::size_t kConstant = std::size_t{16} << 20;

void check(const MusculoskeletalModel& model) {
  for (std::size_t i = 0; i < model.joints.size(); ++i) {
    const Joint& joint = model.joints[i];
    const int bodies = static_cast<int>(model.bodies.size());
    fuzz::require(joint.parent >= 0 && joint.parent < joint.child && joint.child < bodies,
                  "bodies stand after their parents");
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::filesystem::path path = fuzz::as_file(data, size);
  try {
    const fuzz::MemoryLimit limit(fuzz::allowance(size, kConstant));
    check(read_osim(path));
  } catch (const InputError&) {
  }
  return 0;
}
