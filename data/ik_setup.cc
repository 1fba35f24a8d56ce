#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <string_view>

#include "data/setup_fields.h"
#include "data/text.h"
#include "data/tool_setup.h"

namespace sinew {
namespace {

namespace fs = std::filesystem;
using std::string_view;

// The second is OpenSim's own misspelling in files it ships; the third is the tool of OpenSim 1 and
// 2, which keeps its fields in trials.
constexpr std::initializer_list<const char*> kIkTools = {"InverseKinematicsTool",
                                                         "InverseKinemtaticsTool", "IKTool"};

IkTask::ValueType parse_value_type(const XmlFile& xml, pugi::xml_node task) {
  const pugi::xml_node node = task.child("value_type");
  const std::string word = text::lower(xml.text(node));
  if (word.empty() || word == "default_value") return IkTask::ValueType::kDefault;
  if (word == "manual_value") return IkTask::ValueType::kManual;
  if (word == "from_file") return IkTask::ValueType::kFromFile;
  xml.fail(node,
           {fmt::format("<value_type> of task '{}' is not known", task.attribute("name").value()),
            "default_value, manual_value or from_file", word, "Correct the value."});
}

double parse_weight(const XmlFile& xml, pugi::xml_node node, const IkTask& task,
                    std::vector<Warning>& warnings) {
  const std::optional<double> weight = xml.number(node, "weight");
  const double value = weight.value_or(0.0);
  if (!(value >= 0.0) || std::isinf(value)) {
    xml.fail(node.child("weight"),
             {fmt::format("<weight> of task '{}' is no weight", task.name),
              "a finite number, 0 or more", xml.text(node, "weight"), "Correct the value."});
  }
  if (!weight && task.apply) {
    warnings.push_back(
        {xml.location(node),
         fmt::format("task '{}' has no weight; it gets OpenSim's default, 0", task.name)});
  }
  return value;
}

IkTask parse_task(const XmlFile& xml, pugi::xml_node node, std::vector<Warning>& warnings) {
  IkTask task;
  task.line = xml.location(node).line;
  const string_view kind = node.name();
  if (kind != "IKMarkerTask" && kind != "IKCoordinateTask") {
    xml.fail(node, {"a task of an unknown kind", "<IKMarkerTask> or <IKCoordinateTask>",
                    fmt::format("<{}>", kind), "Remove the task."});
  }
  task.kind = kind == "IKMarkerTask" ? IkTask::Kind::kMarker : IkTask::Kind::kCoordinate;
  task.name = text::trim(node.attribute("name").value());
  if (task.name.empty()) {
    xml.fail(node, {fmt::format("<{}> has no name", kind), "the attribute 'name'", "",
                    "Name the marker or the coordinate."});
  }
  task.apply = xml.boolean(node, "apply").value_or(true);
  task.weight = parse_weight(xml, node, task, warnings);
  if (task.kind == IkTask::Kind::kMarker) return task;
  task.value_type = parse_value_type(xml, node);
  task.value = xml.number(node, "value").value_or(0.0);
  if (!std::isfinite(task.value)) {
    xml.fail(node.child("value"), {fmt::format("<value> of task '{}' is not finite", task.name),
                                   "a number", xml.text(node, "value"), "Correct the value."});
  }
  return task;
}

IkTaskSet parse_task_set(const XmlFile& xml, pugi::xml_node set) {
  IkTaskSet result;
  result.path = xml.path();
  for (const pugi::xml_node node : set.child("objects").children()) {
    if (node.type() == pugi::node_element) {
      result.tasks.push_back(parse_task(xml, node, result.warnings));
    }
  }
  if (result.tasks.empty()) result.warnings.push_back({xml.location(set), "has no tasks"});
  return result;
}

// The tool itself and, in OpenSim 1 and 2, its first trial.
std::vector<pugi::xml_node> field_nodes(const XmlFile& xml, pugi::xml_node tool,
                                        std::vector<Warning>& warnings) {
  std::vector<pugi::xml_node> nodes = {tool};
  const pugi::xml_node trial = tool.child("IKTrialSet").child("objects").child("IKTrial");
  if (!trial) return nodes;
  nodes.push_back(trial);
  if (const pugi::xml_node second = trial.next_sibling("IKTrial")) {
    warnings.push_back({xml.location(second), "only the first trial of the IKTrialSet is read"});
  }
  return nodes;
}

}  // namespace

// A task set stands in the tool or in a file of its own, which cannot name a third.
IkTaskSet read_tasks_of(const XmlFile& xml, SetupFields& fields, pugi::xml_node tool) {
  pugi::xml_node set = fields.find("IKTaskSet");
  if (!set) {
    xml.fail(tool, {"the tool has no <IKTaskSet>", "tasks that say which markers to track", "",
                    "Add an <IKTaskSet>."});
  }
  const std::string file = set.attribute("file").value();
  if (text::trim(file).empty() || text::equals_ignoring_case(text::trim(file), "Unassigned")) {
    return parse_task_set(xml, set);
  }
  const fs::path path = resolve_setup_path(std::string(text::trim(file)), xml.path());
  std::error_code error;
  if (!fs::is_regular_file(path, error)) {
    xml.fail(set, {"the file of the <IKTaskSet> does not exist", "a file with the tasks",
                   path.string(), "Correct the attribute 'file'."});
  }
  const XmlFile tasks(path);
  return parse_task_set(tasks, find_tool(tasks, {"IKTaskSet"}));
}

namespace {

IkSetup parse_setup(const XmlFile& xml) {
  IkSetup setup;
  setup.path = xml.path();
  const pugi::xml_node tool = find_tool(xml, kIkTools);
  setup.name = tool.attribute("name").value();
  SetupFields fields(xml, field_nodes(xml, tool, setup.warnings), setup.lines);
  setup.model_file = fields.file("model_file");
  setup.marker_file = fields.file("marker_file");
  setup.coordinate_file = fields.file("coordinate_file");
  setup.output_motion_file = fields.file("output_motion_file");
  setup.results_directory = fields.file("results_directory");
  std::tie(setup.from, setup.to) = fields.time_range("time_range");
  // OpenSim gives its oldest tool the weight 20 when it converts it.
  const double unassigned =
      string_view(tool.name()) == "IKTool" ? 20.0 : std::numeric_limits<double>::infinity();
  setup.constraint_weight = fields.number("constraint_weight").value_or(unassigned);
  if (setup.constraint_weight < 0.0) {
    xml.fail(fields.find("constraint_weight"),
             {"<constraint_weight> is negative", "0 or more, or Inf",
              fields.text("constraint_weight"), "Correct the value."});
  }
  setup.accuracy = fields.number("accuracy").value_or(setup.accuracy);
  if (!(setup.accuracy > 0.0) || std::isinf(setup.accuracy)) {
    xml.fail(fields.find("accuracy"), {"<accuracy> is no accuracy", "a number above 0",
                                       fields.text("accuracy"), "Correct the value."});
  }
  setup.task_set = read_tasks_of(xml, fields, tool);
  return setup;
}

}  // namespace

IkSetup read_ik_setup(const fs::path& path) { return parse_setup(XmlFile(path)); }

IkTaskSet read_ik_task_set(const fs::path& path) {
  const XmlFile xml(path);
  const pugi::xml_node node =
      find_tool(xml, {"IKTaskSet", "InverseKinematicsTool", "InverseKinemtaticsTool", "IKTool"});
  if (string_view(node.name()) != "IKTaskSet") return parse_setup(xml).task_set;
  return parse_task_set(xml, node);
}

}  // namespace sinew
