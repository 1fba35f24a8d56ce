#include "pipeline/setup_files.h"

#include <fmt/format.h>

#include <stdexcept>

#include "data/text.h"

namespace sinew {
namespace {

std::string document(const std::string& content) {
  return "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<OpenSimDocument Version=\"40000\">\n" +
         content + "</OpenSimDocument>\n";
}

std::string escaped(const std::string& text) {
  std::string result;
  for (const char c : text) {
    if (c == '&') {
      result += "&amp;";
    } else if (c == '<') {
      result += "&lt;";
    } else if (c == '"') {
      result += "&quot;";
    } else {
      result += c;
    }
  }
  return result;
}

std::string element(const char* name, const std::string& text) {
  return fmt::format("    <{0}>{1}</{0}>\n", name, escaped(text));
}

const char* value_type(const IkTask& task) {
  return task.value_type == IkTask::ValueType::kFromFile
             ? "        <value_type>from_file</value_type>\n"
             : "        <value_type>default_value</value_type>\n";
}

std::string time_range(const std::optional<double>& from, const std::optional<double>& to) {
  if (!from || !to) return "";
  return element("time_range", text::format_number(*from) + " " + text::format_number(*to));
}

}  // namespace

std::string ik_tasks_document(const std::string& name, const std::vector<IkTask>& tasks) {
  std::string text = fmt::format("  <IKTaskSet name=\"{}\">\n    <objects>\n", escaped(name));
  for (const IkTask& task : tasks) {
    const bool marker = task.kind == IkTask::Kind::kMarker;
    text += fmt::format(
        "      <{0} name=\"{1}\">\n"
        "        <apply>{2}</apply>\n"
        "        <weight>{3}</weight>\n"
        "{4}"
        "      </{0}>\n",
        marker ? "IKMarkerTask" : "IKCoordinateTask", escaped(task.name),
        task.apply ? "true" : "false", text::format_number(task.weight),
        marker ? "" : value_type(task));
  }
  return document(text + "    </objects>\n  </IKTaskSet>\n");
}

std::string ik_setup_document(const IkSetup& setup) {
  return document(
      fmt::format("  <InverseKinematicsTool name=\"{}\">\n", escaped(setup.name)) +
      element("results_directory", "./") + element("model_file", setup.model_file.string()) +
      element("constraint_weight", "Inf") +
      element("accuracy", text::format_number(setup.accuracy)) +
      fmt::format("    <IKTaskSet file=\"{}\"/>\n", escaped(setup.task_set.path)) +
      element("marker_file", setup.marker_file.string()) +
      (setup.coordinate_file.empty() ? ""
                                     : element("coordinate_file", setup.coordinate_file.string())) +
      time_range(setup.from, setup.to) +
      element("output_motion_file", setup.output_motion_file.string()) +
      "  </InverseKinematicsTool>\n");
}

std::string id_setup_document(const IdSetup& setup) {
  return document(
      fmt::format("  <InverseDynamicsTool name=\"{}\">\n", escaped(setup.name)) +
      element("results_directory", "./") + element("model_file", setup.model_file.string()) +
      time_range(setup.from, setup.to) + element("forces_to_exclude", "Muscles") +
      element("external_loads_file", setup.external_loads_file.string()) +
      element("coordinates_file", setup.coordinates_file.string()) +
      element("lowpass_cutoff_frequency_for_coordinates", text::format_number(setup.cutoff)) +
      element("output_gen_force_file", setup.output_file.string()) + "  </InverseDynamicsTool>\n");
}

}  // namespace sinew
