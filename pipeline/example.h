#pragma once

#include <filesystem>
#include <vector>

#include "dynamics/reference_recording.h"
#include "model/whole_body.h"

namespace sinew {

struct ExampleOptions {
  WholeBodyOptions body;
  ReferenceRecordingOptions recording;
};

/// Writes the embedded walk as files: model.osim, walk.trc, static.trc, grf.mot, grf.xml
/// (ExternalLoads), ik_tasks.xml, ik_setup.xml, id_setup.xml and the truth, truth_ik.mot,
/// truth_speeds.sto, truth_accelerations.sto and truth_id.sto. The same recordings as a laboratory
/// has them are walk.c3d and static.c3d, see reference_laboratory(); a walk of too many steps for
/// the platforms of one file has no walk.c3d, which the result's warnings say.
///
/// Tasks hold the joints that the markers leave undetermined: those that the walk keeps still with
/// a marker's weight, those of the lumbar spine so weakly that markers hardly notice.
///
/// Throws InputError if the folder cannot be written, std::invalid_argument for bad options.
std::vector<Warning> write_example(const std::filesystem::path& folder,
                                   const ExampleOptions& options = {});

}  // namespace sinew
