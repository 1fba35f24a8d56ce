#include "tests/data/corruption.h"

#include "model/osim_file.h"
#include "model/osim_writer.h"
#include "tests/model/shared_models.h"

namespace sinew {
namespace {

// All that the reader understood, as a document, or why that cannot be written.
Reading of_model(const std::filesystem::path& path) {
  const MusculoskeletalModel model = read_osim(path);
  Reading reading;
  try {
    reading.result = write_osim(model);
  } catch (const InputError& error) {
    reading.result = error.parts().problem;
  }
  for (const Warning& warning : model.warnings) reading.flags += warning.text + "\n";
  for (const UnsupportedElement& element : model.unsupported) reading.flags += element.name + "\n";
  return reading;
}

TEST(Corruption, Models) {
  SINEW_SKIP_WITHOUT_SHARED_DATA();
  // The nodes of the document, the model and what is written of it.
  Battery battery("models", of_model, 12.0, 4 << 20);
  for (const auto& path : shared_models()) battery.run(path);
  battery.report();
}

}  // namespace
}  // namespace sinew
