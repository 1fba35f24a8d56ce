#pragma once

#include <filesystem>

namespace sinew {

/// Writes the embedded walk as files: model.osim, walk.trc, grf.mot, grf.xml (ExternalLoads),
/// ik_tasks.xml, ik_setup.xml, id_setup.xml and the truth, truth_ik.mot and truth_id.sto.
/// Throws InputError if the folder cannot be written.
void write_example(const std::filesystem::path& folder);

}  // namespace sinew
