#include <fmt/format.h>

#include <string_view>

#include "data/setup_fields.h"
#include "data/tool_setup.h"

namespace sinew {
namespace {

namespace fs = std::filesystem;

// OpenSim adds the ending where the name has none.
fs::path output_path(const fs::path& folder, std::string name) {
  if (name.find(".sto") == name.npos) name += ".sto";
  return folder.is_absolute() ? resolve_setup_path(name, folder / "setup") : folder / name;
}

// OpenSim 1 and 2 had inverse dynamics as an analysis of the AnalyzeTool.
void check_analysis(const XmlFile& xml, pugi::xml_node tool) {
  if (tool.child("AnalysisSet").child("objects").child("InverseDynamics")) return;
  xml.fail(tool, {"the AnalyzeTool does no inverse dynamics",
                  "<InverseDynamics> in its <AnalysisSet>, or an <InverseDynamicsTool>", "",
                  "Name the setup file of an inverse dynamics."});
}

void read_times(const XmlFile& xml, bool analyze, SetupFields& fields, IdSetup& setup) {
  if (!analyze) {
    std::tie(setup.from, setup.to) = fields.time_range("time_range");
    return;
  }
  setup.from = fields.number("initial_time");
  setup.to = fields.number("final_time");
  if (setup.from && setup.to && *setup.from > *setup.to) {
    xml.fail(fields.find("final_time"),
             {"<final_time> is before <initial_time>", fmt::format("at least {}", *setup.from),
              fmt::format("{}", *setup.to), "Correct the times."});
  }
}

}  // namespace

IdSetup read_id_setup(const fs::path& path) {
  const XmlFile xml(path);
  const pugi::xml_node tool = find_tool(xml, {"InverseDynamicsTool", "AnalyzeTool"});
  const bool analyze = std::string_view(tool.name()) == "AnalyzeTool";
  if (analyze) check_analysis(xml, tool);
  IdSetup setup;
  setup.path = xml.path();
  setup.name = tool.attribute("name").value();
  SetupFields fields(xml, {tool}, setup.lines);
  setup.model_file = fields.file("model_file");
  setup.external_loads_file = fields.file("external_loads_file");
  setup.coordinates_file = fields.file("coordinates_file");
  setup.results_directory = fields.file("results_directory");
  if (setup.results_directory.empty()) setup.results_directory = resolve_setup_path(".", path);
  std::string output = fields.text("output_gen_force_file");
  if (output.empty()) output = analyze ? setup.name + "_InverseDynamics" : "inverse_dynamics.sto";
  setup.output_file = output_path(setup.results_directory, output);
  read_times(xml, analyze, fields, setup);
  setup.cutoff = fields.number("lowpass_cutoff_frequency_for_coordinates").value_or(setup.cutoff);
  setup.forces_to_exclude = fields.words("forces_to_exclude");
  if (const pugi::xml_node node = fields.find("coordinates_in_degrees")) {
    setup.warnings.push_back(
        {xml.location(node),
         "<coordinates_in_degrees> is not read, as OpenSim no longer reads it; "
         "the header of the coordinates_file decides"});
  }
  return setup;
}

}  // namespace sinew
