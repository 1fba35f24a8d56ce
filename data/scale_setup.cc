#include "data/scale_setup.h"

#include <fmt/format.h>

#include <cmath>
#include <pugixml.hpp>
#include <set>
#include <sstream>
#include <string_view>

#include "data/setup_fields.h"
#include "data/text.h"

namespace sinew {
namespace {

namespace fs = std::filesystem;
using std::string_view;

std::vector<pugi::xml_node> members(pugi::xml_node set, const char* name) {
  std::vector<pugi::xml_node> nodes;
  for (const pugi::xml_node node : set.child("objects").children(name)) nodes.push_back(node);
  return nodes;
}

// Calls use(xml, set) with the set of this name where its members stand: here, or in a file of
// their own.
template <typename Use>
void with_set(const XmlFile& xml, pugi::xml_node parent, const char* name, const Use& use) {
  const pugi::xml_node set = parent.child(name);
  if (!set) return;
  const std::string file(text::trim(set.attribute("file").value()));
  if (file.empty() || text::equals_ignoring_case(file, "Unassigned")) {
    use(xml, set);
    return;
  }
  const fs::path path = resolve_setup_path(file, xml.path());
  std::error_code error;
  if (!fs::is_regular_file(path, error)) {
    xml.fail(set, {fmt::format("the file of the <{}> does not exist", name),
                   "a path, relative to the setup's folder", path.string(),
                   "Correct the attribute 'file'."});
  }
  const XmlFile own(path);
  use(own, find_tool(own, {name}));
}

ScaleMeasurement::Pair parse_pair(const XmlFile& xml, pugi::xml_node node,
                                  const std::string& measurement) {
  const std::vector<std::string> names = xml.words(node, "markers");
  if (names.size() != 2 || names[0] == names[1]) {
    xml.fail(node, {fmt::format("a marker pair of measurement '{}' is no pair", measurement),
                    "the names of two markers in <markers>", xml.text(node, "markers"),
                    "Name two different markers."});
  }
  return {names[0], names[1], xml.location(node).line};
}

BodyScale parse_body_scale(const XmlFile& xml, pugi::xml_node node) {
  BodyScale scale;
  scale.body = text::trim(node.attribute("name").value());
  scale.line = xml.location(node).line;
  if (scale.body.empty()) {
    xml.fail(node, {"a <BodyScale> has no name", "the name of a body", "", "Name the body."});
  }
  for (const std::string& word : xml.words(node, "axes")) {
    const std::string axis = text::lower(word);
    if (axis != "x" && axis != "y" && axis != "z") {
      xml.fail(node.child("axes"), {fmt::format("<axes> of body '{}' names no axis", scale.body),
                                    "X, Y or Z, separated by blanks", word, "Correct the axis."});
    }
    scale.axes[static_cast<std::size_t>(axis[0] - 'x')] = true;
  }
  return scale;
}

ScaleMeasurement parse_measurement(const XmlFile& xml, pugi::xml_node node) {
  ScaleMeasurement measurement;
  measurement.name = node.attribute("name").value();
  measurement.line = xml.location(node).line;
  measurement.apply = xml.boolean(node, "apply").value_or(true);
  for (const pugi::xml_node pair : members(node.child("MarkerPairSet"), "MarkerPair")) {
    measurement.pairs.push_back(parse_pair(xml, pair, measurement.name));
  }
  for (const pugi::xml_node body : members(node.child("BodyScaleSet"), "BodyScale")) {
    measurement.bodies.push_back(parse_body_scale(xml, body));
  }
  return measurement;
}

ScaleSet parse_scale_set(const XmlFile& xml, pugi::xml_node set) {
  ScaleSet result;
  result.path = xml.path();
  for (const pugi::xml_node node : members(set, "Scale")) {
    ManualScale scale;
    scale.body = xml.text(node, "segment");
    scale.line = xml.location(node).line;
    scale.apply = xml.boolean(node, "apply").value_or(true);
    scale.factors = xml.vector3(node, "scales").value_or(Eigen::Vector3d::Ones());
    if (scale.body.empty()) {
      xml.fail(node, {"a <Scale> names no body", "the name of a body in <segment>", "",
                      "Name the body."});
    }
    if (!scale.factors.allFinite() || !(scale.factors.minCoeff() > 0.0)) {
      xml.fail(node.child("scales"),
               {fmt::format("the factors of '{}' are no scale factors", scale.body),
                "three numbers above 0", xml.text(node, "scales"), "Correct the factors."});
    }
    result.scales.push_back(scale);
  }
  return result;
}

std::vector<ModelScalerSetup::Step> parse_order(const XmlFile& xml, pugi::xml_node scaler) {
  std::vector<ModelScalerSetup::Step> order;
  for (const std::string& word : xml.words(scaler, "scaling_order")) {
    if (word == "measurements") {
      order.push_back(ModelScalerSetup::Step::kMeasurements);
    } else if (word == "manualScale") {
      order.push_back(ModelScalerSetup::Step::kManual);
    } else {
      xml.fail(scaler.child("scaling_order"),
               {"<scaling_order> names an unknown step", "measurements, manualScale or both", word,
                "Correct the word."});
    }
  }
  return order;
}

ModelScalerSetup parse_scaler(const XmlFile& xml, pugi::xml_node node) {
  ModelScalerSetup scaler;
  scaler.path = scaler.measurement_path = xml.path();
  if (!node) return scaler;
  SetupFields fields(xml, {node}, scaler.lines);
  scaler.apply = xml.boolean(node, "apply").value_or(true);
  scaler.order = parse_order(xml, node);
  with_set(xml, node, "MeasurementSet", [&](const XmlFile& file, pugi::xml_node set) {
    scaler.measurement_path = file.path();
    for (const pugi::xml_node measurement : members(set, "Measurement")) {
      scaler.measurements.push_back(parse_measurement(file, measurement));
    }
  });
  with_set(xml, node, "ScaleSet", [&](const XmlFile& file, pugi::xml_node set) {
    scaler.manual = parse_scale_set(file, set);
  });
  scaler.marker_file = fields.file("marker_file");
  std::tie(scaler.from, scaler.to) = fields.time_range("time_range");
  scaler.preserve_mass_distribution =
      xml.boolean(node, "preserve_mass_distribution").value_or(false);
  scaler.output_model_file = fields.file("output_model_file");
  scaler.output_scale_file = fields.file("output_scale_file");
  return scaler;
}

MarkerPlacerSetup parse_placer(const XmlFile& xml, pugi::xml_node node) {
  MarkerPlacerSetup placer;
  placer.path = xml.path();
  if (!node) return placer;
  SetupFields fields(xml, {node}, placer.lines);
  placer.apply = xml.boolean(node, "apply").value_or(true);
  if (placer.apply && node.child("IKTaskSet")) placer.task_set = read_tasks_of(xml, fields, node);
  placer.marker_file = fields.file("marker_file");
  placer.coordinate_file = fields.file("coordinate_file");
  std::tie(placer.from, placer.to) = fields.time_range("time_range");
  placer.output_model_file = fields.file("output_model_file");
  placer.output_motion_file = fields.file("output_motion_file");
  placer.output_marker_file = fields.file("output_marker_file");
  const std::optional<double> movement = fields.number("max_marker_movement");
  if (movement && *movement > 0.0) placer.max_marker_movement = movement;
  return placer;
}

// A mass that is not positive means that none is known.
std::optional<double> parse_mass(const XmlFile& xml, pugi::xml_node tool) {
  const std::optional<double> mass = xml.number(tool, "mass");
  if (!mass || *mass <= 0.0) return std::nullopt;
  if (!std::isfinite(*mass)) {
    xml.fail(tool.child("mass"), {"<mass> is no mass", "kilograms, or -1 for an unknown mass",
                                  xml.text(tool, "mass"), "Correct the value."});
  }
  return mass;
}

std::vector<std::string> split_commas(std::string_view line) {
  std::vector<std::string> cells;
  while (true) {
    const std::size_t comma = line.find(',');
    cells.emplace_back(text::trim(line.substr(0, comma)));
    if (comma == line.npos) return cells;
    line.remove_prefix(comma + 1);
  }
}

ManualScale parse_row(const std::vector<std::string>& cells, const SourceLocation& at) {
  if (cells.size() != 2 && cells.size() != 4) {
    throw InputError(at, {"the row has the wrong number of cells",
                          "a body and 1 or 3 factors, separated by commas",
                          std::to_string(cells.size()), "Correct the row."});
  }
  ManualScale scale;
  scale.body = cells[0];
  scale.line = at.line;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::string& cell = cells[cells.size() == 2 ? 1 : i + 1];
    const std::optional<double> factor = text::parse_number(cell);
    if (!factor || !std::isfinite(*factor) || !(*factor > 0.0)) {
      throw InputError(at, {fmt::format("a factor of body '{}' is no scale factor", scale.body),
                            "a number above 0", cell, "Correct the factor."});
    }
    scale.factors[static_cast<Eigen::Index>(i)] = *factor;
  }
  return scale;
}

}  // namespace

ScaleSetup read_scale_setup(const fs::path& path) {
  const XmlFile xml(path);
  const pugi::xml_node tool = find_tool(xml, {"ScaleTool"});
  ScaleSetup setup;
  setup.path = xml.path();
  setup.name = tool.attribute("name").value();
  setup.mass = parse_mass(xml, tool);
  setup.generic.path = xml.path();
  SetupFields generic(xml, {tool.child("GenericModelMaker")}, setup.generic.lines);
  setup.generic.model_file = generic.file("model_file");
  setup.generic.marker_set_file = generic.file("marker_set_file");
  setup.scaler = parse_scaler(xml, tool.child("ModelScaler"));
  setup.placer = parse_placer(xml, tool.child("MarkerPlacer"));
  setup.warnings = setup.placer.task_set.warnings;
  return setup;
}

ScaleSet read_scale_set(const fs::path& path) {
  const XmlFile xml(path);
  const pugi::xml_node node = find_tool(xml, {"ScaleSet", "ScaleTool"});
  if (string_view(node.name()) == "ScaleTool") return read_scale_setup(path).scaler.manual;
  return parse_scale_set(xml, node);
}

ScaleSet read_scale_table(const fs::path& path) {
  const std::string content = text::read_text_file(path, "a table of scale factors");
  ScaleSet result;
  result.path = path.string();
  text::LineReader lines(content);
  std::set<std::string> bodies;
  bool first = true;
  while (const auto line = lines.next_filled()) {
    if (text::trim(line->text).starts_with('#')) continue;
    const std::vector<std::string> cells = split_commas(line->text);
    const bool heading = first && cells.size() > 1 && !text::parse_number(cells[1]);
    first = false;
    if (heading) continue;
    const SourceLocation at{result.path, line->number};
    result.scales.push_back(parse_row(cells, at));
    if (!bodies.insert(cells[0]).second) {
      throw InputError(at, {fmt::format("body '{}' has a second row", cells[0]), "one row a body",
                            "", "Remove one of them."});
    }
  }
  if (result.scales.empty()) {
    throw InputError({result.path},
                     {"holds no scale factors", "rows such as femur_r,1.05", "", ""});
  }
  return result;
}

std::string write_scale_set(const ScaleSet& set) {
  pugi::xml_document document;
  pugi::xml_node root = document.append_child("OpenSimDocument");
  root.append_attribute("Version").set_value(40000);
  pugi::xml_node node = root.append_child("ScaleSet");
  node.append_attribute("name").set_value("ScaleSet");
  pugi::xml_node objects = node.append_child("objects");
  for (const ManualScale& scale : set.scales) {
    pugi::xml_node entry = objects.append_child("Scale");
    std::string factors;
    for (const double f : scale.factors) {
      factors += (factors.empty() ? "" : " ") + text::format_number(f);
    }
    entry.append_child("scales").text().set(factors.c_str());
    entry.append_child("segment").text().set(scale.body.c_str());
    entry.append_child("apply").text().set(scale.apply);
  }
  std::ostringstream out;
  document.save(out, "  ");
  return out.str();
}

}  // namespace sinew
