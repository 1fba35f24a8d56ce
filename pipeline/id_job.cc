#include "pipeline/id_job.h"

#include "data/storage_file.h"
#include "data/tool_setup.h"
#include "pipeline/ik_job.h"

namespace sinew {

ExternalLoads read_loads(const MusculoskeletalModel& model, const std::filesystem::path& setup_file,
                         std::filesystem::path& data_file, std::vector<Warning>& warnings) {
  if (setup_file.empty()) {
    warnings.push_back(
        {{"inverse dynamics"},
         "no external loads are given: whatever carries the body is missing, and the "
         "root's residuals hold its weight"});
    return {};
  }
  ExternalLoadsSetup setup = read_external_loads(setup_file);
  if (data_file.empty()) {
    require_file(setup.data_file, location_of(setup, "datafile"), "datafile");
    data_file = setup.data_file;
  }
  const TimeTableFile data = read_storage(data_file);
  bind_columns(setup, data.table.labels, data_file.string());
  ExternalLoads loads(model, setup, data);
  for (const std::vector<Warning>* more : std::initializer_list<const std::vector<Warning>*>{
           &setup.warnings, &data.warnings, &loads.warnings()}) {
    warnings.insert(warnings.end(), more->begin(), more->end());
  }
  return loads;
}

}  // namespace sinew
