#include "pipeline/ground_reaction.h"

#include <fmt/format.h>

#include <stdexcept>

#include "data/external_loads_writer.h"
#include "data/marker_names.h"
#include "data/output_file.h"
#include "data/storage_file.h"
#include "data/text.h"

namespace sinew {
namespace {

bool is_foot(const std::string& body) {
  for (const char* word : {"calcn", "toes", "foot", "talus", "calcaneus"}) {
    if (body.find(word) != body.npos) return true;
  }
  return false;
}

std::vector<Foot> feet_of_model(const MarkerTrajectories& markers,
                                const MusculoskeletalModel& model) {
  std::vector<Foot> feet = {{"right", "", {}}, {"left", "", {}}};
  for (const Body& body : model.bodies) {
    const std::string name = text::lower(body.name);
    const Side side = parse_marker_name(body.name).side;
    if (!is_foot(name) || side == Side::kNone) continue;
    Foot& foot = feet[side == Side::kRight ? 0 : 1];
    if (foot.body.empty() || name.find("calc") != name.npos) foot.body = body.name;
  }
  for (const Marker& marker : model.markers) {
    const std::string body = model.bodies[static_cast<std::size_t>(marker.body)].name;
    const Side side = parse_marker_name(body).side;
    const int index = markers.find_marker(marker.name);
    if (index < 0 || !is_foot(text::lower(body)) || side == Side::kNone) continue;
    feet[side == Side::kRight ? 0 : 1].markers.push_back(index);
  }
  std::erase_if(feet, [](const Foot& foot) { return foot.markers.empty(); });
  return feet;
}

}  // namespace

std::vector<Foot> feet_of(const MarkerTrajectories& markers, const std::string& path,
                          const MusculoskeletalModel* model) {
  std::vector<Foot> feet;
  if (model) feet = feet_of_model(markers, *model);
  if (feet.empty()) feet = find_feet(markers);
  if (!feet.empty()) return feet;
  throw InputError({path}, {"no marker's name tells a right or left foot",
                            "names such as RHEE, LTOE, R.Heel, or those of a model's foot markers",
                            "", "Rename markers, or give the loads by --loads."});
}

std::vector<AssignmentOverride> parse_overrides(const std::vector<std::string>& texts) {
  std::vector<AssignmentOverride> overrides;
  for (const std::string& text : texts) {
    const std::optional<AssignmentOverride> parsed = parse_override(text);
    if (!parsed) {
      throw std::invalid_argument(
          fmt::format("--assign {} is not PLATE:FOOT or PLATE:FOOT@FROM-TO, such as 1:right or "
                      "2:none@0.5-1.2",
                      text));
    }
    for (const AssignmentOverride& other : overrides) {
      const bool same = other.plate == parsed->plate && other.from == parsed->from &&
                        other.to == parsed->to && other.foot != parsed->foot;
      if (!same) continue;
      throw std::invalid_argument(
          fmt::format("--assign {} contradicts another one, which says {} for the same time: give "
                      "one of them",
                      text, other.foot));
    }
    overrides.push_back(*parsed);
  }
  return overrides;
}

std::filesystem::path contacts_path(const std::filesystem::path& data_file) {
  return data_file.parent_path() / (data_file.stem().string() + "_contacts.csv");
}

void write_ground_reactions(const FootAssignment& assignment,
                            const std::vector<ForcePlatformRecording>& plates,
                            const TimeTable& loads, const std::filesystem::path& data_file,
                            const std::filesystem::path& setup_file) {
  ExternalLoadsSetup setup;
  setup.data_file = data_file;
  for (const Foot& foot : assignment.feet) {
    ExternalForce force;
    force.name = foot.name;
    force.applied_to_body = foot.body;
    force.force_identifier = foot.name + "_force_v";
    force.point_identifier = foot.name + "_force_p";
    force.torque_identifier = foot.name + "_torque_";
    setup.forces.push_back(force);
  }
  write_storage(data_file, loads);
  write_external_loads(setup_file, setup);
  write_file_atomically(contacts_path(data_file), contacts_csv(assignment, plates));
}

}  // namespace sinew
