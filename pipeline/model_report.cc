#include "pipeline/model_report.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace sinew {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kDegrees = 180.0 / std::numbers::pi;

const char* kind_name(Joint::Kind kind) {
  static constexpr const char* kNames[] = {"weld",   "pin",    "slider", "universal", "ball",
                                           "gimbal", "planar", "free",   "ellipsoid", "custom"};
  return kNames[static_cast<int>(kind)];
}

const char* motion_name(Coordinate::Motion motion) {
  static constexpr const char* kNames[] = {"rotational", "translational", "coupled"};
  return kNames[static_cast<int>(motion)];
}

const CoordinateCoupler* coupler_of(const MusculoskeletalModel& model, int coordinate) {
  const auto found =
      std::find_if(model.couplers.begin(), model.couplers.end(),
                   [&](const CoordinateCoupler& c) { return c.dependent == coordinate; });
  return found == model.couplers.end() ? nullptr : &*found;
}

std::string coordinate_text(const MusculoskeletalModel& model, int index) {
  const Coordinate& c = model.coordinates[static_cast<std::size_t>(index)];
  if (const CoordinateCoupler* coupler = coupler_of(model, index)) {
    const auto source = static_cast<std::size_t>(coupler->independent);
    return fmt::format("{} (follows {})", c.name, model.coordinates[source].name);
  }
  return c.name + (c.locked ? " (locked)" : c.prescribed ? " (prescribed)" : "");
}

std::string tree_row(const MusculoskeletalModel& model, const ModelSummary& summary,
                     std::size_t j) {
  const Joint& joint = model.joints[j];
  const Body& body = model.bodies[j + 1];
  std::string coordinates;
  if (body.virtual_link && joint.coordinates.size() == 6) {
    coordinates = coordinate_text(model, joint.coordinates.front()) + " ... " +
                  coordinate_text(model, joint.coordinates.back());
  } else {
    for (const int c : joint.coordinates) {
      coordinates += (coordinates.empty() ? "" : ", ") + coordinate_text(model, c);
    }
  }
  const std::string name =
      std::string(2 * static_cast<std::size_t>(summary.depth[j]), ' ') + body.name;
  const std::string mass = body.virtual_link ? "virtual" : fmt::format("{:.4f}", body.mass);
  return fmt::format("{:<36} {:>9} {:>6} {:<9} {}", name, mass, summary.crossing_paths[j],
                     kind_name(joint.kind), coordinates);
}

// Outward from a body, each branch to its end before the next.
void append_tree(const MusculoskeletalModel& model, const ModelSummary& summary, int parent,
                 std::string& text) {
  for (std::size_t j = 0; j < model.joints.size(); ++j) {
    if (model.joints[j].parent != parent) continue;
    std::string row = tree_row(model, summary, j);
    row.erase(row.find_last_not_of(' ') + 1);
    text += row + "\n";
    append_tree(model, summary, model.joints[j].child, text);
  }
}

// Endless bounds have no number in JSON.
Json bound(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

Json coordinate_json(const MusculoskeletalModel& model, int index) {
  const Coordinate& c = model.coordinates[static_cast<std::size_t>(index)];
  Json json = {{"name", c.name},
               {"motion", motion_name(c.motion)},
               {"default", c.default_value},
               {"range", {bound(c.range_min), bound(c.range_max)}},
               {"clamped", c.clamped},
               {"locked", c.locked},
               {"prescribed", c.prescribed.has_value()}};
  if (const CoordinateCoupler* coupler = coupler_of(model, index)) {
    json["follows"] = model.coordinates[static_cast<std::size_t>(coupler->independent)].name;
  }
  return json;
}

}  // namespace

std::string info_text(const MusculoskeletalModel& model, const ModelSummary& summary) {
  std::string text = fmt::format(
      "{}: {} degrees of freedom ({} of them locked, {} coordinates coupled), {} bodies, {} "
      "virtual links, {} wires, {} markers, {:.3f} kg\n"
      "paths: {} muscles, {} tendons, {} ligaments, {} actuators\n\n",
      model.name, summary.dof, summary.locked, summary.coupled, summary.bodies,
      summary.virtual_links, summary.wires, summary.markers, summary.mass, summary.muscles,
      summary.tendons, summary.ligaments, summary.actuators);
  text += fmt::format("{:<36} {:>9} {:>6} {:<9} {}\n", "body", "mass kg", "paths", "joint",
                      "coordinates");
  append_tree(model, summary, 0, text);
  return text;
}

Json info_json(const MusculoskeletalModel& model, const ModelSummary& summary) {
  Json json = {{"name", model.name},
               {"dof", summary.dof},
               {"bodies", summary.bodies},
               {"virtual_links", summary.virtual_links},
               {"wires", summary.wires},
               {"markers", summary.markers},
               {"mass", summary.mass},
               {"locked", summary.locked},
               {"coupled", summary.coupled},
               {"paths",
                {{"muscles", summary.muscles},
                 {"tendons", summary.tendons},
                 {"ligaments", summary.ligaments},
                 {"actuators", summary.actuators}}}};
  Json tree = Json::array();
  for (std::size_t j = 0; j < model.joints.size(); ++j) {
    const Joint& joint = model.joints[j];
    const Body& body = model.bodies[j + 1];
    Json coordinates = Json::array();
    for (const int c : joint.coordinates) coordinates.push_back(coordinate_json(model, c));
    tree.push_back({{"body", body.name},
                    {"parent", model.bodies[static_cast<std::size_t>(joint.parent)].name},
                    {"joint", joint.name},
                    {"kind", kind_name(joint.kind)},
                    {"mass", body.mass},
                    {"virtual_link", body.virtual_link},
                    {"crossing_paths", summary.crossing_paths[j]},
                    {"coordinates", coordinates}});
  }
  json["tree"] = tree;
  return json;
}

std::string moment_arm_text(const MusculoskeletalModel& model, const MomentArmTable& table) {
  const Coordinate& c = model.coordinates[static_cast<std::size_t>(table.coordinate)];
  const bool shift = c.motion == Coordinate::Motion::kTranslational;
  const bool turn = c.motion == Coordinate::Motion::kRotational;
  std::string text = fmt::format("\nmoment arms about {} [{}], {} of {} paths\n{:<28}", c.name,
                                 turn ? "mm" : "mm a unit", table.rows.size(), model.paths.size(),
                                 turn    ? "deg"
                                 : shift ? "mm"
                                         : "value");
  for (const double value : table.values) {
    text += fmt::format(" {:8.1f}", value * (turn ? kDegrees : shift ? 1e3 : 1.0));
  }
  text += '\n';
  for (const MomentArmTable::Row& row : table.rows) {
    text += fmt::format("{:<28}", model.paths[static_cast<std::size_t>(row.path)].name);
    for (const double arm : row.arms) text += fmt::format(" {:8.2f}", 1e3 * arm);
    text += '\n';
  }
  return text;
}

Json moment_arm_json(const MusculoskeletalModel& model, const MomentArmTable& table) {
  Json paths = Json::array();
  for (const MomentArmTable::Row& row : table.rows) {
    paths.push_back({{"path", model.paths[static_cast<std::size_t>(row.path)].name},
                     {"lengths", row.lengths},
                     {"arms", row.arms}});
  }
  return {{"coordinate", model.coordinates[static_cast<std::size_t>(table.coordinate)].name},
          {"values", table.values},
          {"paths", paths}};
}

std::ptrdiff_t count(const std::vector<ModelFinding>& findings, ModelFinding::Severity severity) {
  return std::count_if(findings.begin(), findings.end(),
                       [&](const ModelFinding& f) { return f.severity == severity; });
}

std::string findings_text(const std::vector<ModelFinding>& findings) {
  std::string text;
  for (const ModelFinding& f : findings) {
    text += fmt::format("{}: {}: {}: {}", to_string(f.severity), f.kind, f.element, f.text);
    text += f.source.file.empty() ? "\n" : fmt::format(" ({})\n", to_string(f.source));
  }
  using Severity = ModelFinding::Severity;
  return text + fmt::format("{} errors, {} warnings, {} notes\n", count(findings, Severity::kError),
                            count(findings, Severity::kWarning), count(findings, Severity::kNote));
}

Json findings_json(const std::vector<ModelFinding>& findings) {
  using Severity = ModelFinding::Severity;
  Json rows = Json::array();
  for (const ModelFinding& f : findings) {
    rows.push_back({{"severity", to_string(f.severity)},
                    {"kind", f.kind},
                    {"element", f.element},
                    {"text", f.text},
                    {"file", f.source.file},
                    {"line", f.source.line}});
  }
  return {{"errors", count(findings, Severity::kError)},
          {"warnings", count(findings, Severity::kWarning)},
          {"notes", count(findings, Severity::kNote)},
          {"findings", rows}};
}

std::string furcations_text(const std::vector<Furcation>& furcations) {
  std::string text = fmt::format("{:<28} {:<10} {:>9} {:>9}  {}\n", "virtual link", "bone",
                                 "tendon mm", "spread mm", "muscles");
  for (const Furcation& f : furcations) {
    text += fmt::format("{:<28} {:<10} {:9.1f} {:9.1f}  {}{}\n", f.virtual_link, f.bone,
                        1e3 * f.tendon_length, 1e3 * f.spread, fmt::join(f.muscles, ", "),
                        f.insertion ? "" : " (origins)");
  }
  return text;
}

}  // namespace sinew
