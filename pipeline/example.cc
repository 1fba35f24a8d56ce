#include "pipeline/example.h"

#include <fmt/format.h>

#include <numbers>
#include <string>

#include "data/c3d_writer.h"
#include "data/external_loads_writer.h"
#include "data/output_file.h"
#include "data/reference_laboratory.h"
#include "data/reference_walk.h"
#include "data/storage_file.h"
#include "data/trc_file.h"
#include "model/osim_writer.h"
#include "pipeline/walk_tasks.h"

namespace sinew {
namespace {

std::string document(const std::string& content) {
  return "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<OpenSimDocument Version=\"40000\">\n" +
         content + "</OpenSimDocument>\n";
}

std::string document(const IkTaskSet& set) {
  std::string text = "  <IKTaskSet name=\"walk\">\n    <objects>\n";
  for (const IkTask& task : set.tasks) {
    const bool marker = task.kind == IkTask::Kind::kMarker;
    text += fmt::format(
        "      <{0} name=\"{1}\">\n"
        "        <apply>true</apply>\n"
        "        <weight>{2}</weight>\n"
        "{3}"
        "      </{0}>\n",
        marker ? "IKMarkerTask" : "IKCoordinateTask", task.name, task.weight,
        marker ? "" : "        <value_type>default_value</value_type>\n");
  }
  return document(text + "    </objects>\n  </IKTaskSet>\n");
}

std::string time_range(const TimeTable& table) {
  return fmt::format("{} {}", table.time[0], table.time[table.time.size() - 1]);
}

std::string ik_setup(const TimeTable& truth) {
  return document(
      fmt::format("  <InverseKinematicsTool name=\"walk\">\n"
                  "    <results_directory>./</results_directory>\n"
                  "    <model_file>model.osim</model_file>\n"
                  "    <constraint_weight>Inf</constraint_weight>\n"
                  "    <accuracy>1e-9</accuracy>\n"
                  "    <IKTaskSet file=\"ik_tasks.xml\"/>\n"
                  "    <marker_file>walk.trc</marker_file>\n"
                  "    <time_range>{}</time_range>\n"
                  "    <output_motion_file>ik.mot</output_motion_file>\n"
                  "  </InverseKinematicsTool>\n",
                  time_range(truth)));
}

// Markers without noise need no filter, and one would take part of the motion away.
std::string id_setup(const TimeTable& truth) {
  return document(fmt::format(
      "  <InverseDynamicsTool name=\"walk\">\n"
      "    <results_directory>./</results_directory>\n"
      "    <model_file>model.osim</model_file>\n"
      "    <time_range>{}</time_range>\n"
      "    <forces_to_exclude>Muscles</forces_to_exclude>\n"
      "    <external_loads_file>grf.xml</external_loads_file>\n"
      "    <coordinates_file>truth_ik.mot</coordinates_file>\n"
      "    <lowpass_cutoff_frequency_for_coordinates>-1</lowpass_cutoff_frequency_for_coordinates>"
      "\n"
      "    <output_gen_force_file>id.sto</output_gen_force_file>\n"
      "  </InverseDynamicsTool>\n",
      time_range(truth)));
}

TimeTable in_degrees(const MusculoskeletalModel& model, TimeTable table) {
  for (std::size_t c = 0; c < model.coordinates.size(); ++c) {
    if (model.coordinates[c].motion != Coordinate::Motion::kRotational) continue;
    table.values.col(static_cast<Eigen::Index>(c)) *= 180.0 / std::numbers::pi;
  }
  table.in_degrees = true;
  return table;
}

}  // namespace

std::vector<Warning> write_example(const std::filesystem::path& folder,
                                   const ExampleOptions& options) {
  const MusculoskeletalModel body = whole_body(options.body);
  const ReferenceWalk walk = reference_walk();
  const ReferenceRecording recording = make_reference_recording(body, walk, options.recording);
  const MarkerTrajectories standing = make_static_recording(body, options.recording);
  write_file_atomically(folder / "model.osim", write_osim(body));
  write_trc(folder / "walk.trc", recording.markers);
  write_trc(folder / "static.trc", standing);
  write_storage(folder / "grf.mot", recording.forces);
  ExternalLoadsSetup loads = recording.loads;
  loads.data_file = folder / "grf.mot";
  write_external_loads(folder / "grf.xml", loads);
  write_file_atomically(folder / "ik_tasks.xml", document(walk_tasks(body)));
  write_file_atomically(folder / "ik_setup.xml", ik_setup(recording.true_coordinates));
  write_file_atomically(folder / "id_setup.xml", id_setup(recording.true_coordinates));
  write_storage(folder / "truth_ik.mot", in_degrees(body, recording.true_coordinates));
  write_storage(folder / "truth_speeds.sto", in_degrees(body, recording.true_speeds));
  write_storage(folder / "truth_accelerations.sto", in_degrees(body, recording.true_accelerations));
  write_storage(folder / "truth_id.sto", recording.true_forces);
  write_c3d(folder / "static.c3d", reference_laboratory(standing));
  const double duration = recording.markers.time[recording.markers.time.size() - 1];
  const std::filesystem::path laboratory = folder / "walk.c3d";
  if (const std::size_t steps = steps_of(walk, duration).size(); steps > kMaxPlatforms) {
    return {{{laboratory.string()},
             fmt::format("not written: {} steps need more than the {} force platforms that a C3D "
                         "file describes; --strides makes fewer",
                         steps, kMaxPlatforms)}};
  }
  write_c3d(laboratory, reference_laboratory(walk, recording.markers, recording.forces));
  return {};
}

}  // namespace sinew
